//! Where rays are kept from passing, and how far from there they pass.

use super::System;
use crate::effect::Clipping;
use crate::effect::clipping::Stop;
use crate::geom::{Pose, Ray};
use crate::optics::snell::Refracted;
use crate::optics::surface::{Meeting, Surface};
use crate::scene;
use crate::trace::carry::Carry;
use crate::trace::relief::Relief;
use glam::{DVec2, DVec3};

/// A round opening in its place before the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opening {
    /// Its middle, in the world, in mm; it lies in a plane of constant z.
    centre_mm: DVec3,
    radius_mm: f64,
}

impl Opening {
    /// The opening `stop` on the axis of `camera`.
    pub fn new(stop: &Stop, camera: &scene::Camera) -> Self {
        Self { centre_mm: camera.position_mm + DVec3::Z * stop.distance_mm, radius_mm: stop.radius_mm }
    }

    /// How far inside the rim a ray of the camera passes, in mm; negative where it does not.
    pub fn margin_mm(&self, ray: &Ray) -> f64 {
        let t_mm = (self.centre_mm.z - ray.origin.z) / ray.direction.z;
        self.radius_mm - (ray.at(t_mm) - self.centre_mm).truncate().length()
    }
}

/// The least margin of a ray on its way through the glass.
struct Margin<'a> {
    clipping: &'a Clipping,
    met: usize,
    least_mm: f64,
}

impl Carry for Margin<'_> {
    fn refracted(&mut self, ray: &Ray, _: &Surface, _: &impl Relief, meeting: &Meeting, _: f64, _: &Refracted) {
        self.least_mm = self.least_mm.min(self.clipping.margin_mm(self.met, ray.at(meeting.t_mm)));
        self.met += 1;
    }

    fn moved(&mut self, _: &Pose) {}
}

impl System {
    /// Whether anything clips rays.
    pub fn clips(&self) -> bool {
        self.effects.clipping.is_some_and(|clipping| !clipping.is_nothing())
    }

    /// How far the ray of `px` passes from what clips rays, in mm, at the place where it comes nearest; infinite where
    /// nothing does, negative where it is clipped.
    pub fn margin_mm(&self, px: DVec2) -> f64 {
        let Some(clipping) = &self.effects.clipping else { return f64::INFINITY };
        let ray = self.camera.ray(px);
        let stop = self.stop.map_or(f64::INFINITY, |stop| stop.margin_mm(&ray));
        let mut margin = Margin { clipping, met: 0, least_mm: stop };
        match self.exit(ray, &mut margin) {
            Err(_) if margin.least_mm >= 0.0 => f64::NEG_INFINITY,
            _ => margin.least_mm,
        }
    }
}
