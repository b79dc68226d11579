//! `report.json`: the stable contract `biprism-report/1` that others script against.
//!
//! One rule for numbers: whatever judges the optics is a [`Figure`], an object with the value from detected corners,
//! the value from the exact inverse trace, their count, and all that is needed to compare it with another program's.
//! Counts, depths, seconds and the detector's own error (which *is* measured against true) are bare numbers. Nothing is
//! NaN: a value that does not exist is `null`, and the figure's `reason` says why.
//!
//! Keys may be added under the same schema name; none is renamed, removed or given another meaning.

use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, generate::SchemaSettings, transform::RecursiveTransform};
use serde::{Deserialize, Serialize};
use serde_json::Value;

pub mod budget;
pub mod figure;
pub mod judgement;

pub use budget::{BudgetTerm, CornerBudget, ErrorBudget};
pub use figure::{Definition, Figure, Frame, Normaliser, PixelCentre, Unit};

/// A whole report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// Name and version of this format.
    pub schema: SchemaName,
    /// Name of the scene, or of the picture that was measured.
    pub scene: String,
    /// One entry for each prism judged.
    pub designs: Vec<Design>,
}

/// Name and version of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum SchemaName {
    /// The only one so far.
    #[serde(rename = "biprism-report/1")]
    V1,
}

/// One prism, judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// `flat`, `freeform`, or the scene's own name for it.
    pub name: String,
    /// Each half by itself.
    pub halves: Halves,
    /// Left against right.
    pub stereo: Stereo,
    /// Both halves, pooled, against their pinholes.
    pub pinhole: Pinhole,
    /// Corners of both halves together.
    pub corners: Corners,
    /// How the rays ended, by name of the fate.
    pub fates: BTreeMap<String, u64>,
    /// Seconds of wall-clock time, by step.
    pub timing_s: BTreeMap<String, f64>,
    /// How accurately the picture was made; absent where it was not made here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// Where the error of a corner comes from, when it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_budget: Option<ErrorBudget>,
}

/// How accurately a picture was made: shifts of its lines and corners, in px.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Accuracy {
    /// `draft`, `standard`, `exact` or `reference`.
    pub level: String,
    /// What was asked for, where the level was chosen by that: the cheapest that promises it.
    pub target_px: Option<f64>,
    /// What the level promises against the reference.
    pub promise_px: f64,
    /// What it kept to, as far as the picture itself can tell: error of the map, and bend left inside pixels.
    pub achieved_px: f64,
    /// Pixels that were divided as often as allowed and not as often as it takes.
    pub capped_pixels: u64,
    /// Pixels at borders of the light, for which the promise does not hold; absent where there are none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub unpromised_pixels: u64,
}

/// Whether nothing was counted.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// The two halves of the image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Halves {
    /// Columns `0..width / 2`.
    pub left: Half,
    /// Columns from `width / 2` rounded up to `width`; the middle column of an odd width is in neither half.
    pub right: Half,
}

/// One half of the image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Half {
    /// Its corners.
    pub corners: Corners,
    /// It against its pinhole.
    pub pinhole: Pinhole,
}

/// Left against right, on the raw halves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stereo {
    /// Of y_L - y_R: ROS's epipolar error, but without rectification.
    pub vertical_disparity_rms_px: Figure,
    /// Of y_L - y_R.
    pub vertical_disparity_max_px: Figure,
    /// Mean of y_L - y_R, signed.
    pub vertical_disparity_mean_px: Figure,
    /// OpenCV's "average epipolar err" for horizontal epipolar lines: 2 mean |y_L - y_R|.
    pub opencv_average_epipolar_px: Figure,
    /// Largest |slope| of an epipolar curve's best line.
    pub epipolar_slope_max_rad: Figure,
    /// Mean |slope|.
    pub epipolar_slope_mean_rad: Figure,
    /// Rise of the steepest line over the width of a half image.
    pub epipolar_rise_max_px: Figure,
    /// Perpendicular distances of the curves' samples from their best lines.
    pub epipolar_departure_rms_px: Figure,
    /// The largest of these.
    pub epipolar_departure_max_px: Figure,
    /// Disparities x_L - x_R about the law offset + gain / depth of an ideal pair.
    pub depth_law_rms_px: Figure,
}

/// An image against a pinhole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pinhole {
    /// Against the designed virtual camera, nothing fitted: rays on its virtual image plane.
    pub designed: Designed,
    /// Against the pinhole that fits best.
    pub fitted: Fitted,
    /// Against the best pinhole with two focal lengths, where one was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub anamorphic: Option<Fitted>,
    /// Inner corners of rows and columns from the chord of the end corners (ROS linearity, which takes rows only).
    pub straightness_rms_px: Figure,
    /// The largest of these.
    pub straightness_max_px: Figure,
    /// The rays against one centre, where rays were traced or corners seen at several depths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre: Option<Centre>,
    /// The same at each board depth, nearest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub depths: Vec<Depth>,
}

/// Against the designed virtual camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Designed {
    /// Horizontal: Table 1 of the design paper.
    pub mean_abs_h_mm: Figure,
    /// Vertical.
    pub mean_abs_v_mm: Figure,
    /// Horizontal, in px.
    pub mean_abs_h_px: Figure,
    /// Vertical, in px.
    pub mean_abs_v_px: Figure,
    /// Length of the error vectors.
    pub rms_px: Figure,
    /// The longest.
    pub max_px: Figure,
}

/// Against a fitted pinhole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fitted {
    /// What was free in the fit; everything else as designed.
    pub free: Vec<String>,
    /// Length of the residual vectors; ROS's reprojection error is this over sqrt(2).
    pub rms_px: Figure,
    /// The longest.
    pub max_px: Figure,
}

/// The object-side rays against one centre of projection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Centre {
    /// From the designed centre to the point nearest to all rays.
    pub drift_mm: Figure,
    /// Distances of the rays from the point nearest to all: 0 for a central camera.
    pub miss_rms_mm: Figure,
    /// Distances of the rays from the designed centre.
    pub designed_miss_rms_mm: Figure,
}

/// A half (or both) at one depth of the board.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Depth {
    /// Distance of the board's centre from the camera along z, in mm.
    pub depth_mm: f64,
    /// Against the designed virtual camera, nothing fitted: corners against projected corners.
    pub designed: Designed,
    /// Against a pinhole fitted at this depth alone.
    pub fitted: Fitted,
    /// From the designed centre to that of the pinhole fitted at this depth.
    pub centre_drift_mm: Figure,
    /// As for the whole.
    pub straightness_rms_px: Figure,
}

/// What the detector did, judged by the exact positions where they are known.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Corners {
    /// Corners whose four squares lie wholly in their half; `null` where the truth is unknown.
    pub visible: Option<u64>,
    /// How many of these were found; all that were found, where the truth is unknown.
    pub found: u64,
    /// Corners found of which a square is cut by the border of the half.
    #[serde(default)]
    pub partial: u64,
    /// Found where there is none, or with a wrong index; `null` where the truth is unknown.
    #[serde(rename = "false")]
    pub spurious: Option<u64>,
    /// sqrt(sum |e|^2 / N) over the N = found + partial corners, of detected minus exact position, in px (pixel-edge
    /// convention).
    pub rms_error_px: Option<f64>,
    /// Largest |e|, in px.
    pub max_error_px: Option<f64>,
    /// Candidates given up, by reason.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub rejected: BTreeMap<String, u64>,
}

/// The report as it is written: indented, keys in the order of the types, a newline at the end.
pub fn to_text(report: &Report) -> String {
    let mut text = serde_json::to_string_pretty(report).expect("a report holds only strings, numbers and lists");
    text.push('\n');
    text
}

/// The JSON Schema (draft 2020-12) of what [`to_text`] writes; shipped as `schemas/report.schema.json`.
pub fn schema_json() -> String {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let settings = settings.with_transform(RecursiveTransform(|schema: &mut Schema| {
        // A description is one line, wherever its doc comment is wrapped.
        if let Some(Value::String(words)) = schema.get_mut("description") {
            *words = words.replace('\n', " ");
        }
    }));
    let schema = settings.into_generator().into_root_schema_for::<Report>();
    let mut text = serde_json::to_string_pretty(&schema).expect("a JSON value has a JSON text");
    text.push('\n');
    text
}

/// The number at `path`, such as `freeform/pinhole/designed/mean_abs_v_mm/true`: a design's name, then keys and places
/// in lists. A path that ends at a figure means its `measured`.
///
/// # Errors
/// A sentence that says where the path leaves the report and which keys there are, or why the figure has no value.
pub fn number_at(report: &Report, path: &str) -> Result<f64, String> {
    let mut steps = path.split('/');
    let name = steps.next().unwrap_or_default();
    let design = report.designs.iter().find(|d| d.name == name).ok_or_else(|| {
        let names: Vec<&str> = report.designs.iter().map(|d| d.name.as_str()).collect();
        format!("there is no design `{name}`; there is {}", names.join(", "))
    })?;
    let root = serde_json::to_value(design).expect("a report holds only strings, numbers and lists");
    let mut value = &root;
    for step in steps {
        let next = step.parse().map_or_else(|_| value.get(step), |place: usize| value.get(place));
        value = next.ok_or_else(|| format!("`{path}` has no `{step}`; there is {}", children(value)))?;
    }
    let number = if value.get("measured").is_some() { &value["measured"] } else { value };
    number.as_f64().ok_or_else(|| match value {
        Value::Object(_) if value.get("measured").is_some() => {
            let reason = value.get("reason").and_then(Value::as_str).unwrap_or("it was not measured");
            format!("`{path}` has no measured value ({reason}); `{path}/true` is the exact one")
        }
        Value::Object(_) | Value::Array(_) => format!("`{path}` is no number; it has {}", children(value)),
        _ => format!("`{path}` is {value}, no number"),
    })
}

fn children(value: &Value) -> String {
    match value {
        Value::Object(map) => map.keys().cloned().collect::<Vec<_>>().join(", "),
        Value::Array(list) => format!("a list of {}", list.len()),
        _ => "nothing below a number".to_owned(),
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
