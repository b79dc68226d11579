//! Points, rays and frames, in f64 and mm. Transforms are named `a_from_b`.

use glam::{DMat3, DVec2, DVec3};

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

/// A rigid motion: rotation, then translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Rotation matrix.
    pub rotation: DMat3,
    /// Translation, in mm.
    pub translation_mm: DVec3,
}

impl Pose {
    /// The pose that moves nothing.
    pub const IDENTITY: Self = Self { rotation: DMat3::IDENTITY, translation_mm: DVec3::ZERO };

    /// Rotation by `angles_rad` about the fixed x, then y, then z axis, then the translation.
    pub fn new(translation_mm: DVec3, angles_rad: DVec3) -> Self {
        let (sx, cx) = libm::sincos(angles_rad.x);
        let (sy, cy) = libm::sincos(angles_rad.y);
        let (sz, cz) = libm::sincos(angles_rad.z);
        let about_x = DMat3::from_cols(DVec3::X, DVec3::new(0.0, cx, sx), DVec3::new(0.0, -sx, cx));
        let about_y = DMat3::from_cols(DVec3::new(cy, 0.0, -sy), DVec3::Y, DVec3::new(sy, 0.0, cy));
        let about_z = DMat3::from_cols(DVec3::new(cz, sz, 0.0), DVec3::new(-sz, cz, 0.0), DVec3::Z);
        Self { rotation: about_z * about_y * about_x, translation_mm }
    }

    /// A point carried along.
    #[inline(always)]
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.translation_mm
    }

    /// A vector carried along (rotation only).
    #[inline(always)]
    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.rotation * v
    }

    /// The motion that does `first`, then this.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        Self { rotation: self.rotation * first.rotation, translation_mm: self.point(first.translation_mm) }
    }

    /// The opposite motion.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation_mm: -(rotation * self.translation_mm) }
    }

    /// Whether this maps the plane x = 0 onto itself and mirror images in it onto mirror images, bit for bit.
    pub fn keeps_mirror_images(&self) -> bool {
        let r = &self.rotation;
        self.translation_mm.x == 0.0 && r.x_axis == DVec3::X && r.y_axis.x == 0.0 && r.z_axis.x == 0.0
    }

    /// Whether this is exactly [`Pose::IDENTITY`], so that it need not be applied.
    pub fn is_identity(&self) -> bool {
        *self == Self::IDENTITY
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pose_inverse_undoes_the_pose() {
        let pose = Pose::new(DVec3::new(1.0, -2.0, 3.0), DVec3::new(0.3, -0.8, 2.0));
        let p = DVec3::new(5.0, 7.0, -11.0);
        assert!((pose.inverse().point(pose.point(p)) - p).length() < 1e-14);
    }

    #[test]
    fn rotation_is_about_fixed_axes_in_the_order_x_y_z() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let pose = Pose::new(DVec3::ZERO, DVec3::new(quarter, 0.0, quarter));
        // y goes to z by the turn about x, and the turn about z leaves it there.
        assert!((pose.vector(DVec3::Y) - DVec3::Z).length() < 1e-15);
    }
}
