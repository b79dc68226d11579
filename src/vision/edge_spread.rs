//! The edge spread function of a square pixel under a Gaussian blur: exact, and as a table.
//!
//! With unit normal n, a = |nx|/2, b = |ny|/2 and blur s, the bright share of a pixel at signed distance d is
//!
//! ```text
//! F(d) = [R(d+a+b) - R(d+a-b) - R(d-a+b) + R(d-a-b)] / (4ab),   R(t) = ((t^2 + s^2) Phi(t/s) + t s phi(t/s)) / 2
//! ```
//!
//! with the Gaussian phi and its integral Phi; F', F'' follow with R', R''. An edge is used as E = 2F - 1, which runs from
//! -1 to 1. Blur is diffusion: dE/ds = s E''.
//!
//! A picture that moves on a straight way, by m to both sides across the edge, is the mean of F over these distances:
//!
//! ```text
//! [S(d+a+b+m) - S(d+a+b-m) - ..] / (8abm),   S(t) = ((t^3 + 3 t s^2) Phi(t/s) + (t^2 s + 2 s^3) phi(t/s)) / 6,   S' = R
//! ```

use super::blur_shape::moved_width_px;
use crate::num::gauss::Gauss;
use crate::num::simd::Lanes;
use glam::DVec2;

/// Below this a and b count as this: the four terms would cancel, and the edge moves by less than 1e-6 px.
const LEAST_HALF_WIDTH: f64 = 2e-3;
/// A motion by less than this to both sides across an edge, in px, counts as blur of its variance: the terms would cancel, and its
/// third moments are 1e-6 px^3.
const LEAST_WAY_PX: f64 = 0.05;
/// How much wider a pixel is, in px, for the slope of a sharp edge.
const SHARP_MARGIN: f64 = 0.03;
/// A blur below this, in px, is taken as none.
pub(super) const SHARP_PX: f64 = 0.02;
/// The variance of a unit pixel in any direction, in px^2.
pub(super) const PIXEL_VARIANCE: f64 = 1.0 / 12.0;
/// The Gaussian's tail beyond this many standard deviations is dropped: it holds 7e-6, alike on both sides of an edge,
/// so that no edge moves.
const TAIL: f64 = 4.5;

/// The edge response and its derivatives at one distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    /// E
    pub(super) value: f64,
    /// dE/dd, in 1/px
    pub(super) slope: f64,
    /// d2E/dd2, in 1/px^2
    pub(super) bend: f64,
}

/// The pixel's half widths across an edge, the blur, and how far the picture moved to both sides, or 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EdgeShape {
    a: f64,
    b: f64,
    sigma: f64,
    way: f64,
}

impl EdgeShape {
    /// The shape for a unit normal and a blur in px.
    pub(super) fn new(normal: DVec2, sigma_px: f64) -> Self {
        let half = |n: f64| (0.5 * n.abs()).max(LEAST_HALF_WIDTH);
        Self { a: half(normal.x), b: half(normal.y), sigma: sigma_px, way: 0.0 }
    }

    /// The shape for a unit normal, a blur in px, and half the way of a motion in px.
    pub(super) fn moved(normal: DVec2, sigma_px: f64, half_way_px: DVec2) -> Self {
        let (shape, way) = (Self::new(normal, sigma_px), normal.dot(half_way_px).abs());
        if way < LEAST_WAY_PX {
            return Self { sigma: moved_width_px(sigma_px, way), ..shape };
        }
        Self { way, ..shape }
    }

    /// The same edge under another blur, without motion.
    pub(super) fn under(&self, sigma_px: f64) -> Self {
        Self { sigma: sigma_px, way: 0.0, ..*self }
    }

    /// The blur, in px.
    pub(super) fn sigma_px(&self) -> f64 {
        self.sigma
    }

    /// Beyond this distance, in px, the edge is -1 or 1.
    pub(super) fn reach(&self) -> f64 {
        self.a + self.b + SHARP_MARGIN + TAIL * self.sigma + self.way
    }

    /// The same with what the blur is beside the Gaussian, to so many px.
    pub(super) fn reach_under(&self, beside_px: f64) -> f64 {
        self.reach().max(self.a + self.b + self.way + beside_px)
    }

    /// The sum of the four corner terms of `f`, over 4ab.
    #[inline(always)]
    fn corners(&self, d: f64, f: impl Fn(f64) -> f64) -> f64 {
        let (sum, difference) = (self.a + self.b, self.a - self.b);
        ((f(d + sum) - f(d + difference)) - (f(d - difference) - f(d - sum))) / (4.0 * self.a * self.b)
    }

    /// The response at distance `d`.
    #[cfg(test)]
    pub(super) fn exact(&self, gauss: Gauss, d: f64) -> Edge {
        if d.abs() >= self.reach() {
            return Edge { value: d.signum(), slope: 0.0, bend: 0.0 };
        }
        let s = self.sigma;
        let (sum, difference) = (self.a + self.b, self.a - self.b);
        let inverse = 1.0 / s;
        let term = |t: f64| {
            let [big, small] = gauss.at(t * inverse);
            [0.5 * ((t * t + s * s) * big + t * s * small), t * big + s * small, big]
        };
        let (t0, t1, t2, t3) = (term(d + sum), term(d + difference), term(d - difference), term(d - sum));
        let over = 1.0 / (4.0 * self.a * self.b);
        let mix = |i: usize| ((t0[i] - t1[i]) - (t2[i] - t3[i])) * over;
        Edge { value: 2.0 * mix(0) - 1.0, slope: 2.0 * mix(1), bend: 2.0 * mix(2) }
    }

    /// The responses and their slopes at many distances, to the last bits those of [`Self::exact`].
    #[inline(always)]
    pub(super) fn exact_lanes(&self, gauss: Gauss, d: Lanes) -> [Lanes; 2] {
        let of = Lanes::splat;
        if self.way > 0.0 {
            return self.moved_lanes(gauss, d);
        }
        let (sum, difference) = (of(self.a + self.b), of(self.a - self.b));
        let t0 = self.integrals(gauss, d + sum);
        let t1 = self.integrals(gauss, d + difference);
        let t2 = self.integrals(gauss, d - difference);
        let t3 = self.integrals(gauss, d - sum);
        let over = of(1.0 / (4.0 * self.a * self.b));
        let value = of(2.0) * (((t0[0] - t1[0]) - (t2[0] - t3[0])) * over) - of(1.0);
        let slope = of(2.0) * (((t0[1] - t1[1]) - (t2[1] - t3[1])) * over);
        self.within_reach(d, [value, slope])
    }

    /// Value and slope, but -1 or 1 and 0 beyond the reach.
    #[inline(always)]
    fn within_reach(&self, d: Lanes, [value, slope]: [Lanes; 2]) -> [Lanes; 2] {
        let of = Lanes::splat;
        let beyond = of(self.reach()).le(d.abs());
        let side = d.lt(of(0.0)).select(of(-1.0), of(1.0));
        [beyond.select(side, value), beyond.select(of(0.0), slope)]
    }

    /// [`Self::exact_lanes`] under motion.
    #[inline(always)]
    fn moved_lanes(&self, gauss: Gauss, d: Lanes) -> [Lanes; 2] {
        let of = Lanes::splat;
        let (sum, difference) = (self.a + self.b, self.a - self.b);
        let along = |offset: f64| {
            let [ahead, behind] = [self.way, -self.way].map(|way| self.moved_integrals(gauss, d + of(offset + way)));
            [ahead[0] - behind[0], ahead[1] - behind[1]]
        };
        let [t0, t1, t2, t3] = [sum, difference, -difference, -sum].map(along);
        let over = of(1.0 / (4.0 * self.a * self.b * self.way));
        let value = ((t0[0] - t1[0]) - (t2[0] - t3[0])) * over - of(1.0);
        let slope = ((t0[1] - t1[1]) - (t2[1] - t3[1])) * over;
        self.within_reach(d, [value, slope])
    }

    /// S and R at many places.
    #[inline(always)]
    fn moved_integrals(&self, gauss: Gauss, t: Lanes) -> [Lanes; 2] {
        let (of, s) = (Lanes::splat, self.sigma);
        let [big, small] = gauss.at_lanes(t * of(1.0 / s));
        let square = t * t;
        let first = of(0.5) * ((square + of(s * s)) * big + t * of(s) * small);
        let second = t * (square + of(3.0 * s * s)) * big + (square + of(2.0 * s * s)) * of(s) * small;
        [second * of(1.0 / 6.0), first]
    }

    /// R and R' at many places. A function, not a closure, so that it is inlined where vectors are wide.
    #[inline(always)]
    fn integrals(&self, gauss: Gauss, t: Lanes) -> [Lanes; 2] {
        let (of, s) = (Lanes::splat, self.sigma);
        let [big, small] = gauss.at_lanes(t * of(1.0 / s));
        [of(0.5) * ((t * t + of(s * s)) * big + t * of(s) * small), t * big + of(s) * small]
    }

    /// The response of a pixel to a sharp edge (s = 0): a parabola, a line and a parabola.
    ///
    /// The slope is that of a slightly wider pixel: where an edge lies on a pixel's border, neither pixel beside it would
    /// tell which way to move, and a fit would stop there.
    #[inline(always)]
    pub(super) fn sharp(&self, d: f64) -> Edge {
        let above = |t: f64| if t > 0.0 { t } else { 0.0 };
        let wide = Self { b: self.b.max(SHARP_MARGIN), a: self.a.max(SHARP_MARGIN), ..*self };
        let inside = 2.0 * self.corners(d, |t| 0.5 * above(t) * above(t)) - 1.0;
        let rises = 2.0 * wide.corners(d, above);
        // Without branches, so that many distances go through at once.
        let value = if d.abs() < self.a + self.b { inside } else { d.signum() };
        let slope = if d.abs() < self.a + self.b + SHARP_MARGIN { rises } else { 0.0 };
        Edge { value, slope, bend: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal(degrees: f64) -> DVec2 {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        DVec2::new(cos, sin)
    }

    #[test]
    fn exact_response_is_the_mean_over_the_pixel_of_a_blurred_edge() {
        let gauss = Gauss::new();
        for (degrees, s, d) in [(0.0, 0.5, 0.2), (20.0, 0.3, -0.4), (45.0, 1.0, 0.9), (77.0, 0.1, 0.05)] {
            let n = normal(degrees);
            let side = 400;
            let mean = (0..side * side)
                .map(|k| {
                    let at = |i: usize| (i as f64 + 0.5) / side as f64 - 0.5;
                    let t = d + n.dot(DVec2::new(at(k % side), at(k / side)));
                    libm::erf(t / s * std::f64::consts::FRAC_1_SQRT_2)
                })
                .sum::<f64>()
                / (side * side) as f64;
            // The midpoint rule errs by E'' h^2 / 24 < 1e-4 / s^2 / 400^2; the floor of b by b^2.
            assert!((EdgeShape::new(n, s).exact(gauss, d).value - mean).abs() < 5e-6, "{degrees} {s} {d}");
        }
    }

    #[test]
    fn motion_is_the_mean_over_its_way() {
        let gauss = Gauss::new();
        // Across the edge, aslant, and along it but for little.
        for (degrees, s, way) in
            [(0.0, 0.3, 4.0), (37.0, 0.05, 1.0), (90.0, 0.7, 8.0), (20.0, 1.5, 0.5), (89.5, 0.1, 6.0)]
        {
            let (n, half_way) = (normal(degrees), DVec2::new(way, 0.0));
            let shape = EdgeShape::moved(n, s, half_way);
            for i in -8..8 {
                let d = Lanes::of(|k| (f64::from(i) + k as f64 / 8.0) * 0.13 * shape.reach());
                let [values, slopes] = shape.exact_lanes(gauss, d);
                for k in 0..values.0.len() {
                    // The midpoint rule errs by way^2 E'' / (6 parts^2).
                    let parts = 4000;
                    let step = |p: i32| n.dot(half_way) * (2.0 * (f64::from(p) + 0.5) / f64::from(parts) - 1.0);
                    let still = EdgeShape::new(n, s);
                    let edges = (0..parts).map(|p| still.exact(gauss, d.0[k] + step(p)));
                    let (value, slope) = edges.fold((0.0, 0.0), |sum, e| (sum.0 + e.value, sum.1 + e.slope));
                    let [value, slope] = [value, slope].map(|sum| sum / f64::from(parts));
                    // What the dropped tail holds, and its slope at the end: 7e-6 and 1.6e-5 over the blur.
                    assert!((values.0[k] - value).abs() < 1.5e-5, "{degrees} {s} {way} {}", d.0[k]);
                    assert!((slopes.0[k] - slope).abs() < 1e-5 + 4e-5 / s, "{degrees} {s} {way} {}", d.0[k]);
                }
            }
        }
    }

    #[test]
    fn derivatives_agree_with_central_differences() {
        let gauss = Gauss::new();
        let h = 1e-5;
        for (degrees, s, d) in [(3.0, 0.5, 0.2), (20.0, 0.3, -0.4), (45.0, 1.0, 0.9)] {
            let shape = EdgeShape::new(normal(degrees), s);
            let edge = shape.exact(gauss, d);
            let (low, high) = (shape.exact(gauss, d - h), shape.exact(gauss, d + h));
            assert!((edge.slope - (high.value - low.value) / (2.0 * h)).abs() < 1e-7);
            assert!((edge.bend - (high.slope - low.slope) / (2.0 * h)).abs() < 1e-7);
            let wider = EdgeShape::new(normal(degrees), s + h).exact(gauss, d).value;
            let narrower = EdgeShape::new(normal(degrees), s - h).exact(gauss, d).value;
            assert!((s * edge.bend - (wider - narrower) / (2.0 * h)).abs() < 1e-7);
        }
    }
}
