//! A corner of a picture with its error.

use glam::DVec2;

/// A detected corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerMark {
    /// Column and row on the board, counted alike in both halves and in both panels.
    pub index: [i32; 2],
    /// Where it was detected, in px of the picture.
    pub position_px: DVec2,
    /// Detected position minus the place that the prism is designed for, in px.
    pub error_px: DVec2,
}
