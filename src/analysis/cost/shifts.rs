//! Shifts of corners and lines from the reference.

use glam::DVec2;
/// Sizes of shifts, in px.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Shifts {
    /// How many were measured.
    pub n: usize,
    /// sqrt(sum d^2 / n)
    pub rms: f64,
    /// Ninety-nine of a hundred are below this.
    pub p99: f64,
    /// The largest.
    pub max: f64,
}

impl Shifts {
    /// The sizes of `shifts_px`; `None` of none.
    pub(crate) fn of(shifts_px: &[f64]) -> Option<Self> {
        use crate::num::stats::{max_abs, quantile, rms};
        let sizes: Vec<f64> = shifts_px.iter().map(|s| s.abs()).collect();
        let p99 = quantile(&sizes, 0.99)?;
        Some(Self { n: sizes.len(), rms: rms(&sizes), p99, max: max_abs(&sizes) })
    }
}

/// The shift in px that a difference on the board stands for, given d board / d px.
pub(super) fn shift_px(jacobian: glam::DMat2, difference_mm: DVec2) -> f64 {
    (jacobian.inverse() * difference_mm).length()
}
