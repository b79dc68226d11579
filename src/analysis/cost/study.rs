//! The study of cost as data.

use super::designs::DesignSetting;
use super::detector::Measured;
use super::meshes::Meshed;
use super::shifts::Shifts;
use super::time::Spread;
use crate::render::{AccuracyReport, Counts};

/// The study.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct CostStudy {
    /// The yardstick: ns of CPU time for one ray of [`calibration`](super::calibration).
    pub yardstick_ns: Spread,
    /// Columns and rows of a picture.
    pub size_px: [usize; 2],
    /// What the reference says of itself.
    pub reference: AccuracyReport,
    /// Corners whose exact positions were compared.
    pub corners: usize,
    /// Settings of the simulator.
    pub pictures: Vec<Setting>,
    /// The prism as triangles.
    pub meshes: Vec<Meshed>,
    /// Settings of the design; none where the scene does not design its prism.
    pub designs: Vec<DesignSetting>,
    /// Lenses and triangles in place of pinhole and surfaces.
    pub effects: Vec<EffectSetting>,
}

/// One setting of the simulator.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Setting {
    /// What was turned.
    pub knob: &'static str,
    /// To what, in words.
    pub value: String,
    /// To what, as a number, to be put on an axis.
    pub number: f64,
    /// CPU time of a picture on one thread, in ms.
    pub time_ms: Spread,
    /// The same, over that of the yardstick at one ray a pixel.
    pub yardsticks: Spread,
    /// How much work a picture was; of point samples only the rays are counted.
    pub counts: Counts,
    /// Root of the mean square of the pixels' difference from the reference, of full scale 1.
    pub rmse: f64,
    /// Shifts of the pattern's lines against the reference, from the pixels: at every crossing of a line by a row or a
    /// column of pixels, the integral of the difference across it over the contrast.
    pub lines_px: Option<Shifts>,
    /// Shifts of the board's corners: the distance of what a corner's exact position is said to see from the corner.
    /// `None` of point samples, which say nothing between them.
    pub corners_px: Option<Shifts>,
    /// What the corner detector finds in the picture.
    pub measured: Measured,
    /// What the level says of itself; `None` of point samples.
    pub account: Option<AccuracyReport>,
}

/// One setting of an effect.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct EffectSetting {
    /// `thin_lens`, `telecentric`, or `mesh` for the prism as triangles with the normals of their corners.
    pub effect: &'static str,
    /// What was turned: `points` of the pupil, or `level`.
    pub knob: &'static str,
    /// To what, in words.
    pub value: String,
    /// To what, as a number.
    pub number: f64,
    /// CPU time of a picture on one thread, in ms.
    pub time_ms: Spread,
    /// The same, over that of the yardstick at one ray a pixel.
    pub yardsticks: Spread,
    /// Root of the mean square of the pixels' difference from the finer picture, of full scale 1.
    pub rmse: f64,
    /// Shifts of the pattern's lines against the finer picture.
    pub lines_px: Option<Shifts>,
}
