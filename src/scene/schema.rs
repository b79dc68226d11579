//! A scene as it is written: the keys of the file in the file's units, each with its range.
//!
//! These types are the one source of the shipped JSON Schema, of the structural rules that [`super::structure`]
//! applies, and of the words in its messages: a field's comment is what an editor shows and what a user reads as help.

pub(super) use super::effects::lens::QuadratureFile;
use super::effects::light::{d_line, glasses};
pub(super) use super::effects::tables::{EffectTables, EffectsFile};
use super::limits::*;
use super::surface_keys::{CloudFile, MeshPrismFile};
use super::tidy::tidy;
use crate::accuracy::COARSEST_TARGET_PX;
use crate::num::bernstein::MAX_DEGREE;
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
    /// The pinhole camera; it looks along +z.
    pub(super) camera: CameraFile,
    /// The glass in front of the camera.
    pub(super) prism: PrismFile,
    /// The checkerboard.
    pub(super) board: BoardFile,
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
pub(super) struct CameraFile {
    /// Distance from the pinhole to the sensor, in mm.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) focal_length_mm: f64,
    /// Columns of the sensor.
    #[schemars(range(min = 1, max = SIDE_PX))]
    pub(super) width_px: usize,
    /// Rows of the sensor.
    #[schemars(range(min = 1, max = SIDE_PX))]
    pub(super) height_px: usize,
    /// Side of a square pixel, in um.
    #[schemars(range(min = SMALLEST_PITCH_UM, max = LARGEST_PITCH_UM))]
    pub(super) pixel_pitch_um: f64,
    /// Position [x, y, z] of the pinhole, in mm.
    #[serde(default)]
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) position_mm: [f64; 3],
}

/// The glass in front of the camera.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum PrismFile {
    /// No glass at all.
    None {},
    /// Two plane facets that meet in a ridge along y, and a plane base.
    Flat(BiprismFile),
    /// Facets and base designed from the flat biprism, so that each half image is that of a pinhole.
    Freeform(FreeformFile),
    /// Front and back of the right half as polynomials; the left half is its mirror image.
    Polynomial(PolynomialFile),
    /// Front and back of the right half as points, to which polynomials are fitted; the left half is its mirror image.
    PointCloud(PointCloudFile),
    /// Front and back of the right half as triangles; the left half is their mirror image.
    Mesh(MeshPrismFile),
}

#[derive(Debug, Deserialize, JsonSchema)]
pub(super) struct BodyFile {
    /// Refractive index of the glass.
    #[schemars(range(min = SMALLEST_INDEX, max = LARGEST_INDEX))]
    pub(super) index: f64,
    /// Refractive index of what surrounds the glass.
    #[serde(default = "one")]
    #[schemars(range(min = SMALLEST_INDEX, max = LARGEST_INDEX))]
    pub(super) outer_index: f64,
    /// Name of the glass: how its index changes with the wavelength.
    #[schemars(extend("enum" = glasses()))]
    pub(super) glass: Option<String>,
    /// Wavelength in vacuum to which `index` belongs, in nm. Left out, it is that of the catalogues' n_d.
    #[serde(default = "d_line")]
    #[schemars(range(min = SHORTEST_WAVE_NM, max = LONGEST_WAVE_NM))]
    pub(super) wavelength_nm: f64,
    /// Position [x, y, z] of the prism's frame, in mm.
    #[serde(default)]
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) position_mm: [f64; 3],
    /// Tilt [rx, ry, rz] of the prism about the fixed x, then y, then z axis, in deg.
    #[serde(default)]
    #[schemars(inner(range(min = -TILT_DEG, max = TILT_DEG)))]
    pub(super) tilt_deg: [f64; 3],
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct BiprismFile {
    #[serde(flatten)]
    pub(super) body: BodyFile,
    /// Distance D from the camera to the ridge, in mm: z of the ridge in the prism's frame.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) ridge_distance_mm: f64,
    /// Thickness T from ridge to base, in mm.
    #[schemars(range(max = LONGEST_MM), extend("exclusiveMinimum" = 0))]
    pub(super) thickness_mm: f64,
    /// Slope of the facets, in deg; positive when the glass is thickest at the ridge. Left out, it is the angle that
    /// leaves the two views parallel.
    #[schemars(extend("exclusiveMinimum" = -FACET_DEG, "exclusiveMaximum" = FACET_DEG))]
    pub(super) facet_angle_deg: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct FreeformFile {
    #[serde(flatten)]
    pub(super) biprism: BiprismFile,
    /// How the surfaces are designed.
    #[serde(default)]
    pub(super) design: DesignFile,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct DesignFile {
    /// Which way the grid is marched: the centre row, then every column, or the centre column, then every row.
    pub(super) order: OrderFile,
    /// Total degree of the fitted polynomials.
    #[schemars(range(min = 1, max = DESIGN_DEGREE))]
    pub(super) degree: usize,
    /// The integrator.
    pub(super) method: MethodFile,
    /// Step of the march, in px of the sensor.
    #[schemars(range(min = SHORTEST_STEP_PX, max = LONGEST_STEP_PX))]
    pub(super) step_px: f64,
}

impl Default for DesignFile {
    fn default() -> Self {
        Self { order: OrderFile::XThenY, degree: 5, method: MethodFile::Rk4, step_px: 1.0 }
    }
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum OrderFile {
    XThenY,
    YThenX,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum MethodFile {
    Euler,
    Midpoint,
    Rk4,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct PolynomialFile {
    #[serde(flatten)]
    pub(super) body: BodyFile,
    /// The facet that faces the camera.
    pub(super) front: PatchFile,
    /// The surface that faces the board.
    pub(super) back: PatchFile,
}

/// z(x, y) in mm as a sum of c X^m Y^n, with X and Y the scaled distances from the centre.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PatchFile {
    /// Centre [x, y] of the polynomial, in mm.
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) centre_mm: [f64; 2],
    /// The lengths [sx, sy] by which x and y are divided, in mm.
    #[schemars(inner(range(min = SHORTEST_MM, max = LONGEST_MM)))]
    pub(super) scale_mm: [f64; 2],
    /// Where the surface may be used, [[x_min, x_max], [y_min, y_max]], in mm; the right half has x above 0.
    #[schemars(inner(inner(range(min = -LONGEST_MM, max = LONGEST_MM))))]
    pub(super) domain_mm: [[f64; 2]; 2],
    /// The terms [m, n, c] of the sum: powers of X and Y, and coefficient in mm.
    #[schemars(length(min = 1, max = TERMS))]
    pub(super) terms: Vec<TermFile>,
}

#[derive(Debug, Deserialize, JsonSchema)]
pub(super) struct TermFile(
    #[schemars(range(max = MAX_DEGREE))] pub(super) usize,
    #[schemars(range(max = MAX_DEGREE))] pub(super) usize,
    #[schemars(range(min = -LONGEST_MM, max = LONGEST_MM))] pub(super) f64,
);

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct PointCloudFile {
    #[serde(flatten)]
    pub(super) body: BodyFile,
    /// The facet that faces the camera.
    pub(super) front: CloudFile,
    /// The surface that faces the board.
    pub(super) back: CloudFile,
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
    /// Width of the white margin around the squares, in mm. Left out, it is one square.
    #[schemars(range(min = 0, max = LONGEST_MM))]
    pub(super) margin_mm: Option<f64>,
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
    /// Distances from the camera along z at which the pinhole deviation is judged, in mm.
    #[schemars(length(min = 1, max = DEPTHS), inner(range(min = SHORTEST_MM, max = LONGEST_MM)))]
    pub(super) depths_mm: Vec<f64>,
    /// Points along each side of the uniform grid over a half image.
    #[schemars(range(min = SMALLEST_GRID, max = LARGEST_GRID))]
    pub(super) grid: usize,
}

impl Default for AnalysisFile {
    fn default() -> Self {
        Self { depths_mm: vec![500.0, 1000.0, 2000.0], grid: 33 }
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

fn one() -> f64 {
    1.0
}

fn black() -> f64 {
    0.05
}

fn white() -> f64 {
    0.85
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
