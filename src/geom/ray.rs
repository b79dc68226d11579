//! A half-line.

use super::pose::Pose;
use glam::DVec3;

/// A half-line: the points `origin + t direction`, t >= 0, with a unit direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Start, in mm.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}

impl Ray {
    /// The point at distance `t_mm`.
    #[inline(always)]
    pub fn at(&self, t_mm: f64) -> DVec3 {
        self.origin + self.direction * t_mm
    }

    /// The same ray in the frame `a`, given `a_from_b` and the ray in `b`.
    #[inline(always)]
    pub fn moved(&self, a_from_b: &Pose) -> Self {
        Self { origin: a_from_b.point(self.origin), direction: a_from_b.vector(self.direction) }
    }
}
