//! Reflections in the prism: its faces as those of one body of glass, for light that does not go straight through.

use super::reflections::{Exit, Face, GlassBody, Limits, PowerBudget, ReflectionTracer};
use crate::geom::Ray;
use crate::optics::polarisation::Beam;
use crate::surface::hit::Hit;
use crate::system::Prism;
use glam::DVec3;

impl Prism {
    /// Follows light of power 1 that comes along `ray`, as `start`, through all that the surfaces send back; `leave` hears of
    /// what leaves the glass for good. Everything is in the world. The light that is never reflected takes the way of
    /// [`Prism::pass`], bit for bit.
    pub fn follow(
        &self,
        ray: &Ray,
        start: Beam,
        body: GlassBody,
        limits: Limits,
        residual_mm: f64,
        leave: &mut impl FnMut(&Exit),
    ) -> PowerBudget {
        let intersect = |face: Face, ray: &Ray| {
            let met = self.sides[face.side][face.which].intersect(ray, residual_mm)?;
            Ok(Hit { normal: self.normal(face.which, &met), ..met })
        };
        let passes = |face: Face, at_mm: DVec3| self.passes_at(face.which, at_mm);
        let solid = ReflectionTracer { body, intersect, passes };
        match &self.poses {
            None => solid.follow(ray, start, limits, leave),
            Some([world_from_prism, prism_from_world]) => {
                let start = start.turned(|v| prism_from_world.vector(v));
                solid.follow(&ray.moved(prism_from_world), start, limits, &mut |exit: &Exit| {
                    leave(&Exit { ray: exit.ray.moved(world_from_prism), ..*exit });
                })
            }
        }
    }
}
