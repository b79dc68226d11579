//! The error budget of a corner: the way from where an ideal pinhole sees it to where it was measured, in steps
//! that add up.
//!
//! ```text
//! ideal    the designed virtual camera's projection of the corner
//!   + optics     what the design leaves: where its marched surfaces put the corner, less ideal
//!   + fit        what the polynomials fitted to the marched points change: where the plain instrument puts it, less that
//!   + detector   the detector's error: the corner found in the plain picture, less where the plain instrument puts it
//!   + effects    found under the scene's effects but the sensor's, errors of manufacture among them, less in the plain one
//!   + sampling   what the judged picture adds: the corner found in it, less the one found before its sensor and level
//! measured
//! ```
//!
//! The plain instrument is the ideal one, without effects: a prism with errors as built, a stop and rims are effects,
//! and so optics and fit are those of the design whatever errors it has. Its picture is taken with every pixel traced
//! ([`Accuracy::exact`]). So sampling holds the level, the sensor with its noise, and the file. Where a scene does not
//! design its prism there is no fit, and optics reaches to the plain instrument; where it calls for no effect but the
//! sensor's there is no such step.
//!
//! The steps are differences of positions, so that they add up to measured - ideal but for rounding.

use super::board_indexing::Found;
use super::half_image::HalfFrame;
use super::truth::{self, TrueCorners};
use super::view::{BoardView, HalfView, see};
use crate::accuracy::Accuracy;
use crate::design::marched::Marched;
use crate::design::{self, DesignInput, FreeformDesign};
use crate::effect::Effects;
use crate::error::Error;
use crate::progress::Observer;
use crate::render::{Outputs, render_wanted};
use crate::scene::{DesignedSurface, PrismSpec, Scene};
use crate::surface::face::Face;
use crate::system::aim::Aimer;
use crate::system::{Side, System};
use glam::DVec2;
use std::collections::BTreeMap;

/// Newton's method for the marched surfaces gives up after this many steps; each gains some four digits.
const MOST_STEPS: usize = 20;
/// It is done when a step is below this, in px: the points are rounded to 1e-14 mm, which turns the normal between points
/// a tenth of a millimetre apart by 1e-13, and moves what a pixel sees a metre away by a billionth of a pixel.
const STEP_PX: f64 = 3e-8;

/// The budget of one corner; all in px of the half image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerErrors {
    /// Column and row on the board.
    pub index: [i32; 2],
    /// Where it was measured.
    pub measured_px: DVec2,
    /// Where the designed virtual camera sees it.
    pub ideal_px: DVec2,
    /// What the design leaves.
    pub optics_px: DVec2,
    /// What the polynomials change, where the prism is designed from points.
    pub fit_px: Option<DVec2>,
    /// The detector's own error.
    pub detector_px: DVec2,
    /// What effects, errors of manufacture among them, do to where the corner is found, where the scene calls for some
    /// besides the sensor.
    pub effects_px: Option<DVec2>,
    /// What sensor, level and file add.
    pub sampling_px: DVec2,
}

impl CornerErrors {
    /// Measured minus ideal.
    pub fn total_px(&self) -> DVec2 {
        self.measured_px - self.ideal_px
    }

    /// What the steps leave of the total: rounding.
    pub fn remainder_px(&self) -> DVec2 {
        let may_be = self.fit_px.unwrap_or_default() + self.effects_px.unwrap_or_default();
        self.total_px() - (self.optics_px + may_be + self.detector_px + self.sampling_px)
    }
}

/// The budget of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    /// Corners of the left and of the right half.
    pub halves: [Vec<CornerErrors>; 2],
    /// Measured corners without a budget: not found in one of the other pictures, or seen by no ray.
    pub left_out: usize,
}

/// The budget of the corners of `view`, of `scene`'s own picture through `system`.
/// `observer` hears how many pixels of the other pictures were rendered ([`pictures`]).
///
/// # Errors
/// When the scene's design cannot be made.
pub fn budget(scene: &Scene, system: &System, view: &BoardView, observer: &dyn Observer) -> Result<Budget, Error> {
    let design = match &scene.prism {
        // Surfaces of revolution are not fitted.
        PrismSpec::Freeform(_, settings) if settings.surface == DesignedSurface::Polynomial => {
            DesignInput::of(scene).map(|input| design::freeform(&input)).transpose()?
        }
        _ => None,
    };
    let plain_system = system.without_effects();
    let found_under = |effects: Effects| -> [Places; 2] {
        let under = plain_system.with_effects(&effects);
        let exact = under.with_accuracy(Accuracy::exact());
        let film = render_wanted(&exact, Outputs { truth: false }, observer);
        let view = see(&exact, &exact.effects().decoded(&film.radiance), false, &());
        view.halves.map(|half| half.found.iter().map(|f| (f.index, f.position_px)).collect())
    };
    let plain = found_under(Effects::default());
    let light = light_alone(system.effects()).map(found_under);
    let aimer = Aimer::new(&plain_system);
    let halves = [0, 1].map(|k| {
        let Some(truth) = truth::corners(&plain_system, &aimer, &view.halves[k].frame) else { return Vec::new() };
        let found = Pictures { plain: &plain[k], light: light.as_ref().map(|halves| &halves[k]) };
        half(&plain_system, &view.halves[k], &truth, &found, design.as_ref())
    });
    let found: usize = view.halves.iter().map(|half| half.found.len()).sum();
    let left_out = found - halves.iter().map(Vec::len).sum::<usize>();
    Ok(Budget { halves, left_out })
}

/// How many pictures [`budget`] renders.
pub fn pictures(effects: &Effects) -> u64 {
    1 + u64::from(light_alone(effects).is_some())
}

/// The effects without the sensor's, where one is left.
fn light_alone(effects: &Effects) -> Option<Effects> {
    let light = Effects { sensor: None, ..effects.clone() };
    let acts = light.acting().next().is_some();
    acts.then_some(light)
}

/// Where corners were found, by column and row.
type Places = BTreeMap<[i32; 2], DVec2>;

/// The corners of a half in the pictures that the judged one is compared with.
struct Pictures<'a> {
    /// Without effects.
    plain: &'a Places,
    /// With all but the sensor's, where there are such.
    light: Option<&'a Places>,
}

/// The corners of a half; `system` and `truth` are of the plain instrument.
fn half(
    system: &System,
    view: &HalfView,
    truth: &TrueCorners,
    pictures: &Pictures<'_>,
    design: Option<&FreeformDesign>,
) -> Vec<CornerErrors> {
    let one = |found: &Found| {
        let [column, row] = found.index.map(f64::from);
        let board_mm = system.board().corner_at(column, row);
        let ideal_px = view.ideal_px(system.board().world(board_mm))?;
        let true_px = truth.get(&found.index)?.position_px;
        let plain_px = *pictures.plain.get(&found.index)?;
        let light_px = match pictures.light {
            Some(light) => Some(*light.get(&found.index)?),
            None => None,
        };
        let marched_px = match design {
            Some(design) => Some(marched_px(system, &view.frame, design, board_mm, true_px)?),
            None => None,
        };
        Some(CornerErrors {
            index: found.index,
            measured_px: found.position_px,
            ideal_px,
            optics_px: marched_px.unwrap_or(true_px) - ideal_px,
            fit_px: marched_px.map(|marched_px| true_px - marched_px),
            detector_px: plain_px - true_px,
            effects_px: light_px.map(|light_px| light_px - plain_px),
            sampling_px: found.position_px - light_px.unwrap_or(plain_px),
        })
    };
    view.found.iter().filter_map(one).collect()
}

/// Where the instrument would see a point of the board if its surfaces went through the marched points, near to where it
/// does see it.
fn marched_px(
    system: &System,
    frame: &HalfFrame,
    design: &FreeformDesign,
    board_mm: DVec2,
    true_px: DVec2,
) -> Option<DVec2> {
    let marched = Marched::new(&design.cloud)?;
    let prism = system.prism()?;
    let side = frame.side();
    let jacobian = system.footprint_through(frame.full(true_px), side).ok()?.jacobian.inverse();
    let mut px = true_px;
    for _ in 0..MOST_STEPS {
        let ray = system.camera().ray(frame.full(px));
        let intersect = |face: Face, ray: &_| marched.intersect(face, ray, side == Side::Left);
        let out = prism.pass_shapes(&ray, side, intersect).ok()?;
        let (seen_mm, _) = system.board().intersect(&out).ok()?;
        let step = jacobian * (board_mm - seen_mm);
        px += step;
        if step.length() < STEP_PX {
            return Some(px);
        }
    }
    None
}
