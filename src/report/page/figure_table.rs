//! The table of figures in a page: every number with what it means.

use crate::report::json::{Design, Figure};
use crate::report::metric_meaning::meaning;
use crate::report::number::number;
use crate::report::table;
use serde::Serialize;

/// A row of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct MetricRow {
    label: String,
    /// Whether it belongs to the row above.
    under: bool,
    formula: &'static str,
    trap: &'static str,
    source: &'static str,
    key: &'static str,
    cells: Vec<MetricCell>,
}

/// A number of each prism.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct MetricCell {
    measured: String,
    exact: Option<String>,
    /// The signs behind it, which the remarks explain: ` !`, ` *`.
    mark: String,
    /// How it was taken.
    note: String,
}

/// The rows of the table of these prisms.
pub(super) fn metric_rows(designs: &[Design]) -> Vec<MetricRow> {
    let row = |row: table::Shown| {
        let known = meaning(&row.label);
        let cells = row.values.iter().zip(&row.figures).map(|(value, figure)| match figure {
            Some(figure) => MetricCell {
                measured: number(figure.measured),
                exact: Some(number(figure.exact)),
                mark: value.rsplit(" | ").next().map_or("", |last| last.trim_start_matches(|c| c != ' ')).to_owned(),
                note: note(figure),
            },
            None => MetricCell { measured: value.clone(), exact: None, mark: String::new(), note: String::new() },
        });
        MetricRow {
            under: row.label.starts_with(' '),
            formula: known.map_or("", |m| m.formula),
            trap: known.map_or("", |m| m.trap),
            source: known.map_or("", |m| m.source),
            key: known.map_or("", |m| m.key),
            cells: cells.collect(),
            label: row.label.trim_start().to_owned(),
        }
    };
    table::rows(designs).into_iter().map(row).collect()
}

/// How a figure was taken, in words.
fn note(figure: &Figure) -> String {
    let word = |value: serde_json::Result<serde_json::Value>| match value {
        Ok(serde_json::Value::String(text)) => text,
        _ => String::new(),
    };
    let normaliser = word(serde_json::to_value(figure.normaliser));
    let frame = word(serde_json::to_value(figure.frame));
    let counts = if figure.n == figure.n_true || figure.exact.is_none() {
        format!("N = {}", figure.n)
    } else {
        format!("N = {} measured, {} true", figure.n, figure.n_true)
    };
    let depths = figure.depths_mm.map(|[near, far]| match near == far {
        true => format!(", board at {} mm", table::rounded(near)),
        false => format!(", boards from {} to {} mm", table::rounded(near), table::rounded(far)),
    });
    let reason = figure.reason.as_ref().map(|reason| format!(". Missing: {reason}"));
    format!("{normaliser}, {counts}, {frame}{}{}", depths.unwrap_or_default(), reason.unwrap_or_default())
}
