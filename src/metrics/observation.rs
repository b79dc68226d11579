//! Observations, the input of the metrics: corners with their places in the world or in the other half.

use glam::{DVec2, DVec3};

/// A board corner found in both halves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Column and row of the corner on the board.
    pub index: [i32; 2],
    /// Position in the left half, in px from that half's own origin.
    pub left_px: DVec2,
    /// Position in the right half, in px from that half's own origin.
    pub right_px: DVec2,
}

/// A known point and where one half sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// The point in the world, in mm.
    pub point_mm: DVec3,
    /// Its image, in px from the half's own origin.
    pub image_px: DVec2,
}
