//! The prism as a piece of glass whose surfaces reflect: light that does not go straight through.

use super::biprism::Prism;
use super::reflections::{Exit, GlassBody, Limits, PowerBudget, ReflectionTracer};
use super::side::PrismFace;
use crate::geom::Ray;
use crate::optics::polarisation::Beam;
use crate::surface::hit::Hit;
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
        let intersect = |at: PrismFace, ray: &Ray| {
            let met = self.surface(at.side, at.face).intersect(ray, residual_mm)?;
            Ok(Hit { normal: self.normal(at.face, &met), ..met })
        };
        let passes = |at: PrismFace, at_mm: DVec3| self.passes_at(at.face, at_mm);
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
