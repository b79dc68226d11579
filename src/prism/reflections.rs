//! Non-sequential ray tracing in a body of glass by deterministic splitting: at every surface the transmitted and the
//! reflected part are both followed until they leave, are absorbed, or are given up, and all power is accounted for.

use super::first_face::RIDGE_ROUNDINGS;
use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::optics::fresnel::{Interface, Layer, left_after};
use crate::optics::polarisation::Beam;
use crate::optics::snell::refract;
use crate::surface::hit::Hit;
use glam::DVec3;

/// A surface of a biprism, each a graph z(x, y) in the prism's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Face {
    /// 0 for x < 0, 1 for x >= 0.
    pub side: usize,
    /// 0 for the facet that faces the camera, 1 for the back.
    pub which: usize,
}

/// What the glass is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GlassBody {
    /// Refractive index of the surroundings.
    pub n_outer: f64,
    /// Refractive index of the glass.
    pub n_glass: f64,
    /// Layers on the facets and on the backs.
    pub layers: [Option<Layer>; 2],
    /// Wavelength in vacuum, in nm; only layers need it.
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
    pub face: Face,
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

/// A piece of glass between four faces, of which `intersect` says where a ray first meets one.
///
/// The right face counts where x >= 0, the left one where x <= 0. A back counts everywhere for light that met a facet of its
/// own side last, as it does for light that passes in sequence; where that back is not given, reflected light meets the
/// other one, which counts on its own half. A face never sees itself: it is less bent than the light on
/// it is inclined, as it is where [`crate::surface::shape::PolynomialSurface`] knows that a ray crosses it once.
#[derive(Debug)]
pub struct ReflectionTracer<M, P> {
    /// What it is made of.
    pub body: GlassBody,
    /// Where a ray in the prism's frame first meets a face, with the normal in either orientation.
    pub intersect: M,
    /// Whether light goes on from a place of a face, or is lost there.
    pub passes: P,
}

/// Light on its way.
#[derive(Clone, Copy)]
struct Branch {
    ray: Ray,
    beam: Beam,
    bounces: u32,
    /// The face where it starts; `None` at first.
    from: Option<Face>,
    inside: bool,
    /// The side whose facet it met last.
    side: usize,
    route: u64,
}

/// What a ray comes to next.
enum Next {
    Meets(Face, Hit),
    Escapes,
    Lost,
}

impl<M: Fn(Face, &Ray) -> Result<Hit, Fate>, P: Fn(Face, DVec3) -> bool> ReflectionTracer<M, P> {
    /// Follows light of power 1 that comes along `ray` towards the facets: `leave` hears of all that leaves the glass,
    /// in a fixed order.
    ///
    /// `start` is the beam along the ray. The glass is met again by light that left a facet towards the camera and
    /// meets the other facet; light that has left through a back is gone.
    pub fn follow(&self, ray: &Ray, start: Beam, limits: Limits, leave: &mut impl FnMut(&Exit)) -> PowerBudget {
        let mut account = PowerBudget::default();
        let side = usize::from(ray.direction.x >= 0.0);
        let branch = Branch { ray: *ray, beam: start, bounces: 0, from: None, inside: false, side, route: 0 };
        self.walk(branch, limits, &mut account, leave);
        account
    }

    fn walk(&self, branch: Branch, limits: Limits, account: &mut PowerBudget, leave: &mut impl FnMut(&Exit)) {
        // Drop a branch of too many bounces or too little power.
        let power = branch.beam.power();
        if branch.bounces > limits.bounces || power < limits.least_power {
            account.dropped += power;
            return;
        }

        // Find the face that it meets next, or where it ends.
        let (face, meeting) = match (self.next(&branch), branch.from) {
            (Next::Meets(face, meeting), _) => (face, meeting),
            (Next::Escapes, Some(face)) => {
                account.escaped += power;
                leave(&Exit { ray: branch.ray, power, bounces: branch.bounces, face, route: branch.route });
                return;
            }
            (Next::Lost, _) | (Next::Escapes, None) => {
                account.dropped += power;
                return;
            }
        };

        // Drop what a rim clips.
        let origin = branch.ray.at(meeting.t_mm);
        if !(self.passes)(face, origin) {
            account.dropped += power;
            return;
        }

        // Absorb along the way through the glass.
        let mut beam = branch.beam;
        if branch.inside && self.body.absorption_per_mm != 0.0 {
            beam = beam.dimmed(left_after(self.body.absorption_per_mm, meeting.t_mm));
            account.absorbed += power - beam.power();
        }

        // Split the beam into its reflected and its refracted part.
        let (incoming, normal) = (branch.ray.direction, meeting.normal);
        let reflected = (incoming - normal * (2.0 * incoming.dot(normal))).normalize();
        let interface = self.interface(face, branch.inside);
        let refracted = refract(incoming, normal, interface.n_in / interface.n_out).map(|r| r.direction);
        let parts = beam.split(&interface, normal, incoming, reflected, refracted);

        // Note the face in the route.
        let side = if face.which == 0 { face.side } else { branch.side };
        // Base 8, the highest bit for the digits that are there; the 20 that 64 bits hold are more than light is worth.
        let route = branch.route.wrapping_mul(8).wrapping_add(4 + 2 * face.side as u64 + face.which as u64);
        let onward = Branch { from: Some(face), side, route, ..branch };

        // Follow the refracted part, then the reflected one.
        if let Some(direction) = refracted {
            let ray = Ray { origin, direction };
            self.walk(
                Branch { ray, beam: parts.transmitted, inside: !branch.inside, ..onward },
                limits,
                account,
                leave,
            );
        }
        let ray = Ray { origin, direction: reflected };
        self.walk(Branch { ray, beam: parts.reflected, bounces: branch.bounces + 1, ..onward }, limits, account, leave);
    }

    /// The face as light meets it from inside or outside.
    fn interface(&self, face: Face, inside: bool) -> Interface {
        let GlassBody { n_outer, n_glass, layers, wavelength_nm, .. } = self.body;
        let (n_in, n_out) = if inside { (n_glass, n_outer) } else { (n_outer, n_glass) };
        Interface { n_in, n_out, layer: layers[face.which].map(|layer| (layer, wavelength_nm)) }
    }

    fn next(&self, branch: &Branch) -> Next {
        // Through the back there is nothing more to meet.
        if !branch.inside && branch.from.is_some_and(|face| face.which == 1) {
            return Next::Escapes;
        }

        // Find the nearest face on its own half, the right one at the same distance; a ray through the ridge itself,
        // which to within rounding is on neither half, meets the right one.
        let mut nearest: Option<(FacePart, Face, Hit)> = None;
        let back = |side: usize| Face { side, which: 1 };
        let faces = [Face { side: 1, which: 0 }, Face { side: 0, which: 0 }, back(branch.side), back(1 - branch.side)];
        let mut own_back = false;
        for face in &faces[..if branch.inside { 4 } else { 2 }] {
            // Leave out faces that the branch cannot meet.
            let other_back = *face == faces[3];
            // Light that is not reflected passes in sequence, or not at all.
            if other_back && (own_back || branch.bounces == 0) {
                continue;
            }
            let itself = branch.from.is_some_and(|from| if face.which == 1 { from.which == 1 } else { from == *face });
            if itself {
                continue;
            }

            // Intersect the face, and see on which half.
            let meeting = match (self.intersect)(*face, &branch.ray) {
                Ok(meeting) => meeting,
                Err(Fate::NotConverged) => return Next::Lost,
                Err(_) => continue,
            };
            let Some(half) = half(&branch.ray, branch.inside, *face, other_back, &meeting) else { continue };
            own_back |= face.which == 1;

            // Keep the nearer one.
            let nearer = nearest.is_none_or(|(other, met, m)| match (other, half) {
                (FacePart::Ridge, FacePart::Own) if met.which == face.which => true,
                (FacePart::Own, FacePart::Ridge) if met.which == face.which => false,
                (FacePart::Ridge, FacePart::Ridge) => false,
                _ => meeting.t_mm < m.t_mm,
            });
            if nearer {
                nearest = Some((half, *face, meeting));
            }
        }

        // Light that meets no face is lost inside, at the rim of the glass, and escapes outside.
        match nearest {
            Some((_, face, meeting)) => Next::Meets(face, meeting),
            None if branch.inside => Next::Lost,
            None => Next::Escapes,
        }
    }
}

/// Where a face was met.
#[derive(Clone, Copy, PartialEq, Eq)]
enum FacePart {
    /// Where it counts.
    Own,
    /// In the ridge, to within rounding.
    Ridge,
}

/// Where a face was met, if it is there and is met from the side on which the light is. This, and not a least distance,
/// keeps light from meeting again what it has just left.
///
/// A facet counts on its own half, and so does a back if `on_its_half`.
fn half(ray: &Ray, inside: bool, face: Face, on_its_half: bool, meeting: &Hit) -> Option<FacePart> {
    let upwards: DVec3 = meeting.normal * meeting.normal.z.signum();
    let along = ray.direction.dot(upwards);
    // Glass is behind the facets, in +z, and in front of the backs.
    let into_glass = if face.which == 0 { along } else { -along };
    if along == 0.0 || (into_glass < 0.0) != inside {
        return None;
    }
    let x = ray.at(meeting.t_mm).x;
    let own = match face {
        Face { which: 1, .. } if !on_its_half => true,
        Face { side: 1, .. } => x >= 0.0,
        _ => x < 0.0,
    };
    let slack = RIDGE_ROUNDINGS * (ray.origin.x.abs() + meeting.t_mm);
    if own { Some(FacePart::Own) } else { (x.abs() <= slack).then_some(FacePart::Ridge) }
}
