//! Polynomial surfaces z(x, y), and their intersection with a ray.

use super::hit::Hit;
use crate::geom::{Ray, Rect};
use crate::num::bernstein::Bernstein;
use crate::num::poly2::{Jet, Poly2};
use crate::optics::fate::Fate;
use glam::{DVec2, DVec3};

/// A polynomial z(x, y) and the region in which it was given.
#[derive(Debug, Clone, PartialEq)]
pub struct PolynomialPatch {
    /// z(x, y), in mm.
    pub sag: Poly2,
    /// Where it may be used, in mm; a ray that meets it elsewhere has missed.
    pub domain: Rect,
}

/// A polynomial sheet z(x, y), or its mirror image z(-x, y).
#[derive(Debug, Clone, PartialEq)]
pub struct PolynomialSurface {
    sag: Poly2,
    domain: Rect,
    mirrored: bool,
    /// The slope |grad z| is nowhere in the domain above this.
    steepest: f64,
    /// z and its slopes at the centre of the polynomial: the plane where solvers start.
    tangent: [f64; 3],
    /// z is nowhere in the domain below the first or above the second.
    heights: [f64; 2],
}

/// Newton's method gives up after this many steps; from a good start it needs 3 to 5.
pub(super) const MAX_STEPS: usize = 16;
/// A crossing that was bracketed before is polished by steps of at most this share of the ray's way over the sheet, so
/// that a nearly tangent ray is not thrown to another crossing.
const POLISH: f64 = 1e-9;
/// A gap to the sheet above this share of its terms is no rounding: a thousand times what a few dozen terms round to.
const ROUNDING: f64 = 1e-11;
/// The residual allowed is for ways of 10 mm and more from the ray's origin; of shorter ones it is the same share: in a
/// scene much smaller than usual, a length in mm says little.
pub const FULL_WAYS_PER_MM: f64 = 0.1;

/// The frame in which a surface is not mirrored. Exact, for a sign has no rounding.
#[inline(always)]
pub(super) fn turned(v: DVec3, mirrored: bool) -> DVec3 {
    if mirrored { DVec3::new(-v.x, v.y, v.z) } else { v }
}

impl PolynomialSurface {
    /// The sheet `patch`; its mirror image in x = 0 where `mirrored`.
    pub fn new(patch: &PolynomialPatch, mirrored: bool) -> Self {
        // Bound the scaled coordinates over the domain.
        let PolynomialPatch { sag, domain } = patch;
        let reach =
            |min: f64, max: f64, centre: f64, scale: f64| (min - centre).abs().max((max - centre).abs()) / scale;
        let [sx, sy] = sag.scale();
        let u = reach(domain.min.x, domain.max.x, sag.centre()[0], sx);
        let v = reach(domain.min.y, domain.max.y, sag.centre()[1], sy);

        // Bound slope and height. |X^m Y^n| <= u^m v^n over the domain, so the sums of the terms' derivatives bound the
        // slope, and their own the height.
        let power = |base: f64, n: usize| (0..n).fold(1.0, |p, _| p * base);
        let (mut slope_x, mut slope_y, mut constant, mut departure) = (0.0, 0.0, 0.0, 0.0);
        for (m, n, c) in sag.terms() {
            if m + n == 0 {
                constant = c;
            } else {
                departure += c.abs() * power(u, m) * power(v, n);
            }
            if m > 0 {
                slope_x += c.abs() * m as f64 * power(u, m - 1) * power(v, n) / sx;
            }
            if n > 0 {
                slope_y += c.abs() * n as f64 * power(u, m) * power(v, n - 1) / sy;
            }
        }
        let steepest = DVec2::new(slope_x, slope_y).length();
        // A little more than the bound: the sum is rounded, and a plate lies in its own bound.
        let departure = departure * (1.0 + 1e-12) + 1e-12 * constant.abs();

        // Take the tangent plane at the centre, from which Newton's method starts.
        let [x0, y0] = sag.centre();
        let (z, zx, zy) = sag.gradient(x0, y0);
        let heights = [constant - departure, constant + departure];
        Self { sag: sag.clone(), domain: *domain, mirrored, steepest, tangent: [z, zx, zy], heights }
    }

    /// z(x, y), in mm, in the frame in which the sheet is not mirrored.
    pub fn sag(&self) -> &Poly2 {
        &self.sag
    }

    /// Where the sheet is given, in that frame, in mm.
    pub fn domain(&self) -> Rect {
        self.domain
    }

    /// The same sheet in a domain that is larger by its own size on every side: continued by its polynomial beyond where it was
    /// given.
    #[must_use]
    pub fn continued(&self) -> Self {
        let domain = self.domain.grown(self.domain.size().max_element());
        Self::new(&PolynomialPatch { sag: self.sag.clone(), domain }, self.mirrored)
    }

    /// Whether the sheet is z(-x, y).
    pub fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// A bound of the slope |grad z| over the domain.
    pub fn steepest(&self) -> f64 {
        self.steepest
    }

    /// Bounds of z over the domain, in mm.
    pub fn heights(&self) -> [f64; 2] {
        self.heights
    }

    /// z, dz/dx and dz/dy at the centre of the polynomial.
    pub fn tangent(&self) -> [f64; 3] {
        self.tangent
    }

    /// The frame in which the sheet is z(x, y).
    #[inline(always)]
    fn own(&self, v: DVec3) -> DVec3 {
        turned(v, self.mirrored)
    }

    pub(super) fn intersect(&self, ray: &Ray, residual_mm: f64) -> Result<Hit, Fate> {
        let ray = Ray { origin: self.own(ray.origin), direction: self.own(ray.direction) };
        // Where the sheet is nowhere as steep as the ray, the ray crosses it once in the domain: a root there is the root.
        let across = DVec2::new(ray.direction.x, ray.direction.y).length();
        let only_once = self.steepest * across < ray.direction.z.abs();
        if only_once && let Ok(meeting) = self.newton(&ray, self.start(&ray), f64::INFINITY, residual_mm) {
            return Ok(meeting);
        }
        let ends = self.way_over(&ray).ok_or(Fate::Missed)?;
        if only_once && self.stays_on_a_side(&ray, ends) {
            return Err(Fate::Missed);
        }
        let (t, length) = self.first_crossing(&ray, ends)?;
        self.newton(&ray, t, POLISH * length, residual_mm)
    }

    /// Where the ray (in the sheet's own frame) meets the tangent plane at the polynomial's centre.
    #[inline(always)]
    fn start(&self, Ray { origin: o, direction: d }: &Ray) -> f64 {
        let ([x0, y0], [z0, zx0, zy0]) = (self.sag.centre(), self.tangent);
        (z0 + zx0 * (o.x - x0) + zy0 * (o.y - y0) - o.z) / (d.z - zx0 * d.x - zy0 * d.y)
    }

    /// Newton's method from `t` on, on the gap along z, with steps of at most `longest_mm`.
    #[inline(always)]
    fn newton(&self, ray: &Ray, mut t: f64, longest_mm: f64, residual_mm: f64) -> Result<Hit, Fate> {
        let mut previous = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            let p = ray.at(t);
            let (z, zx, zy) = self.sag.gradient(p.x, p.y);
            let gap = p.z - z;
            let approach = ray.direction.z - zx * ray.direction.x - zy * ray.direction.y;
            let step = (gap / approach).clamp(-longest_mm, longest_mm);
            if is_met(ray, t, p.z, gap, previous, residual_mm) {
                let inside = t > 0.0 && self.domain.contains(DVec2::new(p.x, p.y));
                // One last step costs nothing more than its division and leaves nothing but the rounding error.
                let t_mm = t - step;
                let normal = self.own(DVec3::new(-zx, -zy, 1.0).normalize());
                return if inside && t_mm.is_finite() { Ok(Hit { t_mm, normal, part: 0 }) } else { Err(Fate::Missed) };
            }
            previous = gap.abs();
            t -= step;
            if !t.is_finite() {
                return Err(Fate::NotConverged);
            }
        }
        Err(Fate::NotConverged)
    }

    /// Where the way of the ray (in the sheet's own frame) through the box about the sheet begins and ends.
    fn way_over(&self, ray: &Ray) -> Option<[f64; 2]> {
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for (o, d, min, max) in [
            (ray.origin.x, ray.direction.x, self.domain.min.x, self.domain.max.x),
            (ray.origin.y, ray.direction.y, self.domain.min.y, self.domain.max.y),
            (ray.origin.z, ray.direction.z, self.heights[0], self.heights[1]),
        ] {
            if d == 0.0 {
                if o < min || o > max {
                    return None;
                }
            } else {
                let (a, b) = ((min - o) / d, (max - o) / d);
                near = near.max(a.min(b));
                far = far.min(a.max(b));
            }
        }
        (near <= far && far.is_finite()).then_some([near, far])
    }

    /// Whether the ends of a ray's way over the sheet, on which it nears the sheet or leaves it all along, surely lie on one side of
    /// it, so that all of the way does: by far more than the rounding of the sheet's terms.
    fn stays_on_a_side(&self, ray: &Ray, ends: [f64; 2]) -> bool {
        let [near, far] = ends.map(|t| {
            let p = ray.at(t);
            p.z - self.sag.value(p.x, p.y)
        });
        let rounding = ROUNDING * (self.heights[1] - self.heights[0] + self.heights[0].abs() + ray.origin.z.abs());
        near.abs().min(far.abs()) > rounding && (near > 0.0) == (far > 0.0)
    }

    /// The first crossing of the ray (in the sheet's own frame) on its way over the sheet, nearly, and the length of that way. Along
    /// it the sheet is a polynomial of one variable, and none of its roots can be overlooked.
    fn first_crossing(&self, ray: &Ray, [near, far]: [f64; 2]) -> Result<(f64, f64), Fate> {
        // Write the gap between ray and sheet along it as a polynomial in Bernstein form.
        let (a, b) = (ray.at(near), ray.at(far));
        let sag = self.sag.along([a.x, a.y], [b.x, b.y]);
        // A sheet of degree 0 has a gap of degree 1.
        let sag = if sag.degree() == 0 { Bernstein::line([sag.value(0.0); 2], 1) } else { sag };
        let gap = Bernstein::line([-a.z, -b.z], sag.degree()).plus(&sag);

        // Take its first root.
        let share = gap.first_root().ok_or(Fate::Missed)?;
        Ok((near + (far - near) * share, far - near))
    }

    pub(super) fn normal_change(&self, point: DVec3, normal: DVec3, step: DVec3) -> DVec3 {
        let (p, n, s) = (self.own(point), self.own(normal), self.own(step));
        self.own(turn(&self.sag.jet(p.x, p.y), n, s))
    }
}

/// Whether Newton's method is done at `t` along a ray, `z` high, with this gap and the one before it, all in mm.
#[inline(always)]
pub(super) fn is_met(ray: &Ray, t: f64, z: f64, gap: f64, previous: f64, residual_mm: f64) -> bool {
    // Rounding of z and of the ray's own position may exceed the residual allowed; the second time the gap does not
    // shrink, that floor is reached.
    let floor = 8.0 * f64::EPSILON * (z.abs() + ray.origin.z.abs() + t.abs());
    let wanted = residual_mm * (FULL_WAYS_PER_MM * t.abs()).min(1.0);
    gap.abs() <= wanted || (gap.abs() >= previous && gap.abs() <= floor)
}

/// How the unit normal `n` of a height with the jet `j`, of either orientation, turns when its point moves by `s`.
#[inline(always)]
pub(super) fn turn(j: &Jet, n: DVec3, s: DVec3) -> DVec3 {
    let gradient = DVec3::new(-j.dx, -j.dy, 1.0);
    let change = DVec3::new(-(j.dxx * s.x + j.dxy * s.y), -(j.dxy * s.x + j.dyy * s.y), 0.0);
    let turn = (change - n * n.dot(change)) / gradient.length();
    // `n` may point along or against the gradient.
    if n.dot(gradient) < 0.0 { -turn } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::shape::Surface;

    /// z = 10 + x^2 over |x|, |y| <= 20: a steep valley that a shallow ray can cross twice.
    fn valley() -> PolynomialSurface {
        let sag = Poly2::new(2, [0.0, 0.0], [1.0, 1.0], |m, n| match (m, n) {
            (0, 0) => 10.0,
            (2, 0) => 1.0,
            _ => 0.0,
        });
        PolynomialSurface::new(
            &PolynomialPatch { sag, domain: Rect { min: DVec2::splat(-20.0), max: DVec2::splat(20.0) } },
            false,
        )
    }

    #[test]
    fn the_first_of_two_crossings_is_taken() {
        // From (-6, 0, 19), horizontal: x^2 = 9 at x = -3 and x = 3.
        let ray = Ray { origin: DVec3::new(-6.0, 0.0, 19.0), direction: DVec3::X };
        let m = Surface::Freeform(valley()).intersect(&ray, 1e-12).expect("it crosses");
        assert!((m.t_mm - 3.0).abs() < 1e-12, "{}", m.t_mm);
    }

    #[test]
    fn a_ray_below_the_valley_misses() {
        let ray = Ray { origin: DVec3::new(-6.0, 0.0, 9.9), direction: DVec3::X };
        assert_eq!(Surface::Freeform(valley()).intersect(&ray, 1e-12), Err(Fate::Missed));
    }

    #[test]
    fn two_crossings_a_hair_apart_are_not_overlooked() {
        // z = 10 + x^2 at 1e-10 above the bottom: x = -1e-5 and 1e-5.
        let ray = Ray { origin: DVec3::new(-6.0, 0.0, 10.0 + 1e-10), direction: DVec3::X };
        let m = Surface::Freeform(valley()).intersect(&ray, 1e-12).expect("it crosses");
        assert!((m.t_mm - (6.0 - 1e-5)).abs() < 1e-9, "{}", m.t_mm);
    }

    #[test]
    fn a_root_in_the_domain_is_found_though_the_centre_leads_elsewhere() {
        // A gentle sheet whose polynomial turns wild outside its domain, where Newton's first step may land.
        let sag = Poly2::new(15, [0.0, 0.0], [1.0, 1.0], |m, n| match (m, n) {
            (0, 0) => 10.0,
            (15, 0) => 1e-3,
            _ => 0.0,
        });
        let domain = Rect { min: DVec2::new(-1.0, -1.0), max: DVec2::new(1.0, 1.0) };
        let sheet = Surface::Freeform(PolynomialSurface::new(&PolynomialPatch { sag, domain }, false));
        for k in 0..=40 {
            let x = -1.0 + 0.05 * f64::from(k);
            let target = DVec3::new(x * 0.999, 0.3, 10.0 + 1e-3 * libm::pow(x * 0.999, 15.0));
            let origin = target - DVec3::new(0.9, 0.1, 0.4);
            let ray = Ray { origin, direction: (target - origin).normalize() };
            let m = sheet.intersect(&ray, 1e-12).expect("it crosses");
            assert!((ray.at(m.t_mm) - target).length() < 1e-12, "{x}: {}", ray.at(m.t_mm));
        }
    }

    /// Rays that cross a gentle sheet beyond its domain, or end before it, are told from those that meet it by the two ends of their
    /// way, as the polynomial along it tells them.
    #[test]
    fn the_ends_of_a_way_tell_a_miss() {
        let sag = Poly2::new(3, [0.0, 0.0], [1.0, 1.0], |m, n| match (m, n) {
            (0, 0) => 10.0,
            (1, 0) => 0.1,
            (3, 0) | (1, 2) => 0.02,
            _ => 0.0,
        });
        let domain = Rect { min: DVec2::splat(-1.0), max: DVec2::splat(1.0) };
        let sheet = PolynomialSurface::new(&PolynomialPatch { sag, domain }, false);
        let (mut met, mut told, mut missed) = (0, 0, 0);
        for k in 0..20_000 {
            let at = |alpha: f64| 2.0 * (alpha * f64::from(k + 1)).fract() - 1.0;
            let origin = DVec3::new(3.0 * at(0.754_877_666), 3.0 * at(0.569_840_29), 9.0);
            let ray = Ray { origin, direction: DVec3::new(at(0.819_172_513), at(0.671_043_606), 1.0).normalize() };
            let Some(ends) = sheet.way_over(&ray) else { continue };
            let crossing = sheet.first_crossing(&ray, ends);
            let one_side = sheet.stays_on_a_side(&ray, ends);
            assert!(!(one_side && crossing.is_ok()), "{ray:?}");
            met += usize::from(crossing.is_ok());
            missed += usize::from(crossing.is_err());
            told += usize::from(one_side);
            assert_eq!(crossing.is_ok(), Surface::Freeform(sheet.clone()).intersect(&ray, 1e-12).is_ok());
        }
        assert!(met > 100 && missed > 100 && told == missed, "{met} {missed} {told}");
    }

    #[test]
    fn a_vertical_ray_lands_on_the_sheet() {
        let ray = Ray { origin: DVec3::new(2.0, 1.0, 0.0), direction: DVec3::Z };
        let m = Surface::Freeform(valley()).intersect(&ray, 1e-12).expect("it crosses");
        assert_eq!(m.t_mm, 14.0);
        assert!((m.normal.x / m.normal.z + 4.0).abs() < 1e-14);
    }
}
