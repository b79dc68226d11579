//! The pinhole camera: image positions to rays.

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
    /// The principal point: the centre of the sensor.
    centre_px: DVec2,
    size_px: [usize; 2],
}

impl Camera {
    /// The camera of a scene.
    pub fn new(camera: &scene::Camera) -> Self {
        Self {
            position_mm: camera.position_mm,
            tangent_per_px: camera.pitch_mm / camera.focal_length_mm,
            centre_px: DVec2::new(camera.width_px as f64, camera.height_px as f64) * 0.5,
            size_px: [camera.width_px, camera.height_px],
        }
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
