//! The manifest of a set: a line of JSON that says what was drawn, and a line a picture.

use super::super::identity;
use crate::analysis::dataset::{BoardLook, BoardPlaces, Dataset, DatasetPose, DrawRange, PlaceRanges};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

/// The form of these texts.
pub const MANIFEST_SCHEMA: &str = "biprism-dataset/1";

/// What the board of a scene shows where nothing else was asked for.
const OWN_LOOK: &str = "scene";

/// What a set is: the first line. Nothing in it depends on how many pictures are made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManifestHead {
    /// [`MANIFEST_SCHEMA`].
    pub schema: String,
    /// Version of the program.
    pub biprism: String,
    /// Name of the scene.
    pub scene: String,
    /// Of the random numbers; as text, for JSON's numbers do not hold it.
    pub seed: String,
    /// Columns and rows of the whole picture.
    pub size_px: [usize; 2],
    /// Where pixel (i, j) has its centre in files of corners.
    pub pixel_centre: String,
    /// Where boards are drawn, or `listed`.
    pub places: Value,
    /// What boards show, one of these a picture.
    pub textures: Vec<String>,
    /// Range of the noise.
    pub noise: Option<[f64; 2]>,
    /// Range of the exposure.
    pub exposure: Option<[f64; 2]>,
    /// Which files there are of each picture.
    pub files: SetFiles,
    /// The checksums of the scene's instrument.
    pub instrument: Map<String, Value>,
    /// The scene's own text.
    pub scene_text: String,
}

/// Which files there are of each picture besides its scene and its true corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetFiles {
    /// Left and right half instead of the whole picture.
    pub halves: bool,
    /// What is true of every pixel.
    pub truth: bool,
    /// The corners that the detector finds.
    pub detected: bool,
}

impl SetFiles {
    /// The pictures of the picture of this number, by name.
    pub fn pictures(&self, number: u32) -> Vec<String> {
        self.by_half(number, "png")
    }

    /// The truth of it, where it is asked for.
    pub(crate) fn truths(&self, number: u32) -> Vec<String> {
        if self.truth { self.by_half(number, "exr") } else { Vec::new() }
    }

    fn by_half(&self, number: u32, ending: &str) -> Vec<String> {
        let halves: &[&str] = if self.halves { &["_left", "_right"] } else { &[""] };
        halves.iter().map(|half| format!("{number:06}{half}.{ending}")).collect()
    }

    /// Its scene.
    pub fn scene(number: u32) -> String {
        format!("{number:06}.toml")
    }

    /// Its true corners.
    pub fn corners(number: u32) -> String {
        format!("{number:06}_corners.csv")
    }

    /// The corners found in it, where they are asked for.
    pub fn detected(&self, number: u32) -> Option<String> {
        self.detected.then(|| format!("{number:06}_detected.csv"))
    }

    /// All of them.
    pub fn all(&self, number: u32) -> Vec<String> {
        let mut all = self.pictures(number);
        all.extend(self.truths(number));
        all.extend([Self::corners(number), Self::scene(number)]);
        all.extend(self.detected(number));
        all
    }
}

/// A picture: every other line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseLine {
    /// Its number, from 0 on.
    pub pose: u32,
    /// Distance of the board's middle from the camera along +z, in mm.
    pub distance_mm: f64,
    /// Angle between the board's normal and +z, in deg, where it was drawn.
    pub tilt_deg: Option<f64>,
    /// Turn of the board about its normal before that, in deg, where it was drawn.
    pub roll_deg: Option<f64>,
    /// What the board shows.
    pub texture: String,
    /// Standard deviation of the noise, of full scale 1, where it was drawn.
    pub noise: Option<f64>,
    /// Factor on the light of the board.
    pub exposure: f64,
    /// What its scene has other than the scene of the set, by key; null of a key that it lacks.
    pub values: Map<String, Value>,
    /// What was counted in it.
    pub counts: LookCounts,
    /// Its files.
    pub files: Vec<String>,
}

/// What was counted in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LookCounts {
    /// True corners in the left and the right half.
    pub corners: [usize; 2],
    /// Corners found in them, where they were sought.
    pub detected: Option<[usize; 2]>,
    /// Pixels that were brighter than full scale and are clamped.
    pub clamped_px: usize,
    /// Whether the picture keeps to the accuracy that its scene asks for.
    pub kept: bool,
}

impl ManifestHead {
    /// The head of `set`, a set of `scene`, whose text is `scene_text`.
    pub fn new(scene: &Scene, scene_text: &str, set: &Dataset, files: SetFiles) -> Self {
        let plan = set.plan();
        let ends = |range: &DrawRange| [range.low, range.high];
        let places = match &plan.places {
            BoardPlaces::Listed(_) => json!("listed"),
            BoardPlaces::Drawn(PlaceRanges { distance_mm, tilt_deg, roll_deg, in_view }) => json!({
                "distance_mm": ends(distance_mm),
                "tilt_deg": ends(tilt_deg),
                "roll_deg": ends(roll_deg),
                "in_view": in_view.name(),
            }),
        };
        Self {
            schema: MANIFEST_SCHEMA.to_owned(),
            biprism: env!("CARGO_PKG_VERSION").to_owned(),
            scene: scene.name.clone(),
            seed: plan.seed.to_string(),
            size_px: [scene.camera.width_px, scene.camera.height_px],
            pixel_centre: "(i + 0.5, j + 0.5)".to_owned(),
            places,
            textures: plan.looks.iter().map(|look| look.name().to_owned()).collect(),
            noise: plan.noise.as_ref().map(ends),
            exposure: plan.exposure.as_ref().map(ends),
            files,
            instrument: identity::parts(scene, set.system()),
            scene_text: scene_text.to_owned(),
        }
    }

    /// What of it is other in `found`, by its key.
    pub fn difference(&self, found: &Self) -> Option<String> {
        let keys = |head: &Self| serde_json::to_value(head).ok().and_then(|value| value.as_object().cloned());
        let (own, found) = (keys(self)?, keys(found)?);
        own.iter().find(|(key, value)| found.get(*key) != Some(value)).map(|(key, _)| key.clone())
    }
}

impl PoseLine {
    /// The line of a picture that was taken.
    pub fn new(pose: &DatasetPose, counts: LookCounts, files: Vec<String>) -> Self {
        let board = &pose.scene.board.world_from_board;
        Self {
            pose: pose.number,
            distance_mm: board.translation_mm.z - pose.scene.camera.position_mm.z,
            tilt_deg: pose.tilt_and_roll_deg.map(|[tilt, _]| tilt),
            roll_deg: pose.tilt_and_roll_deg.map(|[_, roll]| roll),
            texture: pose.look.map_or(OWN_LOOK, BoardLook::name).to_owned(),
            noise: pose.noise,
            exposure: pose.exposure,
            values: pose.values.clone(),
            counts,
            files,
        }
    }
}

/// `value` as a line of text.
pub fn line<T: Serialize>(value: &T) -> String {
    // Neither keys nor values can fail to be JSON: figures are finite.
    serde_json::to_string(value).unwrap_or_default() + "\n"
}
