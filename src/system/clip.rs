//! Clipping (vignetting): the rims and stops that keep rays from passing, and how far from them rays pass.

use crate::effect::clipping::Stop;
use crate::geom::{Pose, Ray};
use crate::scene;
use glam::{DMat3, DVec3};

/// A round opening in its place before the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opening {
    /// Its middle, in mm; it lies in a plane of constant z. In the world, or in the frame of a camera that is turned.
    centre_mm: DVec3,
    radius_mm: f64,
    /// The frame of a camera that is turned.
    camera_from_world: Option<Pose>,
}

impl Opening {
    /// The opening `stop` on the axis of `camera`.
    pub fn new(stop: &Stop, camera: &scene::CameraSpec) -> Self {
        let Stop { distance_mm, radius_mm } = *stop;
        let rotation = camera.calibration.rotation;
        if rotation == DMat3::IDENTITY {
            let centre_mm = camera.position_mm + DVec3::Z * distance_mm;
            return Self { centre_mm, radius_mm, camera_from_world: None };
        }
        let camera_from_world = Pose { rotation, translation_mm: camera.position_mm }.inverse();
        Self { centre_mm: DVec3::Z * distance_mm, radius_mm, camera_from_world: Some(camera_from_world) }
    }

    /// How far inside the rim a ray of the camera passes, in mm; negative where it does not.
    pub fn margin_mm(&self, ray: &Ray) -> f64 {
        let ray = &self.camera_from_world.map_or(*ray, |camera_from_world| ray.moved(&camera_from_world));
        let t_mm = (self.centre_mm.z - ray.origin.z) / ray.direction.z;
        self.radius_mm - (ray.at(t_mm) - self.centre_mm).truncate().length()
    }
}
