//! Throughput: the share of a ray's light that transport effects leave.

use super::instrument::System;
use crate::effect::{BoardPoint, LightPath};
use crate::prism::payload::Refractions;
use glam::DVec2;

impl System {
    /// The share of its light that transport effects leave to the image position `px`; 1 where its ray ends in the glass.
    pub fn throughput(&self, px: DVec2) -> f64 {
        let mut trip = Refractions::default();
        let Ok((ray, _)) = self.exit(self.camera.ray(px), &mut trip) else { return 1.0 };
        let landing = self.board.intersect(&ray).ok();
        let landing = landing.map(|(_, t_mm)| BoardPoint { point_mm: ray.at(t_mm), normal: self.board.normal() });
        let crossings = trip.crossings();
        let crossings = crossings.as_ref().map_or(&[][..], |both| both);
        self.effects.throughput(&LightPath { image_cos: self.camera.image_cos(px), crossings, landing })
    }
}
