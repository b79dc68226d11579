//! `report.json`: the stable contract `biprism-report/1` that others script against.
//!
//! One rule for numbers: whatever judges the optics is a [`Figure`], an object with the value from detected corners,
//! the value from the exact inverse trace, their count, and all that is needed to compare it with another program's.
//! Counts, depths, seconds and the detector's own error (which *is* measured against true) are bare numbers. Nothing is
//! NaN: a value that does not exist is `null`, and the figure's `reason` says why.
//!
//! Keys may be added under the same schema name; none is renamed, removed or given another meaning.

use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use serde_json::Value;

pub mod board_pose;
pub mod budget;
pub mod figure;
pub mod judgement;
pub mod fit;
pub mod cameras;

pub use board_pose::{BoardPoseEntry, BoardPoseSource, MatchedByName, MatchingEntry, PlacedByName};
pub use budget::{BudgetTerm, CornerBudget, ErrorBudget};
pub use cameras::{CameraEntry, Cameras, Geometry, PairPose};
pub use figure::{Definition, Figure, Frame, Normaliser, PixelCentreName, Unit};
pub use fit::{SurfaceFitEntry, SurfaceFits};

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
pub(crate) fn number_at(report: &Report, path: &str) -> Result<f64, String> {
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
mod tests;
mod document;

pub use document::{
    AccuracyEntry, Centre, Corners, Depth, Design, Designed, Fitted, HalfEntry, Halves, PinholeEntry, Report, RowLaw,
    SchemaName, Stereo,
};
