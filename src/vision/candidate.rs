//! A corner candidate: a crossing of two edges.

use super::ring_test::Ring;
use glam::DVec2;

/// A crossing that passed the ring test.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub(super) position: DVec2,
    pub(super) ring: Ring,
}
