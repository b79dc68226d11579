//! Surfaces of revolution, and their intersection with a ray.

use super::hit::Hit;
use super::polynomial::{FULL_WAYS_PER_MM, turned};
use crate::geom::Ray;
use crate::num::curve::ChebyshevCurve;
use crate::optics::fate::Fate;
use glam::{DMat3, DVec2, DVec3};

/// A part of a surface of revolution: the points at the distance rho(s) from an axis, s along it, within an angle about it.
#[derive(Debug, Clone, PartialEq)]
pub struct RevolvedPatch {
    /// The point of the axis where s = 0, in mm.
    pub point_mm: DVec3,
    /// The direction of the axis, of any length; not along z.
    pub axis: DVec3,
    /// The profile rho(s), in mm, above 0 over its interval.
    pub profile: ChebyshevCurve,
    /// How far the part reaches to both sides, as an angle about the axis from the half-plane through it towards +z, in rad,
    /// below a right angle.
    pub azimuth_rad: f64,
}

/// A part of a surface of revolution, or its mirror image in x = 0.
#[derive(Debug, Clone, PartialEq)]
pub struct RevolvedSurface {
    patch: RevolvedPatch,
    mirrored: bool,
    /// Columns along the axis, at a right angle to it towards +z, and at a right angle to both (towards +y of an axis along
    /// +x).
    frame: DMat3,
    /// Sine, cosine and tangent of the azimuth.
    azimuth: [f64; 3],
    /// rho' is nowhere below the first or above the second.
    slopes: [f64; 2],
    /// |rho''| is nowhere above this.
    sharpest_bend: f64,
    /// rho is nowhere below the first or above the second, in mm.
    radii: [f64; 2],
    /// rho and its slope in the middle of the profile: the plane where solvers start.
    tangent: [f64; 2],
}

/// Newton's method gives up after this many steps; from a good start it needs 3 to 5.
const MAX_STEPS: usize = 16;
/// A crossing that lies between known bounds is found by at most this many steps: the bounds are halved where Newton's method
/// leaves them.
pub(super) const MAX_BRACKETED_STEPS: usize = 128;
/// Most parts into which the way of a ray over the surface is cut in search of the first crossing.
const MAX_PARTS: usize = 4096;
/// Parts that wait to be searched: each cut leaves one more.
const WAITING: usize = 64;
/// The point in the middle between the ends of parts, at a share of this of their length.
const HALF: f64 = 0.5;

/// A ray in the frame of the axis: s, and the two coordinates at a right angle to it.
#[derive(Clone, Copy)]
pub(super) struct AxialRay {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
}

/// Where an axial ray is, how far from the surface along the radius, and how fast that changes along the ray.
#[derive(Clone, Copy)]
struct Gap {
    value: f64,
    rate: f64,
    /// The unit vector from the axis to the ray.
    radial: DVec2,
    slope: f64,
}

impl RevolvedSurface {
    /// The surface `patch`; its mirror image in x = 0 where `mirrored`.
    pub fn new(patch: &RevolvedPatch, mirrored: bool) -> Self {
        let along = patch.axis.normalize();
        let towards = (DVec3::Z - along * along.z).normalize();
        let (sin, cos) = libm::sincos(patch.azimuth_rad);
        let profile = &patch.profile;
        let mean = profile.coefficients().first().copied().unwrap_or(0.0);
        // A little more than the bound: the sum is rounded.
        let departure = profile.departure() * (1.0 + 1e-12) + 1e-12 * mean.abs();
        Self {
            mirrored,
            frame: DMat3::from_cols(along, towards, towards.cross(along)),
            azimuth: [sin, cos, sin / cos],
            slopes: profile.slopes(),
            sharpest_bend: profile.sharpest_bend(),
            radii: [mean - departure, mean + departure],
            tangent: profile.gradient(profile.scale()[0]),
            patch: patch.clone(),
        }
    }

    /// The surface where it is not mirrored.
    pub fn patch(&self) -> &RevolvedPatch {
        &self.patch
    }

    /// Whether the surface is the mirror image of its patch.
    pub fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// Along the axis, at a right angle to it towards +z, and at a right angle to both, where the surface is not mirrored.
    pub fn frame(&self) -> &DMat3 {
        &self.frame
    }

    /// Sine, cosine and tangent of the azimuth.
    pub fn azimuth(&self) -> [f64; 3] {
        self.azimuth
    }

    /// Bounds of d rho/ds.
    pub fn slopes(&self) -> [f64; 2] {
        self.slopes
    }

    /// Bounds of rho, in mm.
    pub fn radii(&self) -> [f64; 2] {
        self.radii
    }

    /// rho and d rho/ds in the middle of the profile.
    pub fn tangent(&self) -> [f64; 2] {
        self.tangent
    }

    /// A vector of the frame in which the surface is not mirrored, in the frame of the axis.
    #[inline(always)]
    pub(super) fn dots(&self, own: DVec3) -> DVec3 {
        DVec3::new(own.dot(self.frame.x_axis), own.dot(self.frame.y_axis), own.dot(self.frame.z_axis))
    }

    /// A vector in the frame of the axis.
    #[inline(always)]
    pub(super) fn axial(&self, v: DVec3) -> DVec3 {
        self.dots(turned(v, self.mirrored))
    }

    /// A vector of that frame in the prism's.
    #[inline(always)]
    pub(super) fn back(&self, v: DVec3) -> DVec3 {
        turned(self.frame.x_axis * v.x + self.frame.y_axis * v.y + self.frame.z_axis * v.z, self.mirrored)
    }

    #[inline(always)]
    pub(super) fn axial_ray(&self, ray: &Ray) -> AxialRay {
        let origin = turned(ray.origin, self.mirrored) - self.patch.point_mm;
        AxialRay { origin: self.dots(origin), direction: self.axial(ray.direction) }
    }

    /// The point in the prism's frame at the place of the axial frame.
    pub(super) fn point(&self, axial: DVec3) -> DVec3 {
        self.back(axial) + turned(self.patch.point_mm, self.mirrored)
    }

    #[inline(always)]
    fn gap(&self, ray: &AxialRay, t: f64) -> Gap {
        let p = ray.origin + ray.direction * t;
        let [rho, slope] = self.patch.profile.gradient(p.x);
        let r = (p.y * p.y + p.z * p.z).sqrt();
        let radial = DVec2::new(p.y / r, p.z / r);
        let rate = radial.x * ray.direction.y + radial.y * ray.direction.z - slope * ray.direction.x;
        Gap { value: r - rho, rate, radial, slope }
    }

    /// Whether the point at `t` lies in front of the ray's start and within the part.
    #[inline(always)]
    fn holds(&self, ray: &AxialRay, t: f64) -> bool {
        let p = ray.origin + ray.direction * t;
        let [low, high] = self.patch.profile.ends();
        t > 0.0 && low <= p.x && p.x <= high && p.z.abs() <= self.azimuth[2] * p.y
    }

    #[inline(always)]
    fn hit(&self, t_mm: f64, gap: &Gap) -> Result<Hit, Fate> {
        let normal = self.back(DVec3::new(-gap.slope, gap.radial.x, gap.radial.y).normalize());
        if t_mm > 0.0 && t_mm.is_finite() { Ok(Hit { t_mm, normal, part: 0 }) } else { Err(Fate::Missed) }
    }

    /// Whether a gap at `t` is none, given the one before it, all in mm.
    #[inline(always)]
    fn is_met(&self, ray: &AxialRay, t: f64, gap: f64, previous: f64, residual_mm: f64) -> bool {
        let wanted = residual_mm * (FULL_WAYS_PER_MM * t.abs()).min(1.0);
        gap.abs() <= wanted || (gap.abs() >= previous && gap.abs() <= self.floor(ray, t))
    }

    /// What rounding of the radius and of the ray's own position leaves of a gap, in mm.
    pub(super) fn floor(&self, ray: &AxialRay, t: f64) -> f64 {
        8.0 * f64::EPSILON * (self.radii[1] + ray.origin.length() + t.abs())
    }

    pub(super) fn intersect(&self, ray: &Ray, residual_mm: f64) -> Result<Hit, Fate> {
        let ray = self.axial_ray(ray);
        if self.is_crossed_once(ray.direction)
            && let Ok(hit) = self.newton(&ray, residual_mm)
        {
            return Ok(hit);
        }
        let ends = self.first_crossing(&ray)?;
        self.between(&ray, ends, residual_mm)
    }

    /// Whether a ray of this direction crosses the part once at the most, so that a root there is the root: along it the radius changes
    /// faster than the profile can follow.
    #[inline(always)]
    fn is_crossed_once(&self, d: DVec3) -> bool {
        let [sin, cos, _] = self.azimuth;
        let outward = if d.y < 0.0 { -d.x } else { d.x };
        let [one, other] = self.slopes.map(|slope| slope * outward);
        one.max(other) < cos * d.y.abs() - sin * d.z.abs()
    }

    /// Newton's method on the gap along the radius, from where the ray meets the plane that touches the part in its middle.
    #[inline(always)]
    fn newton(&self, ray: &AxialRay, residual_mm: f64) -> Result<Hit, Fate> {
        let (o, d, [rho, slope]) = (ray.origin, ray.direction, self.tangent);
        let mut t = (rho + slope * (o.x - self.patch.profile.scale()[0]) - o.y) / (d.y - slope * d.x);
        let mut previous = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            let gap = self.gap(ray, t);
            let next = t - gap.value / gap.rate;
            if self.is_met(ray, t, gap.value, previous, residual_mm) {
                // One last step costs nothing more than its division and leaves nothing but the rounding error.
                return if self.holds(ray, t) { self.hit(next, &gap) } else { Err(Fate::Missed) };
            }
            (t, previous) = (next, gap.value.abs());
            if !t.is_finite() {
                break;
            }
        }
        Err(Fate::NotConverged)
    }

    /// Ends of a stretch in which the ray first crosses the part, and only once.
    ///
    /// The part lies between planes through the axis, planes across it and planes along it, so that the way of a ray between these
    /// is one stretch. It is halved until bounds of the gap's derivatives decide each piece: no root, or one at the most.
    /// A ray that touches the surface without crossing it, to within rounding, has missed.
    fn first_crossing(&self, ray: &AxialRay) -> Result<[f64; 2], Fate> {
        let [near, far] = self.clipped(ray)?;
        let (d, radius) = (ray.direction, self.radii[0] * self.azimuth[1]);
        // r'' <= |d across the axis|^2 / r.
        let bend = (d.y * d.y + d.z * d.z) / radius + self.sharpest_bend * d.x * d.x;
        let floor = self.floor(ray, far);
        let mut waiting = [[0.0; 2]; WAITING];
        waiting[0] = [near, far];
        let mut count = 1;
        for _ in 0..MAX_PARTS {
            if count == 0 {
                return Err(Fate::Missed);
            }
            count -= 1;
            let [a, b] = waiting[count];
            let (middle, half) = (HALF * (a + b), HALF * (b - a));
            let gap = self.gap(ray, middle);
            let curved = HALF * bend * half * half;
            if gap.value.abs() > gap.rate.abs() * half + curved + floor {
                continue;
            }
            if gap.rate.abs() > bend * half || curved <= floor || count + 2 > WAITING {
                let changes = (self.gap(ray, a).value < 0.0) != (self.gap(ray, b).value < 0.0);
                if changes {
                    return Ok([a, b]);
                }
                continue;
            }
            waiting[count] = [middle, b];
            waiting[count + 1] = [a, middle];
            count += 2;
        }
        Err(Fate::NotConverged)
    }

    /// The stretch of the ray between all planes that bound the part.
    fn clipped(&self, ray: &AxialRay) -> Result<[f64; 2], Fate> {
        let (o, d, [low, high]) = (ray.origin, ray.direction, self.patch.profile.ends());
        let [_, cos, tan] = self.azimuth;
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for (inside, rate) in [
            (o.x - low, d.x),
            (high - o.x, -d.x),
            (tan * o.y - o.z, tan * d.y - d.z),
            (tan * o.y + o.z, tan * d.y + d.z),
            (o.y - self.radii[0] * cos, d.y),
            (self.radii[1] - o.y, -d.y),
        ] {
            let at = -inside / rate;
            if rate > 0.0 {
                near = near.max(at);
            } else if rate < 0.0 {
                far = far.min(at);
            } else if inside < 0.0 {
                return Err(Fate::Missed);
            }
        }
        if near <= far && far.is_finite() { Ok([near, far]) } else { Err(Fate::Missed) }
    }

    /// The crossing between two ends of unlike gaps: Newton's method, halving where that leaves them.
    fn between(&self, ray: &AxialRay, [mut a, mut b]: [f64; 2], residual_mm: f64) -> Result<Hit, Fate> {
        let begins_inside = self.gap(ray, a).value < 0.0;
        let mut t = HALF * (a + b);
        let mut previous = f64::INFINITY;
        for _ in 0..MAX_BRACKETED_STEPS {
            let gap = self.gap(ray, t);
            let next = t - gap.value / gap.rate;
            let bounded = |next: f64| a <= next && next <= b;
            if self.is_met(ray, t, gap.value, previous, residual_mm) {
                return self.hit(if bounded(next) { next } else { t }, &gap);
            }
            if (gap.value < 0.0) == begins_inside {
                a = t
            } else {
                b = t
            }
            let falls = gap.value.abs() < HALF * previous;
            t = if falls && a < next && next < b { next } else { HALF * (a + b) };
            previous = gap.value.abs();
        }
        Err(Fate::NotConverged)
    }
}

#[cfg(test)]
#[path = "revolved_tests.rs"]
mod tests;
