//! The clipping margin: how far a ray passes from what clips it.

use super::instrument::System;
use crate::effect::Clipping;
use crate::geom::{Pose, Ray};
use crate::optics::snell::Refracted;
use crate::prism::payload::Payload;
use crate::prism::surface_modifier::Relief;
use crate::surface::hit::Hit;
use crate::surface::shape::Surface;
use glam::DVec2;

/// The least margin of a ray on its way through the glass.
pub(super) struct Margin<'a> {
    clipping: &'a Clipping,
    met: usize,
    least_mm: f64,
}

impl Payload for Margin<'_> {
    fn refracted(&mut self, ray: &Ray, _: &Surface, _: &impl Relief, meeting: &Hit, _: f64, _: &Refracted) {
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
