//! A scene as it is written: the keys of the file in the file's units, each with its range.
//!
//! These types are the one source of the shipped JSON Schema, of the structural rules that [`super::structure`]
//! applies, and of the words in its messages: a field's comment is what an editor shows and what a user reads as help.

pub(super) use super::camera_keys::CameraFile;
pub(super) use super::effects::lens::QuadratureFile;
pub(super) use super::effects::tables::{EffectTables, EffectsFile};
use super::limits::*;
use super::model::Analysis;
use super::object_keys::ObjectFile;
use super::prism_tables::PrismFile;
use super::texture_keys::TextureFile;
use super::tidy::tidy;
use crate::accuracy::COARSEST_TARGET_PX;
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, transform};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::sync::LazyLock;

/// A camera, the prism in front of it and the board behind. Lengths are in mm (pixel pitch in um)
/// and angles in deg; +x is right, +y down, +z from the camera to the board.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "A scene of biprism")]
pub(super) struct SceneFile {
    /// Short name, used in titles and file names: lower-case letters, digits, - and _.
    #[schemars(length(min = 1, max = NAME_CHARS), regex(pattern = r"^[a-z0-9_][a-z0-9_-]*$"))]
    pub(super) name: String,
    /// What is asked of the simulation.
    #[serde(default)]
    pub(super) accuracy: AccuracyFile,
    /// The pinhole camera; it looks along +z where nothing turns it. A facet angle that is left out and the design of a freeform
    /// prism are those of the plain pinhole of its focal length, whose axis runs along +z through the middle of the sensor; figures
    /// of a prism are counted where that would see the corners.
    pub(super) camera: CameraFile,
    /// The glass in front of the camera.
    pub(super) prism: PrismFile,
    /// The checkerboard.
    pub(super) board: BoardFile,
    /// Objects besides the board: planes with squares or a texture, each of which hides what lies behind it.
    #[serde(default)]
    #[schemars(length(max = OBJECTS))]
    pub(super) object: Vec<ObjectFile>,
    /// Which of the effects that the scene has a table for are simulated.
    #[serde(default)]
    pub(super) effects: EffectsFile,
    /// What the picture shows besides geometry: a table for each effect.
    #[serde(default)]
    pub(super) effect: EffectTables,
    /// How effects that are averages are sampled.
    #[serde(default)]
    pub(super) quadrature: QuadratureFile,
    /// How pictures are written.
    #[serde(default)]
    pub(super) output: OutputFile,
    /// How the studies sample the scene.
    #[serde(default)]
    pub(super) analysis: AnalysisFile,
    /// Claims of the scene about its own result.
    #[serde(default)]
    #[schemars(length(max = CLAIMS))]
    pub(super) expect: Vec<ExpectFile>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum AccuracyFile {
    Level(LevelFile),
    Target(TargetFile),
}

impl Default for AccuracyFile {
    fn default() -> Self {
        Self::Level(LevelFile::Standard)
    }
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum LevelFile {
    Draft,
    Standard,
    Exact,
    Reference,
}

/// The cheapest level that keeps edges and corners as true as asked.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TargetFile {
    /// No edge or corner may lie farther than this from where the reference has it, in px.
    #[schemars(range(max = COARSEST_TARGET_PX), extend("exclusiveMinimum" = 0))]
    pub(super) target_px: f64,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BoardFile {
    /// Squares in x.
    #[schemars(range(min = 1, max = SIDE_SQUARES))]
    pub(super) columns: usize,
    /// Squares in y.
    #[schemars(range(min = 1, max = SIDE_SQUARES))]
    pub(super) rows: usize,
    /// Side of a square, in mm.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) square_mm: f64,
    /// Position [x, y, z] of the middle of the squares, in mm.
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) position_mm: [f64; 3],
    /// Tilt [rx, ry, rz] of the board about the fixed x, then y, then z axis, in deg.
    #[serde(default)]
    #[schemars(inner(range(min = -TILT_DEG, max = TILT_DEG)))]
    pub(super) tilt_deg: [f64; 3],
    /// Whether `biprism measure` takes `position_mm` and `tilt_deg` for the board's place in the picture while the corners agree
    /// with them ("stated"), or fits the six numbers to the corners in any case ("fit"): then they say which of places that look
    /// alike is meant, and a guess will do. Pictures are rendered with the board at `position_mm`.
    #[serde(default)]
    pub(super) pose: BoardPoseFile,
    /// Width of the white margin around the squares, in mm. Left out, it is one square.
    #[schemars(range(min = 0, max = LONGEST_MM))]
    pub(super) margin_mm: Option<f64>,
    /// What the board shows in place of its squares: "noise" or "chart", or a table with a picture's file or with settings of the
    /// two. A board with a texture has no corners.
    pub(super) texture: Option<TextureFile>,
    /// Radiance of a black square, of full scale 1.
    #[serde(default = "black")]
    #[schemars(range(min = 0, max = RADIANCE))]
    pub(super) black: f64,
    /// Radiance of a white square and of the margin, of full scale 1.
    #[serde(default = "white")]
    #[schemars(range(min = 0, max = RADIANCE))]
    pub(super) white: f64,
    /// Radiance around the board, of full scale 1.
    #[serde(default = "background")]
    #[schemars(range(min = 0, max = RADIANCE))]
    pub(super) background: f64,
}

#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum BoardPoseFile {
    #[default]
    Stated,
    Fit,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct OutputFile {
    /// How linear radiance is coded in a PNG. Left out, "srgb"; "linear" where `effect.sensor.gamma` has coded it already.
    pub(super) encoding: Option<EncodingFile>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum EncodingFile {
    Linear,
    Srgb,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct AnalysisFile {
    /// Distances from the camera along z at which the pinhole deviation is judged, in mm; left out: half, once and twice the
    /// distance of the board's centre.
    #[schemars(length(min = 1, max = DEPTHS), inner(range(min = SHORTEST_MM, max = LONGEST_MM)))]
    pub(super) depths_mm: Option<Vec<f64>>,
    /// Points along each side of the uniform grid over a half image.
    #[schemars(range(min = SMALLEST_GRID, max = LARGEST_GRID))]
    pub(super) grid: usize,
}

impl Default for AnalysisFile {
    fn default() -> Self {
        Self { depths_mm: None, grid: Analysis::GRID }
    }
}

/// A claim: a number of the report and its bounds, one or both.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ExpectFile {
    /// Path of the number in the report, such as freeform/pinhole/designed/mean_abs_v_mm.
    #[schemars(length(min = 1, max = PATH_CHARS))]
    pub(super) value: String,
    /// Smallest allowed value.
    #[schemars(range(min = -CLAIM, max = CLAIM))]
    pub(super) min: Option<f64>,
    /// Largest allowed value.
    #[schemars(range(min = -CLAIM, max = CLAIM))]
    pub(super) max: Option<f64>,
}

fn background() -> f64 {
    0.3
}

/// The JSON Schema (draft 7, which the TOML plugins of editors read) of a scene file, without references.
pub(super) static SCHEMA: LazyLock<Value> = LazyLock::new(|| {
    let settings = SchemaSettings::draft07().with(|s| s.inline_subschemas = true);
    let settings = settings.with_transform(transform::RecursiveTransform(tidy));
    let mut whole = settings.into_generator().into_root_schema_for::<SceneFile>();
    // What the file is comes first in it.
    let mut ordered = Map::new();
    for key in ["$schema", "title", "description"] {
        ordered.extend(whole.as_object_mut().and_then(|o| o.shift_remove_entry(key)));
    }
    ordered.extend(whole.as_object_mut().map(std::mem::take).into_iter().flatten());
    Value::Object(ordered)
});

/// The JSON Schema of a scene file as text, with every key's range, default and description; shipped as
/// `schemas/scene.schema.json` for editors.
pub fn schema_json() -> String {
    let mut text = serde_json::to_string_pretty(&*SCHEMA).expect("a JSON value has a JSON text");
    text.push('\n');
    text
}
