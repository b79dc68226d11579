//! What the accuracy of effects costs: a thin and a telecentric lens by the points of their pupil, and a prism of triangles by the
//! level, each against a finer picture with the same effect.

use super::lines::line_shifts;
use super::settings::CostSettings;
use super::shift_judge::rmse;
use super::shifts::Shifts;
use super::study::EffectSetting;
use super::time::Taken;
use crate::accuracy::{Accuracy, Level};
use crate::effect::telecentric::Telecentric;
use crate::effect::thin_lens::{Aperture, ThinLens};
use crate::effect::{Effects, Lens, Quadrature};
use crate::raster::Raster;
use crate::render::{Outputs, render_wanted};
use crate::scene::{PrismSpec, Scene};
use crate::surface::mesh::Normals;
use crate::system::tessellated::{Tessellated, used_part};
use crate::system::{self, System};

/// The thin lens: its f-number, and the distance at which it is in focus as a share of the board's.
const THIN: (f64, f64) = (4.0, 0.6);
/// The telecentric lens: its numerical aperture, and the same share.
const TELECENTRIC: (f64, f64) = (0.01, 0.95);
/// How much of the glass that the pinhole looks through the telecentric lens does, along each side.
const TELECENTRIC_PART: f64 = 0.8;

/// The knob of points that stand for the parts of a pupil around them.
pub const FILLED: &str = "filled";

/// An instrument that is timed, and what names it.
struct EffectRun {
    value: String,
    number: f64,
    system: System,
}

/// An effect with the instruments that are timed, and the one that takes the picture they are held against.
pub(super) struct EffectRuns {
    effect: &'static str,
    knob: &'static str,
    runs: Vec<EffectRun>,
    reference: System,
}

/// The effects that `scene`, whose instrument without effects is `plain`, can be seen with.
pub(super) fn all(scene: &Scene, plain: &System, settings: &CostSettings) -> Vec<EffectRuns> {
    let depth_mm = scene.board.world_from_board.translation_mm.z - scene.camera.position_mm.z;
    let (f_number, share) = THIN;
    let thin = ThinLens::new(f_number, share * depth_mm, Aperture::Circle, scene.camera.focal_length_mm);
    let lenses = [("thin_lens", Some(Lens::Thin(thin))), ("telecentric", telecentric(scene, plain, depth_mm))];
    let lenses = lenses.into_iter().flat_map(|(name, lens)| [(name, lens, false), (name, lens, true)]);
    let lenses = lenses.filter_map(|(name, lens, fill)| by_points(name, lens?, fill, scene, settings));
    lenses.chain(by_level(scene, plain, settings)).collect()
}

/// A telecentric lens whose field is a part of the glass that the pinhole looks through; `None` where that is not known, or the camera is
/// calibrated, which a telecentric one is not.
fn telecentric(scene: &Scene, plain: &System, depth_mm: f64) -> Option<Lens> {
    let [front, _] = used_part(plain)?;
    let camera = &scene.camera;
    if *camera != camera.plain() {
        return None;
    }
    let magnification = 0.5 * camera.width_px as f64 * camera.pitch_mm / (TELECENTRIC_PART * front.max.x);
    let (na, share) = TELECENTRIC;
    Some(Lens::Telecentric(Telecentric { magnification, na, focus_mm: share * depth_mm }))
}

/// A lens by the points of its pupil, which stand for the parts of it around them where `fill`; `None` where the scene cannot be
/// built with it, or has what is not filled.
fn by_points(
    effect: &'static str,
    lens: Lens,
    fill: bool,
    scene: &Scene,
    settings: &CostSettings,
) -> Option<EffectRuns> {
    if fill && !scene.objects.is_empty() {
        return None;
    }
    let of_points = |points: usize, fill: bool| {
        let quadrature = Quadrature { points, fill, ..Quadrature::default() };
        let effects = Effects { lens, quadrature, ..Effects::default() };
        system::build(&Scene { effects, accuracy: Accuracy::standard(), ..scene.clone() }).ok()
    };
    let run = |&points: &usize| {
        Some(EffectRun { value: points.to_string(), number: points as f64, system: of_points(points, fill)? })
    };
    let runs = settings.pupil_points.iter().map(run).collect::<Option<Vec<_>>>()?;
    let knob = if fill { FILLED } else { "points" };
    Some(EffectRuns { effect, knob, runs, reference: of_points(settings.pupil_reference, false)? })
}

/// The prism as triangles by the level; `None` without one, of one that is a mesh already, or where it is not asked for.
fn by_level(scene: &Scene, plain: &System, settings: &CostSettings) -> Option<EffectRuns> {
    let mesh = Tessellated::new(plain, settings.mesh_triangles?, Normals::Smooth)?.spec(scene.prism.body()?);
    let scene = Scene { prism: PrismSpec::Mesh(mesh), effects: Effects::default(), ..scene.clone() };
    let built = system::build(&scene).ok()?;
    let levels = (1..).zip(Level::ALL).filter(|(_, level)| *level != Level::Reference);
    let run = |(k, level): (i32, Level)| {
        let system = built.with_accuracy(level.accuracy());
        EffectRun { value: level.name().to_owned(), number: f64::from(k), system }
    };
    let runs = levels.map(run).collect();
    Some(EffectRuns { effect: "mesh", knob: "level", runs, reference: built.with_accuracy(Accuracy::reference()) })
}

impl EffectRuns {
    /// Work to be timed: a picture of each.
    pub(super) fn pictures(&self) -> impl Iterator<Item = impl Fn() -> Raster<f32> + Sync> {
        self.runs.iter().map(|run| || picture(&run.system))
    }

    /// The settings, given the times of their pictures, in order.
    pub(super) fn judged(&self, taken: &[Taken]) -> Vec<EffectSetting> {
        let reference = picture(&self.reference);
        let pattern = &self.reference.board().pattern;
        let contrast = pattern.white - pattern.black;
        let setting = |(run, taken): (&EffectRun, &Taken)| {
            let made = picture(&run.system);
            EffectSetting {
                effect: self.effect,
                knob: self.knob,
                value: run.value.clone(),
                number: run.number,
                time_ms: taken.spread_ms(1.0),
                yardsticks: taken.in_yardsticks(reference.data().len() as f64),
                rmse: rmse(&made, &reference),
                lines_px: Shifts::of(&line_shifts(&made, &reference, contrast)),
            }
        };
        self.runs.iter().zip(taken).map(setting).collect()
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.runs.len()
    }
}

fn picture(system: &System) -> Raster<f32> {
    render_wanted(system, Outputs { truth: false }, &()).radiance
}
