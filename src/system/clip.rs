//! Clipping (vignetting): the rims and stops that keep rays from passing, and how far from them rays pass.

use crate::effect::clipping::Stop;
use crate::geom::Ray;
use crate::scene;
use glam::DVec3;

/// A round opening in its place before the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opening {
    /// Its middle, in the world, in mm; it lies in a plane of constant z.
    centre_mm: DVec3,
    radius_mm: f64,
}

impl Opening {
    /// The opening `stop` on the axis of `camera`.
    pub fn new(stop: &Stop, camera: &scene::CameraSpec) -> Self {
        Self { centre_mm: camera.position_mm + DVec3::Z * stop.distance_mm, radius_mm: stop.radius_mm }
    }

    /// How far inside the rim a ray of the camera passes, in mm; negative where it does not.
    pub fn margin_mm(&self, ray: &Ray) -> f64 {
        let t_mm = (self.centre_mm.z - ray.origin.z) / ray.direction.z;
        self.radius_mm - (ray.at(t_mm) - self.centre_mm).truncate().length()
    }
}
