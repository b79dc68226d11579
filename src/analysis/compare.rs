//! The main job: prisms designed, rendered, detected and judged: the flat one of a scene against its freeform one, or those of
//! several scenes.

use super::budget::{self, Budget};
use super::judge::{Judgement, judge, other_depths};
use crate::error::Error;
use crate::progress::Observer;
use crate::render::Film;
use crate::scene::{DesignSettings, PrismSpec, Scene};
use crate::system::{self, System};
use std::collections::BTreeSet;

/// One prism of a comparison, judged.
#[derive(Debug, Clone)]
pub struct JudgedDesign {
    /// `flat`, `freeform`, or the kind of the scene's own prism; of several scenes, the scene's name.
    pub name: String,
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
    judge_all(prisms(scene)?, observer)
}

/// Judges the prisms of several scenes, each as its scene gives it, under the names of [`named_apart`].
///
/// `observer` hears what is done next, and how many more pixels were rendered.
///
/// # Errors
/// When there are more than [`MOST_SCENES`], a scene has no prism, or a prism cannot be designed.
pub fn compare_scenes(scenes: &[Scene], observer: &dyn Observer) -> Result<Comparison, Error> {
    let names: Vec<&str> = scenes.iter().map(|scene| scene.name.as_str()).collect();
    judge_all(named_apart(&names, scenes.to_vec())?, observer)
}

fn judge_all(prisms: Vec<(String, Scene)>, observer: &dyn Observer) -> Result<Comparison, Error> {
    let judged = |(name, scene): (String, Scene)| judge_design(&name, scene, JudgeOptions { budget: false }, observer);
    Ok(Comparison { designs: prisms.into_iter().map(judged).collect::<Result<_, _>>()? })
}

/// Scenes of one comparison, at most.
pub const MOST_SCENES: usize = 8;
/// Names of files of a comparison that no prism may have.
const TAKEN: [&str; 5] = ["comparison", "overview", "budget", "report", "cameras"];

/// Several scenes with the names of their prisms: those of the scenes, where no two are alike, else `fallbacks`, and what is
/// still alike, or the name of another file of the comparison, with its number behind it.
///
/// # Errors
/// When there are more than [`MOST_SCENES`], or a scene has no prism.
pub fn named_apart(fallbacks: &[&str], scenes: Vec<Scene>) -> Result<Vec<(String, Scene)>, Error> {
    if scenes.len() > MOST_SCENES {
        return Err(Error::new(
            "the comparison",
            format!("there are {} scenes, and at most {MOST_SCENES} are compared at once", scenes.len()),
            "compare fewer at a time",
        ));
    }
    for scene in &scenes {
        prisms(scene)?;
    }
    let own: Vec<&str> = scenes.iter().map(|scene| scene.name.as_str()).collect();
    let apart = |names: &[&str]| names.iter().collect::<BTreeSet<_>>().len() == names.len();
    let names = if apart(&own) { own } else { fallbacks.to_vec() };
    let alike = |name: &str| names.iter().filter(|other| **other == name).count() > 1 || TAKEN.contains(&name);
    let named = |(k, name): (usize, &&str)| if alike(name) { format!("{name}-{}", k + 1) } else { (*name).to_owned() };
    let names: Vec<String> = names.iter().enumerate().map(named).collect();
    Ok(names.into_iter().zip(scenes).collect())
}

/// The scene with its flat prism and with its freeform prism, by name. A prism given by its surfaces has no flat twin and
/// is judged alone.
///
/// # Errors
/// When the scene has no prism.
pub fn prisms(scene: &Scene) -> Result<Vec<(String, Scene)>, Error> {
    let with = |prism: PrismSpec| Scene { prism, ..scene.clone() };
    let named: Vec<(&str, Scene)> = match &scene.prism {
        PrismSpec::Flat(flat) => {
            let settings = DesignSettings::of_sensor(scene.camera.width_px);
            vec![("flat", scene.clone()), ("freeform", with(PrismSpec::Freeform(*flat, settings)))]
        }
        PrismSpec::Freeform(flat, _) => vec![("flat", with(PrismSpec::Flat(*flat))), ("freeform", scene.clone())],
        PrismSpec::Polynomial(_) | PrismSpec::Revolved(_) | PrismSpec::PointCloud(_) | PrismSpec::Mesh(_) => {
            vec![(scene.prism.kind(), scene.clone())]
        }
        PrismSpec::None => {
            return Err(Error::new(
                format!("scene {}", scene.name),
                "`prism.kind` is \"none\", and there is no prism to judge",
                "give the scene a prism, or use `biprism render`",
            ));
        }
    };
    Ok(named.into_iter().map(|(name, scene)| (name.to_owned(), scene)).collect())
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
    name: &str,
    scene: Scene,
    options: JudgeOptions,
    observer: &dyn Observer,
) -> Result<JudgedDesign, Error> {
    observer.stage("design");
    let system = system::build(&scene)?;
    judge_built(name, scene, system, options, observer)
}

/// Renders and judges the instrument `system` of `scene`, as [`judge_design`] does.
///
/// # Errors
/// When the budget cannot be had.
pub fn judge_built(
    name: &str,
    scene: Scene,
    system: System,
    options: JudgeOptions,
    observer: &dyn Observer,
) -> Result<JudgedDesign, Error> {
    let (film, judgement) = judge(&scene, &system, observer);
    let budget = if options.budget {
        observer.stage("budget");
        Some(budget::budget(&scene, &system, &judgement.view, observer)?)
    } else {
        None
    };
    Ok(JudgedDesign { name: name.to_owned(), scene, system, film, judgement, budget })
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
                agree(&design.name, deviation);
                // Neither half is the pool.
                assert_ne!(deviation.measured, pooled.designed.numbers(|d| d.rms).measured);
            }
            for numbers in [
                judgement.vertical_disparity_rms_px(),
                judgement.designed_corners_rms_px(),
                judgement.fitted_rms_px(),
                judgement.straightness_rms_px(),
            ] {
                agree(&design.name, numbers);
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
            Ok::<Vec<_>, Error>(prisms(&Scene { prism, ..scene.clone() })?.into_iter().map(|p| p.0).collect())
        };
        assert_eq!(kinds(scene.prism.clone()), Ok(vec!["flat".to_owned(), "freeform".to_owned()]));
        assert!(kinds(PrismSpec::None).unwrap_err().rule.contains("no prism to judge"));
    }

    #[test]
    fn scenes_are_named_apart() {
        let scene = scene::parse(ASYMMETRIC, "test", None).unwrap_or_else(|problem| panic!("{problem}"));
        let called = |name: &str| Scene { name: name.to_owned(), ..scene.clone() };
        let names = |fallbacks: &[&str], own: &[&str]| -> Vec<String> {
            let scenes = own.iter().map(|name| called(name)).collect();
            named_apart(fallbacks, scenes).unwrap().into_iter().map(|named| named.0).collect()
        };
        assert_eq!(names(&["a", "b"], &["one", "two"]), ["one", "two"]);
        assert_eq!(names(&["a", "b"], &["one", "one"]), ["a", "b"]);
        assert_eq!(names(&["a", "a", "c"], &["one", "one", "two"]), ["a-1", "a-2", "c"]);
        assert_eq!(names(&["a", "b"], &["one", "comparison"]), ["one", "comparison-2"]);
        assert!(named_apart(&["a"; 9], vec![scene.clone(); 9]).unwrap_err().rule.contains("at most 8"));
        let none = Scene { prism: PrismSpec::None, ..scene.clone() };
        assert!(named_apart(&["a", "b"], vec![scene, none]).unwrap_err().rule.contains("no prism to judge"));
    }
}
