//! A rigid motion.

use glam::{DMat3, DVec3};

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

    /// The angles of [`Pose::new`], in rad: that about y within a quarter turn either way, where there is a choice.
    pub fn angles_rad(&self) -> DVec3 {
        let r = &self.rotation;
        // The rotation is Z Y X: its first column is (cy cz, cy sz, -sy), and its last row (-sy, cy sx, cy cx).
        let level = (r.x_axis.x * r.x_axis.x + r.x_axis.y * r.x_axis.y).sqrt();
        let y = libm::atan2(-r.x_axis.z, level);
        // On end, turns about x and z are one: all of it is given to z.
        if level < 1e-9 {
            return DVec3::new(0.0, y, libm::atan2(-r.y_axis.x, r.y_axis.y));
        }
        DVec3::new(libm::atan2(r.y_axis.z, r.z_axis.z), y, libm::atan2(r.x_axis.y, r.x_axis.x))
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    proptest! {
        /// The angles of a rotation make it again, on end as well: each entry to a few roundings, or to the 1e-9 below which
        /// a board counts as on end.
        #[test]
        fn angles_make_their_rotation_again(
            x in -3.1..3.1, y in prop_oneof![-3.1..3.1, Just(FRAC_PI_2), Just(-FRAC_PI_2)], z in -3.1..3.1,
        ) {
            let pose = Pose::new(DVec3::ZERO, DVec3::new(x, y, z));
            let again = Pose::new(DVec3::ZERO, pose.angles_rad());
            prop_assert!((again.rotation - pose.rotation).abs_diff_eq(DMat3::ZERO, 2e-9), "{pose:?} {again:?}");
        }
    }
}
