//! A rectangle.

use glam::DVec2;

/// An axis-parallel rectangle `[min.x, max.x] x [min.y, max.y]`, in the unit of its user.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Smallest corner.
    pub min: DVec2,
    /// Largest corner.
    pub max: DVec2,
}

impl Rect {
    /// Whether the point lies inside or on the border.
    #[inline(always)]
    pub fn contains(&self, p: DVec2) -> bool {
        p.x >= self.min.x && p.x <= self.max.x && p.y >= self.min.y && p.y <= self.max.y
    }

    /// The rectangle grown by `margin` on every side.
    #[must_use]
    pub fn grown(&self, margin: f64) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// Width and height.
    pub fn size(&self) -> DVec2 {
        self.max - self.min
    }
}
