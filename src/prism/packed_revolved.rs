//! A surface of revolution for packets of rays, with the bits of the scalar trace.
//!
//! Every line repeats a line of [`RevolvedSurface`] on [`Lanes`]. A lane that may cross the surface several times, or whose
//! gap stalls, is handed back undecided.

use super::lanes::{Rays, Vectors};
use super::packet::{Hits, PacketSurface};
use crate::num::curve::ChebyshevCurve;
use crate::num::simd::{Lanes, Mask};
use crate::surface::shape::{FULL_WAYS_PER_MM, RevolvedSurface};
use glam::{DMat3, DVec3};

/// Steps of Newton's method before a lane is handed back.
const MAX_STEPS: usize = 6;

/// A [`RevolvedSurface`] for packets.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PackedRevolved {
    profile: ChebyshevCurve,
    point_mm: DVec3,
    frame: DMat3,
    azimuth: [f64; 3],
    slopes: [f64; 2],
    radii: [f64; 2],
    tangent: [f64; 2],
    mirrored: bool,
}

impl PackedRevolved {
    /// The surface `part`.
    pub(crate) fn new(part: &RevolvedSurface) -> Self {
        Self {
            profile: part.patch().profile.clone(),
            point_mm: part.patch().point_mm,
            frame: *part.frame(),
            azimuth: part.azimuth(),
            slopes: part.slopes(),
            radii: part.radii(),
            tangent: part.tangent(),
            mirrored: part.is_mirrored(),
        }
    }

    /// The rays in the frame of the axis.
    #[inline(always)]
    fn axial(&self, rays: &Rays) -> Rays {
        let mirror = Mask::splat(self.mirrored);
        let own = |v: Vectors| Vectors { x: v.x.negated_where(mirror), ..v };
        let [along, towards, across] = [self.frame.x_axis, self.frame.y_axis, self.frame.z_axis].map(Vectors::splat);
        let dots = |v: Vectors| Vectors { x: v.dot(along), y: v.dot(towards), z: v.dot(across) };
        let (o, point) = (own(rays.origin), Vectors::splat(self.point_mm));
        let origin = Vectors { x: o.x - point.x, y: o.y - point.y, z: o.z - point.z };
        Rays { origin: dots(origin), direction: dots(own(rays.direction)) }
    }

    /// rho and d rho/ds, by Clenshaw's recurrence.
    #[inline(always)]
    fn profile(&self, s: Lanes) -> [Lanes; 2] {
        let [middle, inverse_half] = self.profile.scale().map(Lanes::splat);
        let c = self.profile.coefficients();
        let x = (s - middle) * inverse_half;
        let twice = x + x;
        let zero = Lanes::splat(0.0);
        let (mut b1, mut b2, mut d1, mut d2) = (zero, zero, zero, zero);
        for &c in c.iter().skip(1).rev() {
            (d1, d2) = (twice * d1 - d2 + (b1 + b1), d1);
            (b1, b2) = (twice * b1 - b2 + Lanes::splat(c), b1);
        }
        let first = Lanes::splat(c.first().copied().unwrap_or(0.0));
        [x * b1 - b2 + first, (x * d1 - d2 + b1) * inverse_half]
    }
}

impl PacketSurface for PackedRevolved {
    #[inline(always)]
    fn intersect(&self, rays: &Rays, residual_mm: f64) -> Hits {
        // Move the rays to the frame of the axis, and start from the plane that touches the part in its middle.
        let Rays { origin: o, direction: d } = self.axial(rays);
        let [sin, cos, tan] = self.azimuth.map(Lanes::splat);
        let [rho0, slope0] = self.tangent.map(Lanes::splat);
        let [low, high] = self.profile.ends().map(Lanes::splat);
        let residual = Lanes::splat(residual_mm);
        let zero = Lanes::splat(0.0);
        let middle = Lanes::splat(self.profile.scale()[0]);
        let mut t = (rho0 + slope0 * (o.x - middle) - o.y) / (d.y - slope0 * d.x);

        // Step by Newton's method until every lane is done or needs care.
        let (mut t_mm, mut slope_met, mut y_met, mut z_met) = (t, t, t, t);
        let mut inside = Mask::splat(false);
        let outward = d.x.negated_where(d.y.lt(zero));
        let [one, other] = self.slopes.map(|slope| Lanes::splat(slope) * outward);
        let mut care = !one.max(other).lt(cos * d.y.abs() - sin * d.z.abs());
        let mut done = care;
        let mut previous = Lanes::splat(f64::INFINITY);
        for _ in 0..MAX_STEPS {
            // Evaluate the gap along the radius.
            let p = Vectors { x: o.x + d.x * t, y: o.y + d.y * t, z: o.z + d.z * t };
            let [rho, slope] = self.profile(p.x);
            let r = (p.y * p.y + p.z * p.z).sqrt();
            let (ry, rz) = (p.y / r, p.z / r);
            let rate = ry * d.y + rz * d.z - slope * d.x;
            let gap = r - rho;
            let next = t - gap / rate;

            // Keep the lanes whose gap is within the residual, one last step on.
            let wanted = residual * (Lanes::splat(FULL_WAYS_PER_MM) * t.abs()).min(Lanes::splat(1.0));
            let newly = gap.abs().le(wanted) & !done;
            t_mm = newly.select(next, t_mm);
            (slope_met, y_met, z_met) =
                (newly.select(slope, slope_met), newly.select(ry, y_met), newly.select(rz, z_met));

            // Accept a hit ahead of the ray and within the part.
            let within = zero.lt(t) & low.le(p.x) & p.x.le(high) & p.z.abs().le(tan * p.y);
            inside = inside | (newly & within);

            // Hand back the lanes whose gap no longer falls.
            care = care | (previous.le(gap.abs()) & !newly & !done);
            done = done | newly | care;
            if done.all() {
                break;
            }
            (t, previous) = (next, gap.abs());
        }

        // Take the normal where they were met, in the prism's frame.
        let n = Vectors { x: -slope_met, y: y_met, z: z_met }.normalize();
        let [along, towards, across] = [self.frame.x_axis, self.frame.y_axis, self.frame.z_axis].map(Vectors::splat);
        let own = along.times(n.x).plus(towards.times(n.y)).plus(across.times(n.z));
        let normal = Vectors { x: own.x.negated_where(Mask::splat(self.mirrored)), ..own };
        let met = inside & zero.lt(t_mm) & t_mm.lt(Lanes::splat(f64::INFINITY));
        Hits { t_mm, normal, met }
    }

    /// The rays that pass by the planes about the part.
    #[inline(always)]
    fn misses(&self, rays: &Rays) -> Mask {
        let Rays { origin: o, direction: d } = self.axial(rays);
        let [_, cos, tan] = self.azimuth;
        let ([low, high], tan) = (self.profile.ends().map(Lanes::splat), Lanes::splat(tan));
        let [least, most] = [self.radii[0] * cos, self.radii[1]].map(Lanes::splat);
        let zero = Lanes::splat(0.0);
        let (mut near, mut far) = (zero, Lanes::splat(f64::INFINITY));
        let mut known = Mask::splat(true);
        for (inside, rate) in [
            (o.x - low, d.x),
            (high - o.x, -d.x),
            (tan * o.y - o.z, tan * d.y - d.z),
            (tan * o.y + o.z, tan * d.y + d.z),
            (o.y - least, d.y),
            (most - o.y, -d.y),
        ] {
            let at = -inside / rate;
            let comes = zero.lt(rate);
            near = comes.select(at.max(near), near);
            far = comes.select(far, at.min(far));
            // Of a ray along a plane nothing is said: it may lie in it.
            known = known & zero.lt(rate.abs());
        }
        far.lt(near) & known
    }
}
