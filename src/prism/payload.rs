//! The payload of a ray: what it carries besides its geometry; `()` carries nothing and costs nothing.

use super::surface_modifier::SurfaceModifier;
use crate::geom::{Pose, Ray};
use crate::optics::refraction::Refraction;
use crate::optics::snell::Refracted;
use crate::surface::hit::Hit;
use crate::surface::shape::Surface;
use glam::DVec3;

/// A ray that is refracted at a surface.
#[derive(Debug, Clone, Copy)]
pub struct RefractionEvent<'a, M> {
    /// The ray as it came in.
    pub ray: &'a Ray,
    /// The surface.
    pub surface: &'a Surface,
    /// What the surface does besides refracting by its shape.
    pub modifier: &'a M,
    /// Where the ray meets the surface.
    pub hit: &'a Hit,
    /// n_in / n_out
    pub eta: f64,
    /// The ray behind the surface.
    pub out: &'a Refracted,
}

/// Something that follows a ray from surface to surface.
pub trait Payload {
    /// The ray met a surface, whether or not it goes on behind it.
    #[inline(always)]
    fn reached(&mut self, _ray: &Ray, _hit: &Hit) {}
    /// The ray was refracted.
    fn refracted(&mut self, event: &RefractionEvent<'_, impl SurfaceModifier>);
    /// The frame changes.
    fn moved(&mut self, a_from_b: &Pose);
}

impl Payload for () {
    #[inline(always)]
    fn refracted(&mut self, _: &RefractionEvent<'_, impl SurfaceModifier>) {}

    #[inline(always)]
    fn moved(&mut self, _: &Pose) {}
}

/// The derivatives of a ray's origin and direction by the two image coordinates, in mm/px and 1/px.
///
/// Ray differentials (Igehy, "Tracing Ray Differentials", 1999), here with the exact turn of the normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Differentials {
    /// d origin / d(u, v)
    pub origin: [DVec3; 2],
    /// d direction / d(u, v)
    pub direction: [DVec3; 2],
}

impl Differentials {
    /// Moves the origin along the ray to where it meets a plane of normal `normal` at distance `t_mm`: the differential
    /// of the meeting point itself.
    #[inline(always)]
    pub fn transferred(&self, ray: &Ray, t_mm: f64, normal: DVec3) -> [DVec3; 2] {
        let approach = normal.dot(ray.direction);
        [0, 1].map(|k| {
            let step = self.origin[k] + self.direction[k] * t_mm;
            step - ray.direction * (normal.dot(step) / approach)
        })
    }
}

impl Payload for Differentials {
    #[inline(always)]
    fn refracted(&mut self, event: &RefractionEvent<'_, impl SurfaceModifier>) {
        let &RefractionEvent { ray, surface, modifier, hit, eta, out } = event;
        let point = ray.at(hit.t_mm);
        self.origin = self.transferred(ray, hit.t_mm, surface.tangent(hit));
        for k in 0..2 {
            let turn = modifier.normal_change(surface, hit, point, out.normal, self.origin[k]);
            let cos_in = -(turn.dot(ray.direction) + out.normal.dot(self.direction[k]));
            // From cos_out^2 = eta^2 cos_in^2 + 1 - eta^2.
            let cos_out = if eta == 1.0 { cos_in } else { eta * eta * out.cos_in * cos_in / out.cos_out };
            let gamma = eta * cos_in - cos_out;
            self.direction[k] = self.direction[k] * eta + out.normal * gamma + turn * out.gamma;
        }
    }

    #[inline(always)]
    fn moved(&mut self, a_from_b: &Pose) {
        self.origin = self.origin.map(|v| a_from_b.vector(v));
        self.direction = self.direction.map(|v| a_from_b.vector(v));
    }
}

/// Every point at which the ray met a surface and the direction in which it went on behind it, one less of these where it was
/// totally reflected; in the prism's frame on the way,
/// in the world once the ray has left or ended.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Path {
    /// Meeting points, in mm, from the camera on.
    pub points: OnWay,
    /// Unit directions behind each.
    pub directions: OnWay,
}

/// Surfaces that a ray can meet on its way.
const SURFACES: usize = 2;

/// Points or directions on the way of a ray, one a surface that it met: a slice of them.
#[derive(Debug, Clone, Copy, Default)]
pub struct OnWay {
    all: [DVec3; SURFACES],
    count: usize,
}

impl OnWay {
    /// One more, behind the others; there are no more surfaces.
    #[inline(always)]
    fn push(&mut self, v: DVec3) {
        self.all[self.count] = v;
        self.count += 1;
    }
}

impl std::ops::Deref for OnWay {
    type Target = [DVec3];

    #[inline(always)]
    fn deref(&self) -> &[DVec3] {
        &self.all[..self.count]
    }
}

impl std::ops::DerefMut for OnWay {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [DVec3] {
        &mut self.all[..self.count]
    }
}

impl PartialEq for OnWay {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl Payload for Path {
    #[inline(always)]
    fn reached(&mut self, ray: &Ray, hit: &Hit) {
        self.points.push(ray.at(hit.t_mm));
    }

    #[inline(always)]
    fn refracted(&mut self, event: &RefractionEvent<'_, impl SurfaceModifier>) {
        self.directions.push(event.out.direction);
    }

    fn moved(&mut self, a_from_b: &Pose) {
        self.points.iter_mut().for_each(|p| *p = a_from_b.point(*p));
        self.directions.iter_mut().for_each(|d| *d = a_from_b.vector(*d));
    }
}

/// The facets of front and back, in the order of a ray's way through them, and the pieces of these; 0 of surfaces that are one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct PartsPassed {
    /// Of the first and the second surface, between which the way may jump.
    pub facets: [u32; 2],
    /// The same between which it may have a kink.
    pub pieces: [u32; 2],
    /// The triangles themselves, of meshes.
    pub triangles: [u32; 2],
    count: usize,
}

impl Payload for PartsPassed {
    fn refracted(&mut self, event: &RefractionEvent<'_, impl SurfaceModifier>) {
        if self.count < 2 {
            [self.facets[self.count], self.pieces[self.count]] = event.surface.parts(event.hit);
            self.triangles[self.count] = event.hit.part;
        }
        self.count += 1;
    }

    fn moved(&mut self, _: &Pose) {}
}

/// The two refractions of a way through a prism; in the prism's frame on the way, in the world once the ray has left or
/// ended.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Refractions {
    crossings: [Option<Refraction>; 2],
}

impl Refractions {
    /// The crossings, from the camera on; none where the ray met no glass or ended in it.
    pub(crate) fn crossings(&self) -> Option<[Refraction; 2]> {
        let [first, second] = self.crossings;
        first.zip(second).map(|(a, b)| [a, b])
    }
}

impl Payload for Refractions {
    fn refracted(&mut self, event: &RefractionEvent<'_, impl SurfaceModifier>) {
        let &RefractionEvent { ray, hit, eta, out, .. } = event;
        let crossing = Refraction {
            incoming: ray.direction,
            outgoing: out.direction,
            normal: out.normal,
            cos_in: out.cos_in,
            cos_out: out.cos_out,
            eta,
            way_mm: hit.t_mm,
        };
        let free = usize::from(self.crossings[0].is_some());
        self.crossings[free] = Some(crossing);
    }

    fn moved(&mut self, a_from_b: &Pose) {
        for crossing in self.crossings.iter_mut().flatten() {
            for v in [&mut crossing.incoming, &mut crossing.outgoing, &mut crossing.normal] {
                *v = a_from_b.vector(*v);
            }
        }
    }
}
