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
    let judged = |(name, scene)| judge_design(name, scene, Asked { budget: false }, observer);
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

/// What is asked of a judgement besides the figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Asked {
    /// The budget of every corner's error.
    pub budget: bool,
}

/// Pixels that are rendered to judge one of a scene's prisms.
pub fn pixels(scene: &Scene, asked: Asked) -> u64 {
    let boards = 1 + other_depths(scene).count() as u64;
    let pictures = boards + if asked.budget { budget::pictures(&scene.effects) } else { 0 };
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
    asked: Asked,
    observer: &dyn Observer,
) -> Result<JudgedDesign, Error> {
    observer.stage("design");
    let system = system::build(&scene)?;
    let (film, judgement) = judge(&scene, &system, observer);
    let budget = if asked.budget {
        observer.stage("budget");
        Some(budget::budget(&scene, &system, &judgement.view, observer)?)
    } else {
        None
    };
    Ok(JudgedDesign { name, scene, system, film, judgement, budget })
}
