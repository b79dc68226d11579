//! The input of the comparison figure.

use super::bend::bends;
use super::corner_mark::CornerMark;
use crate::num::stats;
use crate::plot::axis;
use crate::raster::Raster;

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
    /// The prisms, two in a row; the zoom is placed where the first bends a line most.
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

/// A gain of 1, 2 or 5 times a power of ten with which the longer arrows of the worst panel are about as long as two
/// squares of the board are wide; 1 when there is nothing to go by.
pub fn suitable_gain(panels: &[Panel]) -> f64 {
    let steps: Vec<f64> = (panels.first().map(|first| bends(first.corners, first.seam_px)).unwrap_or_default())
        .values()
        .flat_map(|bend| bend.corners_px.windows(2).map(|pair| pair[0].distance(pair[1])))
        .collect();
    let long = |panel: &Panel| stats::quantile(&sizes(panel), 0.9).unwrap_or(0.0);
    let longest = panels.iter().map(long).fold(0.0, f64::max);
    match stats::quantile(&steps, 0.5) {
        Some(step) if longest > 0.0 => axis::round_below(2.0 * step / longest).max(1.0),
        _ => 1.0,
    }
}

/// Sizes of all errors of a panel that are numbers, in px.
pub(super) fn sizes(panel: &Panel) -> Vec<f64> {
    panel.corners.iter().filter(|c| drawable(c)).map(|c| c.error_px.length()).collect()
}

pub(super) fn drawable(corner: &CornerMark) -> bool {
    corner.position_px.is_finite() && corner.error_px.is_finite()
}
