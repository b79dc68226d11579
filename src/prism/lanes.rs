//! Packets of vectors and rays, one in each lane.
//!
//! Every line repeats one of the scalar trace, so that lanes have its bits.

use crate::geom::{Pose, Ray};
use crate::num::simd::Lanes;
use glam::{DMat3, DVec3};

/// A vector in every lane.
#[derive(Debug, Clone, Copy)]
pub struct Vectors {
    /// x
    pub x: Lanes,
    /// y
    pub y: Lanes,
    /// z
    pub z: Lanes,
}

impl Vectors {
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(v: DVec3) -> Self {
        Self { x: Lanes::splat(v.x), y: Lanes::splat(v.y), z: Lanes::splat(v.z) }
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }

    #[inline(always)]
    pub(super) fn minus(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }

    #[inline(always)]
    pub(super) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    #[inline(always)]
    pub(super) fn times(self, s: Lanes) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> Lanes {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The vectors at unit length.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self.times(Lanes::splat(1.0) / self.dot(self).sqrt())
    }
}

/// A packet of rays.
#[derive(Debug, Clone, Copy)]
pub struct Rays {
    /// Starts, in mm.
    pub origin: Vectors,
    /// Unit directions.
    pub direction: Vectors,
}

impl Rays {
    /// A packet of as many rays as there are lanes.
    pub(crate) fn packed(rays: &[Ray]) -> Self {
        let vectors = |of: fn(&Ray) -> DVec3| Vectors {
            x: Lanes::of(|k| of(&rays[k]).x),
            y: Lanes::of(|k| of(&rays[k]).y),
            z: Lanes::of(|k| of(&rays[k]).z),
        };
        Self { origin: vectors(|ray| ray.origin), direction: vectors(|ray| ray.direction) }
    }

    /// One of its rays.
    pub(crate) fn lane(&self, k: usize) -> Ray {
        let vector = |v: &Vectors| DVec3::new(v.x.0[k], v.y.0[k], v.z.0[k]);
        Ray { origin: vector(&self.origin), direction: vector(&self.direction) }
    }

    #[inline(always)]
    pub(super) fn at(&self, t_mm: Lanes) -> Vectors {
        self.origin.plus(self.direction.times(t_mm))
    }

    /// The same rays in the frame `a`, given `a_from_b` and the rays in `b`.
    #[inline(always)]
    pub fn moved(&self, a_from_b: &Pose) -> Self {
        // Turning by nothing changes no bit, and is left out.
        let upright = a_from_b.rotation == DMat3::IDENTITY;
        let turned = |v: Vectors| {
            if upright {
                return v;
            }
            let [x, y, z] = [a_from_b.rotation.x_axis, a_from_b.rotation.y_axis, a_from_b.rotation.z_axis];
            Vectors::splat(x).times(v.x).plus(Vectors::splat(y).times(v.y)).plus(Vectors::splat(z).times(v.z))
        };
        let origin = turned(self.origin).plus(Vectors::splat(a_from_b.translation_mm));
        Self { origin, direction: turned(self.direction) }
    }
}
