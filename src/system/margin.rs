//! The clipping margin: how far a ray passes from what clips it.

use super::instrument::System;
use crate::effect::Clipping;
use crate::geom::Pose;
use crate::prism::payload::{Payload, RefractionEvent};
use crate::prism::surface_modifier::SurfaceModifier;
use crate::surface::face::Face;
use glam::DVec2;

/// The least margin of a ray on its way through the glass.
pub(super) struct Margin<'a> {
    clipping: &'a Clipping,
    met: usize,
    least_mm: f64,
}

impl Payload for Margin<'_> {
    fn refracted(&mut self, event: &RefractionEvent<'_, impl SurfaceModifier>) {
        let at_mm = event.ray.at(event.hit.t_mm);
        self.least_mm = self.least_mm.min(self.clipping.margin_mm(Face::ALL[self.met], at_mm));
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
