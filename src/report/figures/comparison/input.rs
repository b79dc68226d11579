//! The input of the comparison figure.

use super::corner_mark::CornerMark;
use crate::num::stats;
use crate::plot::axis;
use crate::raster::Raster;
use glam::DVec2;
use std::collections::BTreeMap;

/// One prism: its picture and the corners in it.
#[derive(Debug, Clone)]
pub struct Panel<'a> {
    /// Name of the prism: "flat prism".
    pub name: String,
    /// The whole stereo image, linear, 0 black to 1 white; of any size.
    pub picture: &'a Raster<f32>,
    /// The corners of both halves.
    pub corners: &'a [CornerMark],
    /// Where the half images meet, in px from the left edge of the picture.
    pub seam_px: f64,
    /// Corners that were found, also those whose designed place is not known.
    pub found: usize,
}

/// A row of the table of figures.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureRow {
    /// What is measured, with its unit: "vertical disparity, RMS, px".
    pub label: String,
    /// The value for each panel, in words.
    pub values: Vec<String>,
}

/// All that the comparison shows.
#[derive(Debug, Clone)]
pub struct ComparisonInput<'a> {
    /// Heading.
    pub title: String,
    /// The prisms, two in a row; the corner with the largest vertical disparity in the first is enlarged.
    pub panels: Vec<Panel<'a>>,
    /// How many times its length an error arrow is drawn; see [`suitable_gain`].
    pub arrow_gain: f64,
    /// The table of figures; the first rows, when there are too many.
    pub figures: Vec<FigureRow>,
    /// The conclusion, one or two sentences.
    pub verdict: String,
    /// Width of the figure in px; held within 800..=4000. 2000 suits a page of text width.
    pub width_px: u32,
}

/// A gain of 1, 2 or 5 times a power of ten with which the longer arrows of the worst panel are at most about as long as a
/// square of the board is wide; 1 when there is nothing to go by.
pub fn suitable_gain(panels: &[Panel]) -> f64 {
    let steps = panels.first().map(steps_px).unwrap_or_default();
    let long = |panel: &Panel| stats::quantile(&sizes(panel), 0.9).unwrap_or(0.0);
    let longest = panels.iter().map(long).fold(0.0, f64::max);
    match stats::quantile(&steps, 0.5) {
        Some(step) if longest > 0.0 => axis::round_below(1.2 * step / longest).max(1.0),
        _ => 1.0,
    }
}

/// Distances from corners to their neighbours in the next column or row of their half, in px.
fn steps_px(panel: &Panel) -> Vec<f64> {
    let right = |corner: &CornerMark| corner.position_px.x >= panel.seam_px;
    let known: BTreeMap<(bool, [i32; 2]), DVec2> =
        panel.corners.iter().filter(|c| drawable(c)).map(|c| ((right(c), c.index), c.position_px)).collect();
    let step = |(&(right, [column, row]), px): (&(bool, [i32; 2]), &DVec2)| {
        let next = [[column.saturating_add(1), row], [column, row.saturating_add(1)]];
        next.map(|index| Some(known.get(&(right, index))?.distance(*px))).into_iter().flatten().collect::<Vec<_>>()
    };
    known.iter().flat_map(step).collect()
}

/// Sizes of all errors of a panel that are numbers, in px.
pub(super) fn sizes(panel: &Panel) -> Vec<f64> {
    panel.corners.iter().filter(|c| drawable(c)).map(|c| c.error_px.length()).collect()
}

pub(super) fn drawable(corner: &CornerMark) -> bool {
    corner.position_px.is_finite() && corner.error_px.is_finite()
}
