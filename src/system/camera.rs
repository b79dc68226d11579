//! The pinhole camera: image positions to rays.

use crate::effect::ThinLens;
use crate::geom::Ray;
use crate::num::simd::Lanes;
use crate::scene;
use crate::trace::carry::Differentials;
use crate::trace::packet::{Rays, Vectors};
use glam::{DVec2, DVec3};

/// A pinhole camera that looks along +z, its image un-inverted.
///
/// Every image position has a ray, inside the sensor or not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    position_mm: DVec3,
    /// Tangent of the field angle per pixel: pitch / focal length.
    tangent_per_px: f64,
    /// The principal point: the image position whose ray runs along z; the centre of the sensor for a plain pinhole.
    centre_px: DVec2,
    /// Tangent of the image-side angle less that of the object-side one: how a lens turns rays through this point of it.
    turn: DVec2,
    size_px: [usize; 2],
}

impl Camera {
    /// The camera of a scene.
    pub fn new(camera: &scene::Camera) -> Self {
        Self {
            position_mm: camera.position_mm,
            tangent_per_px: camera.pitch_mm / camera.focal_length_mm,
            centre_px: DVec2::new(camera.width_px as f64, camera.height_px as f64) * 0.5,
            turn: DVec2::ZERO,
            size_px: [camera.width_px, camera.height_px],
        }
    }

    /// What one point of the aperture of `lens`, in mm from the place of the pinhole, sees: a pinhole there, its principal
    /// point shifted so that every image position sees the same point of the plane in focus as before.
    #[must_use]
    pub fn through(&self, lens: &ThinLens, point_mm: DVec2) -> Self {
        Self {
            position_mm: self.position_mm + point_mm.extend(0.0),
            centre_px: self.centre_px + point_mm / (lens.focus_mm * self.tangent_per_px),
            turn: self.turn + point_mm / lens.focal_mm,
            ..*self
        }
    }

    /// The same camera with `n` x `n` pixels in place of each.
    #[must_use]
    pub fn sampled(&self, n: usize) -> Self {
        let [width, height] = self.size_px;
        Self {
            tangent_per_px: self.tangent_per_px / n as f64,
            centre_px: self.centre_px * n as f64,
            size_px: [width * n, height * n],
            ..*self
        }
    }

    /// Whether mirror images in the plane x = 0 have mirrored rays, bit for bit, and no pixel lies across it.
    pub fn keeps_mirror_images(&self) -> bool {
        let width = self.size_px[0];
        self.position_mm.x == 0.0 && width.is_multiple_of(2) && self.centre_px.x == 0.5 * width as f64
    }

    /// Columns and rows of the sensor.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// The pinhole, in the world.
    pub fn position_mm(&self) -> DVec3 {
        self.position_mm
    }

    /// Tangent of the field angle per pixel: pitch over focal length.
    pub fn tangent_per_px(&self) -> f64 {
        self.tangent_per_px
    }

    /// Cosine of the angle to the axis at which light reaches an image position.
    pub fn image_cos(&self, px: DVec2) -> f64 {
        let t = (px - self.centre_px) * self.tangent_per_px + self.turn;
        1.0 / (1.0 + t.length_squared()).sqrt()
    }

    /// The ray of an image position.
    #[inline(always)]
    pub fn ray(&self, px: DVec2) -> Ray {
        let t = (px - self.centre_px) * self.tangent_per_px;
        Ray { origin: self.position_mm, direction: DVec3::new(t.x, t.y, 1.0).normalize() }
    }

    /// The rays of a packet of image positions, with the bits of [`Camera::ray`].
    #[inline(always)]
    pub fn rays(&self, px: [Lanes; 2]) -> Rays {
        let scale = Lanes::splat(self.tangent_per_px);
        let x = (px[0] - Lanes::splat(self.centre_px.x)) * scale;
        let y = (px[1] - Lanes::splat(self.centre_px.y)) * scale;
        let direction = Vectors { x, y, z: Lanes::splat(1.0) }.normalize();
        Rays { origin: Vectors::splat(self.position_mm), direction }
    }

    /// How the ray of `px` changes with the position.
    #[inline(always)]
    pub fn differentials(&self, px: DVec2) -> Differentials {
        let t = (px - self.centre_px) * self.tangent_per_px;
        let a = DVec3::new(t.x, t.y, 1.0);
        let length = a.length();
        let d = a / length;
        let turn = |step: DVec3| (step - d * d.dot(step)) / length;
        let s = self.tangent_per_px;
        Differentials {
            origin: [DVec3::ZERO; 2],
            direction: [turn(DVec3::new(s, 0.0, 0.0)), turn(DVec3::new(0.0, s, 0.0))],
        }
    }
}
