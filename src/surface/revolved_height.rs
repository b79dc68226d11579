//! Surfaces of revolution as heights over x and y: how their normals turn, and what they are beyond their part.

use super::revolved::{AxialRay, MAX_BRACKETED_STEPS, RevolvedSurface};
use crate::geom::{Ray, Rect};
use crate::num::poly2::Jet;
use glam::{DVec2, DVec3};

impl RevolvedSurface {
    pub(super) fn normal_change(&self, point: DVec3, normal: DVec3, step: DVec3) -> DVec3 {
        let at = Ray { origin: point, direction: step };
        let AxialRay { origin: p, direction: s } = self.axial_ray(&at);
        let n = self.axial(normal);
        let [_, slope, bend] = self.patch().profile.jet(p.x);
        let r = (p.y * p.y + p.z * p.z).sqrt();
        let radial = DVec2::new(p.y / r, p.z / r);
        let across = DVec2::new(s.y, s.z);
        let turn = (across - radial * radial.dot(across)) / r;
        let gradient = DVec3::new(-slope, radial.x, radial.y);
        let change = DVec3::new(-bend * s.x, turn.x, turn.y);
        let turn = (change - n * n.dot(change)) / gradient.length();
        // `normal` may point along or against the gradient.
        self.back(if n.dot(gradient) < 0.0 { -turn } else { turn })
    }

    /// The lowest z of the part, in mm, or less.
    fn lowest_mm(&self) -> f64 {
        let [low, high] = self.patch().profile.ends();
        let across = [self.radii()[0] * self.azimuth()[1], self.radii()[1]];
        let corners = [low, high].into_iter().flat_map(|s| across.map(|a| self.point(DVec3::new(s, a, 0.0)).z));
        corners.fold(f64::INFINITY, f64::min)
    }

    /// z over (x, y) with its derivatives; `None` beside the part.
    pub fn jet_over(&self, x: f64, y: f64) -> Option<Jet> {
        // Meet it from below.
        let below = Ray { origin: DVec3::new(x, y, self.lowest_mm() - 1.0), direction: DVec3::Z };
        let hit = self.intersect(&below, 0.0).ok()?;
        let at = below.at(hit.t_mm);
        let p = self.axial_ray(&Ray { origin: at, direction: DVec3::Z }).origin;

        // Take gradient and second derivatives of r - rho(s), which is 0 on it.
        let [_, slope, bend] = self.patch().profile.jet(p.x);
        let r = (p.y * p.y + p.z * p.z).sqrt();
        let radial = DVec3::new(0.0, p.y / r, p.z / r);
        let tangential = DVec3::new(0.0, -radial.z, radial.y);
        let gradient = self.back(radial - DVec3::X * slope);
        let [along, around] = [self.back(DVec3::X), self.back(tangential)];
        let second = |i: usize, j: usize| around[i] * around[j] / r - along[i] * along[j] * bend;

        // Differentiate z implicitly.
        let [dx, dy] = [-gradient.x / gradient.z, -gradient.y / gradient.z];
        let slopes = [dx, dy];
        let curve = |i: usize, j: usize| {
            -(second(i, j) + second(i, 2) * slopes[j] + second(j, 2) * slopes[i] + second(2, 2) * slopes[i] * slopes[j])
                / gradient.z
        };
        Some(Jet { value: at.z, dx, dy, dxx: curve(0, 0), dxy: curve(0, 1), dyy: curve(1, 1) })
    }

    /// z over (x, y), in mm, of the whole surface of revolution, whose profile goes on straight beyond its ends; `None` where
    /// there is none.
    pub(super) fn continued_mm(&self, x: f64, y: f64) -> Option<f64> {
        let below = Ray { origin: DVec3::new(x, y, self.lowest_mm() - 1.0), direction: DVec3::Z };
        let ray = self.axial_ray(&below);
        let (o, d, [rho, slope]) = (ray.origin, ray.direction, self.tangent());
        let [low, high] = self.patch().profile.ends();
        let mut t = (rho + slope * (o.x - self.patch().profile.scale()[0]) - o.y) / (d.y - slope * d.x);
        for _ in 0..MAX_BRACKETED_STEPS {
            let p = o + d * t;
            let end = p.x.clamp(low, high);
            let [at_end, slope] = self.patch().profile.gradient(end);
            let r = (p.y * p.y + p.z * p.z).sqrt();
            let gap = r - at_end - slope * (p.x - end);
            let step = gap / ((p.y * d.y + p.z * d.z) / r - slope * d.x);
            t -= step;
            if step.abs() <= self.floor(&ray, t) {
                return Some(below.at(t).z);
            }
        }
        None
    }

    /// The point of the profile in the half-plane through the axis towards +z, at `s` along the axis, in mm.
    pub fn point_of_profile(&self, s: f64) -> DVec3 {
        self.point(DVec3::new(s, self.patch().profile.gradient(s)[0], 0.0))
    }

    /// A rectangle over x and y that holds the part, where it is not mirrored, in mm.
    pub fn region(&self) -> Rect {
        let [low, high] = self.patch().profile.ends();
        let [sin, cos, _] = self.azimuth();
        let mut region = Rect { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
        for s in [low, high] {
            for (y, z) in [(self.radii()[0] * cos, 0.0), (self.radii()[1], 0.0)] {
                for z in [z - self.radii()[1] * sin, z + self.radii()[1] * sin] {
                    let p = (*self.frame() * DVec3::new(s, y, z) + self.patch().point_mm).truncate();
                    region = Rect { min: region.min.min(p), max: region.max.max(p) };
                }
            }
        }
        region
    }
}
