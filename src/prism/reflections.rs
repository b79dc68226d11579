//! Light through a piece of glass whose every surface parts it: what is let through and what is sent back are both
//! followed, by no chance, until they leave, are absorbed, or are given up; and what became of all of it is accounted for.

use super::biprism::Prism;
use super::first_face::{NextFace, RayStart};
use super::side::{PrismFace, Side};
use crate::geom::Ray;
use crate::optics::fresnel::{Interface, Layer, left_after};
use crate::optics::polarisation::Beam;
use crate::optics::snell::refract;
use crate::surface::face::Face;

/// What the glass is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GlassBody {
    /// Refractive index of the surroundings.
    pub n_outer: f64,
    /// Refractive index of the glass.
    pub n_glass: f64,
    /// Layers on the facets and on the backs.
    pub layers: [Option<Layer>; 2],
    /// Wavelength in vacuum, in nm; only layers ask for it.
    pub wavelength_nm: f64,
    /// Absorption coefficient of the glass, in 1/mm.
    pub absorption_per_mm: f64,
}

/// When light is given up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Light that has been reflected more often than this.
    pub bounces: u32,
    /// Light of less power than this, of 1 that came in.
    pub least_power: f64,
}

/// Light that has left the glass for good.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exit {
    /// The way it goes on, in the prism's frame.
    pub ray: Ray,
    /// Its power, of 1 that came in.
    pub power: f64,
    /// How often it was reflected.
    pub bounces: u32,
    /// The face that it left last.
    pub last: PrismFace,
    /// All faces that it met, as digits: light by the same route takes a neighbouring way.
    pub route: u64,
}

/// What became of the power that came in; the three add up to it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PowerBudget {
    /// Left the glass for good, either way.
    pub escaped: f64,
    /// Absorbed in the glass.
    pub absorbed: f64,
    /// Given up by the limits, gone where the glass has no surface or lets nothing pass, or lost by a solver.
    pub dropped: f64,
}

/// Traces light through a prism whose surfaces reflect; which face it meets is decided in `first_face`.
#[derive(Debug, Clone, Copy)]
pub struct ReflectionTracer<'a> {
    /// The prism.
    pub prism: &'a Prism,
    /// What it is made of.
    pub body: GlassBody,
    /// When light is given up.
    pub limits: Limits,
    /// What the solvers of the surfaces stop at, in mm.
    pub residual_mm: f64,
}

/// Light on its way.
#[derive(Clone, Copy)]
struct Branch {
    ray: Ray,
    beam: Beam,
    bounces: u32,
    /// The face where it starts; `None` at first.
    from: Option<PrismFace>,
    inside: bool,
    /// The side whose facet it met last.
    side: Side,
    route: u64,
}

impl ReflectionTracer<'_> {
    /// Traces light of power 1 that comes along `ray` towards the facets, as `start`, through all that the surfaces send
    /// back; `leave` hears of what leaves the glass for good, in a fixed order. Everything is in the world.
    ///
    /// The glass is met again by light that left a facet towards the camera and meets the other facet; light that has left
    /// through a back is gone. The light that is never reflected takes the way of [`Prism::pass`], bit for bit.
    pub fn trace(&self, ray: &Ray, start: Beam, leave: &mut impl FnMut(&Exit)) -> PowerBudget {
        match &self.prism.poses {
            None => self.trace_own(ray, start, leave),
            Some([world_from_prism, prism_from_world]) => {
                let start = start.turned(|v| prism_from_world.vector(v));
                self.trace_own(&ray.moved(prism_from_world), start, &mut |exit: &Exit| {
                    leave(&Exit { ray: exit.ray.moved(world_from_prism), ..*exit });
                })
            }
        }
    }

    /// [`ReflectionTracer::trace`] with everything in the prism's frame.
    fn trace_own(&self, ray: &Ray, start: Beam, leave: &mut impl FnMut(&Exit)) -> PowerBudget {
        let mut account = PowerBudget::default();
        let side = if ray.direction.x >= 0.0 { Side::Right } else { Side::Left };
        let branch = Branch { ray: *ray, beam: start, bounces: 0, from: None, inside: false, side, route: 0 };
        self.walk(branch, &mut account, leave);
        account
    }

    fn walk(&self, branch: Branch, account: &mut PowerBudget, leave: &mut impl FnMut(&Exit)) {
        let power = branch.beam.power();
        if branch.bounces > self.limits.bounces || power < self.limits.least_power {
            account.dropped += power;
            return;
        }
        let Branch { ray, bounces, from, inside, side, .. } = branch;
        let start = RayStart { from, inside, side, reflected: bounces > 0 };
        let (at, meeting) = match (self.prism.next_face(&ray, &start, self.residual_mm), from) {
            (NextFace::Meets(at, meeting), _) => (at, meeting),
            (NextFace::Escapes, Some(last)) => {
                account.escaped += power;
                leave(&Exit { ray: branch.ray, power, bounces: branch.bounces, last, route: branch.route });
                return;
            }
            (NextFace::Lost, _) | (NextFace::Escapes, None) => {
                account.dropped += power;
                return;
            }
        };
        let origin = branch.ray.at(meeting.t_mm);
        if !self.prism.passes_at(at.face, origin) {
            account.dropped += power;
            return;
        }
        let mut beam = branch.beam;
        if branch.inside && self.body.absorption_per_mm != 0.0 {
            beam = beam.dimmed(left_after(self.body.absorption_per_mm, meeting.t_mm));
            account.absorbed += power - beam.power();
        }
        let (incoming, normal) = (branch.ray.direction, meeting.normal);
        let reflected = (incoming - normal * (2.0 * incoming.dot(normal))).normalize();
        let interface = self.interface(at.face, branch.inside);
        let refracted = refract(incoming, normal, interface.n_in / interface.n_out).map(|r| r.direction);
        let parts = beam.split(&interface, normal, incoming, reflected, refracted);
        let side = if at.face == Face::Front { at.side } else { branch.side };
        // Base 8, the highest bit for the digits that are there; the 20 that 64 bits hold are more than light is worth.
        let route = branch.route.wrapping_mul(8).wrapping_add(4 + 2 * at.side as u64 + at.face as u64);
        let onward = Branch { from: Some(at), side, route, ..branch };
        if let Some(direction) = refracted {
            let ray = Ray { origin, direction };
            self.walk(Branch { ray, beam: parts.transmitted, inside: !branch.inside, ..onward }, account, leave);
        }
        let ray = Ray { origin, direction: reflected };
        self.walk(Branch { ray, beam: parts.reflected, bounces: branch.bounces + 1, ..onward }, account, leave);
    }

    /// The face as light meets it from inside or outside.
    fn interface(&self, face: Face, inside: bool) -> Interface {
        let GlassBody { n_outer, n_glass, layers, wavelength_nm, .. } = self.body;
        let (n_in, n_out) = if inside { (n_glass, n_outer) } else { (n_outer, n_glass) };
        Interface { n_in, n_out, layer: layers[face as usize].map(|layer| (layer, wavelength_nm)) }
    }
}

#[cfg(test)]
#[path = "reflections_tests.rs"]
mod tests;
