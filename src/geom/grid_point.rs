//! A point of two surfaces on a grid of pixel positions.

use glam::DVec3;

/// Where one ray of the design meets the two surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridPoint {
    /// Offset from the half image's centre, in px: +u towards +x, +v towards +y (down in the image).
    pub u_px: f64,
    /// See `u_px`.
    pub v_px: f64,
    /// P on the front surface, in mm in the prism's frame.
    pub front_mm: DVec3,
    /// P' on the back surface, in mm in the prism's frame.
    pub back_mm: DVec3,
}
