//! The main job: a scene's prism designed, rendered, detected and judged, the flat one against the freeform one.

use super::budget::{self, Budget};
use super::judge::{Judgement, judge, other_depths};
use crate::error::Error;
use crate::progress::Observer;
use crate::render::Film;
use crate::scene::{DesignSettings, PrismSpec, Scene};
use crate::system::{self, System};

/// One prism of a comparison, judged.
#[derive(Debug, Clone)]
pub struct JudgedDesign {
    /// `flat`, `freeform`, or the kind of the scene's own prism.
    pub name: &'static str,
    /// The scene with this prism.
    pub scene: Scene,
    /// Its instrument.
    pub system: System,
    /// The picture of the scene's own board, with its ground truth.
    pub film: Film,
    /// How far the pair is from two ideal pinhole cameras.
    pub judgement: Judgement,
    /// Where the error of each corner comes from, where it was asked for.
    pub budget: Option<Budget>,
}

/// The prisms of a scene, judged.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// The flat prism, then the freeform prism; a prism that is given by its surfaces alone.
    pub designs: Vec<JudgedDesign>,
}

impl Comparison {
    /// The design of this name.
    pub fn design(&self, name: &str) -> Option<&JudgedDesign> {
        self.designs.iter().find(|design| design.name == name)
    }
}

/// Judges the flat and the freeform prism of a scene, or the one prism that it gives by its surfaces.
///
/// `observer` hears what is done next, and how many more pixels were rendered ([`pixels`] in all).
///
/// # Errors
/// As [`prisms`], and when a prism cannot be designed.
pub fn compare(scene: &Scene, observer: &dyn Observer) -> Result<Comparison, Error> {
    let judged = |(name, scene)| judge_design(name, scene, JudgeOptions { budget: false }, observer);
    Ok(Comparison { designs: prisms(scene)?.into_iter().map(judged).collect::<Result<_, _>>()? })
}

/// The scene with its flat prism and with its freeform prism, by name. A prism given by its surfaces has no flat twin and
/// is judged alone.
///
/// # Errors
/// When the scene has no prism.
pub fn prisms(scene: &Scene) -> Result<Vec<(&'static str, Scene)>, Error> {
    let with = |prism: PrismSpec| Scene { prism, ..scene.clone() };
    Ok(match &scene.prism {
        PrismSpec::Flat(flat) => {
            vec![("flat", scene.clone()), ("freeform", with(PrismSpec::Freeform(*flat, DesignSettings::default())))]
        }
        PrismSpec::Freeform(flat, _) => vec![("flat", with(PrismSpec::Flat(*flat))), ("freeform", scene.clone())],
        PrismSpec::Polynomial(_) | PrismSpec::PointCloud(_) | PrismSpec::Mesh(_) => {
            vec![(scene.prism.kind(), scene.clone())]
        }
        PrismSpec::None => {
            return Err(Error::new(
                format!("scene {}", scene.name),
                "`prism.kind` is \"none\", and there is no prism to judge",
                "give the scene a prism, or use `biprism render`",
            ));
        }
    })
}

/// What a judgement holds besides the figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JudgeOptions {
    /// The budget of every corner's error.
    pub budget: bool,
}

/// Pixels that are rendered to judge one of a scene's prisms.
pub fn pixels(scene: &Scene, options: JudgeOptions) -> u64 {
    let boards = 1 + other_depths(scene).count() as u64;
    let pictures = boards + if options.budget { budget::pictures(&scene.effects) } else { 0 };
    pictures * (scene.camera.width_px * scene.camera.height_px) as u64
}

/// Builds, renders and judges the instrument of `scene`, under the name `name`. `observer` hears what is done next,
/// and how many more pixels were rendered.
///
/// # Errors
/// When the prism cannot be designed.
pub fn judge_design(
    name: &'static str,
    scene: Scene,
    options: JudgeOptions,
    observer: &dyn Observer,
) -> Result<JudgedDesign, Error> {
    observer.stage("design");
    let system = system::build(&scene)?;
    let (film, judgement) = judge(&scene, &system, observer);
    let budget = if options.budget {
        observer.stage("budget");
        Some(budget::budget(&scene, &system, &judgement.view, observer)?)
    } else {
        None
    };
    Ok(JudgedDesign { name, scene, system, film, judgement, budget })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Numbers;
    use crate::progress::OnPixels;
    use crate::scene;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// A scene without any symmetry: prism out of place, board turned about all axes.
    const ASYMMETRIC: &str = "name = \"asymmetric\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 320\n\
        height_px = 180\npixel_pitch_um = 33.0\n[prism]\nkind = \"freeform\"\nindex = 1.48\n\
        ridge_distance_mm = 78.472\nthickness_mm = 8.545\nposition_mm = [0.8, 0.3, 0.0]\ntilt_deg = [0.5, -0.8, 1.5]\n\
        [board]\ncolumns = 31\nrows = 31\nsquare_mm = 15.0\nposition_mm = [3.0, -2.0, 1000.0]\n\
        tilt_deg = [8.0, -6.0, 3.0]\n[analysis]\ndepths_mm = [850.0, 1000.0]\n";

    #[test]
    fn an_asymmetric_scene_is_compared_half_by_half() {
        let scene = scene::parse(ASYMMETRIC, "test", None).unwrap_or_else(|problem| panic!("{problem}"));
        let rendered = AtomicUsize::new(0);
        let count = |n: usize| {
            rendered.fetch_add(n, Ordering::Relaxed);
        };
        let found = compare(&scene, &OnPixels(count)).unwrap();
        assert_eq!(rendered.into_inner() as u64, 2 * pixels(&scene, JudgeOptions { budget: false }));
        for design in &found.designs {
            let judgement = &design.judgement;
            for (k, half) in judgement.halves.iter().enumerate() {
                let (seen, own) = (&judgement.detected[k], half.at(1000.0).unwrap());
                assert!(seen.found > 20 && seen.wrong == Some(0), "{}: {seen:?}", design.name);
                let (pooled, deviation) = (judgement.pooled.at(1000.0).unwrap(), own.designed.numbers(|d| d.rms));
                agree(design.name, deviation);
                // Neither half is the pool.
                assert_ne!(deviation.measured, pooled.designed.numbers(|d| d.rms).measured);
            }
            for numbers in [
                judgement.vertical_disparity_rms_px(),
                judgement.designed_corners_rms_px(),
                judgement.fitted_rms_px(),
                judgement.straightness_rms_px(),
            ] {
                agree(design.name, numbers);
            }
            assert!(judgement.detector_rms_px().is_some_and(|rms| rms < 0.005));
        }
        let [flat, freeform] = ["flat", "freeform"].map(|name| &found.design(name).unwrap().judgement);
        let better = |of: fn(&Judgement) -> Numbers| of(freeform).measured < of(flat).measured;
        assert!(better(Judgement::fitted_rms_px));
    }

    /// What is measured is what is true, but for the detector's error.
    fn agree(name: &str, numbers: Numbers) {
        let (Some(measured), Some(exact)) = (numbers.measured, numbers.exact) else { panic!("{name}: {numbers:?}") };
        assert!((measured - exact).abs() < 0.005 && exact > 0.0, "{name}: {numbers:?}");
    }

    #[test]
    fn a_scene_without_a_prism_has_nothing_to_judge() {
        let scene = scene::parse(ASYMMETRIC, "test", None).unwrap_or_else(|problem| panic!("{problem}"));
        let kinds = |prism: PrismSpec| {
            Ok::<Vec<_>, Error>(prisms(&Scene { prism, ..scene.clone() })?.iter().map(|p| p.0).collect())
        };
        assert_eq!(kinds(scene.prism.clone()), Ok(vec!["flat", "freeform"]));
        assert!(kinds(PrismSpec::None).unwrap_err().rule.contains("no prism to judge"));
    }
}
