//! What accuracy is asked of a computation. A leaf: plain numbers, each with what it buys.

/// The knobs of the simulator. The three presets are promises about positions in px; any field may be changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// A freeform surface's intersection is accepted when the ray's distance to it along z is below this, in mm.
    /// 1e-12 mm moves a board point by less than 1e-10 px in the paper's scene.
    pub surface_residual_mm: f64,
    /// A pixel is divided until the bend of the map pixel -> board inside each part is below this, in px.
    pub bend_px: f64,
    /// Side of the largest division of one pixel, so at most `max_division`^2 parts.
    pub max_division: u32,
    /// `system::aim` stops when a Newton step is below this, in px.
    pub aim_px: f64,
}

impl Accuracy {
    /// Every pixel traced and covered exactly. Edge positions keep to 1e-5 px of [`Accuracy::reference`].
    pub const fn standard() -> Self {
        Self { surface_residual_mm: 1e-12, bend_px: 2e-5, max_division: 8, aim_px: 1e-11 }
    }

    /// Slow and simple: every pixel that holds an edge is divided finely. Judges the other levels.
    pub const fn reference() -> Self {
        Self { surface_residual_mm: 1e-13, bend_px: 1e-7, max_division: 64, aim_px: 1e-12 }
    }
}
