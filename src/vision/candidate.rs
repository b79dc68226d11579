//! A corner candidate: a crossing of two edges.

use super::ring_test::Ring;
use glam::{DVec2, IVec2};

/// The four neighbours of a cell of the lattice.
pub(super) const NEIGHBOURS: [IVec2; 4] = [IVec2::X, IVec2::NEG_X, IVec2::Y, IVec2::NEG_Y];

/// A crossing that passed the ring test.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// In px of the picture.
    pub(super) position: DVec2,
    /// Where it was found, in whatever resolution.
    pub(super) ring: Ring,
    /// Pixels of the picture along a side of a pixel of the resolution that it was found in.
    pub(super) scale: f64,
}

/// A crossing is that of a finer resolution within this, in pixels of its own.
const SAME_PX: f64 = 1.5;
/// Their bright lobes point the same way: the cosine of twice the difference is above this.
const ALIKE: f64 = 0.5;

impl Candidate {
    /// Within this distance, in px of the picture, a crossing of a finer resolution is this one.
    pub(super) fn same_px(&self) -> f64 {
        SAME_PX * self.scale
    }

    /// Whether the bright lobes of both point the same way.
    pub(super) fn is_alike(&self, other: &Self) -> bool {
        libm::cos(2.0 * (self.ring.lobe_rad - other.ring.lobe_rad)) > ALIKE
    }
}
