//! Smooth functions of one variable over an interval, as Chebyshev series.

use super::chebyshev::points;

/// Most coefficients of a series: degree 64.
pub(crate) const MAX_COEFFICIENTS: usize = 65;

/// f(s) = sum over k of c_k T_k(x), x = (s - middle)/half, over |x| <= 1.
#[derive(Debug, Clone, PartialEq)]
pub struct ChebyshevCurve {
    ends: [f64; 2],
    middle: f64,
    inverse_half: f64,
    c: Vec<f64>,
}

impl ChebyshevCurve {
    /// The series of these coefficients over [`ends`\[0\], `ends`\[1\]], the smaller first; without coefficients it is 0.
    pub fn new(ends: [f64; 2], coefficients: Vec<f64>) -> Self {
        let [a, b] = ends;
        Self { ends, middle: 0.5 * (a + b), inverse_half: 2.0 / (b - a), c: coefficients }
    }

    /// The series through the values of `f` at [`ChebyshevCurve::nodes`], its coefficients from the end on left out as long as
    /// they are below `least`.
    pub fn through(ends: [f64; 2], values: &[f64], least: f64) -> Self {
        let n = values.len();
        let angle = |i: usize| std::f64::consts::PI * (i as f64 + 0.5) / n as f64;
        // The nodes rise, so that T_k at the i-th is cos(k (pi - angle)) = (-1)^k cos(k angle).
        let coefficient = |k: usize| {
            let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            let sum: f64 = values.iter().enumerate().map(|(i, v)| v * libm::cos(k as f64 * angle(i))).sum();
            sign * sum * if k == 0 { 1.0 } else { 2.0 } / n as f64
        };
        let mut c: Vec<f64> = (0..n).map(coefficient).collect();
        while c.len() > 1 && c.last().is_some_and(|last| last.abs() < least) {
            c.pop();
        }
        Self::new(ends, c)
    }

    /// `count` Chebyshev points of the interval, rising.
    pub fn nodes(ends: [f64; 2], count: usize) -> Vec<f64> {
        let [middle, half] = [0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])];
        points(count).into_iter().map(|x| middle + half * x).collect()
    }

    /// The interval.
    pub fn ends(&self) -> [f64; 2] {
        self.ends
    }

    /// c_0, c_1, ...
    pub fn coefficients(&self) -> &[f64] {
        &self.c
    }

    /// Middle of the interval, and one over its half length.
    pub fn scale(&self) -> [f64; 2] {
        [self.middle, self.inverse_half]
    }

    /// f and df/ds, by Clenshaw's recurrence and its derivative.
    #[inline(always)]
    pub fn gradient(&self, s: f64) -> [f64; 2] {
        let x = (s - self.middle) * self.inverse_half;
        let twice = x + x;
        let (mut b1, mut b2, mut d1, mut d2) = (0.0, 0.0, 0.0, 0.0);
        for &c in self.c.iter().skip(1).rev() {
            (d1, d2) = (twice * d1 - d2 + (b1 + b1), d1);
            (b1, b2) = (twice * b1 - b2 + c, b1);
        }
        let first = self.c.first().copied().unwrap_or(0.0);
        [x * b1 - b2 + first, (x * d1 - d2 + b1) * self.inverse_half]
    }

    /// f, df/ds and its second derivative.
    pub fn jet(&self, s: f64) -> [f64; 3] {
        let x = (s - self.middle) * self.inverse_half;
        let twice = x + x;
        let (mut b1, mut b2, mut d1, mut d2, mut e1, mut e2) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for &c in self.c.iter().skip(1).rev() {
            (e1, e2) = (twice * e1 - e2 + 4.0 * d1, e1);
            (d1, d2) = (twice * d1 - d2 + (b1 + b1), d1);
            (b1, b2) = (twice * b1 - b2 + c, b1);
        }
        let first = self.c.first().copied().unwrap_or(0.0);
        let bend = (x * e1 - e2 + 2.0 * d1) * self.inverse_half * self.inverse_half;
        [x * b1 - b2 + first, (x * d1 - d2 + b1) * self.inverse_half, bend]
    }

    /// A bound of |f - c_0| over the interval.
    pub fn departure(&self) -> f64 {
        self.c.iter().skip(1).map(|c| c.abs()).sum()
    }

    /// Bounds of df/ds over the interval: that of T_1 is 1, and |d T_k/dx| is k^2 at most.
    pub fn slopes(&self) -> [f64; 2] {
        let even = self.c.get(1).copied().unwrap_or(0.0);
        let beside: f64 = self.c.iter().enumerate().skip(2).map(|(k, c)| c.abs() * (k * k) as f64).sum();
        [even - beside, even + beside].map(|slope| slope * self.inverse_half)
    }

    /// A bound of the magnitude of the second derivative over the interval: that of T_k is k^2 (k^2 - 1)/3 at most.
    pub fn sharpest_bend(&self) -> f64 {
        let most = |k: usize| {
            let square = (k * k) as f64;
            square * (square - 1.0) / 3.0 * self.inverse_half * self.inverse_half
        };
        self.c.iter().enumerate().map(|(k, c)| c.abs() * most(k)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENDS: [f64; 2] = [-1.0, 4.0];

    fn through(count: usize, f: impl Fn(f64) -> f64) -> ChebyshevCurve {
        let values: Vec<f64> = ChebyshevCurve::nodes(ENDS, count).into_iter().map(f).collect();
        ChebyshevCurve::through(ENDS, &values, 0.0)
    }

    /// exp(s/3) is entire: 24 points reproduce it, and its derivatives, to rounding.
    #[test]
    fn a_smooth_function_is_its_own_series() {
        let curve = through(24, |s| libm::exp(s / 3.0));
        for k in 0..=50 {
            let s = -1.0 + 0.1 * f64::from(k);
            let value = libm::exp(s / 3.0);
            let [f, df, ddf] = curve.jet(s);
            assert_eq!(curve.gradient(s), [f, df]);
            // Noise of 1e-15 in 24 coefficients, whose derivatives grow by k^2 and k^4/3.
            assert!((f - value).abs() < 24e-15, "{s}: {f}");
            assert!((df - value / 3.0).abs() < 1e-12 && (ddf - value / 9.0).abs() < 1e-10, "{s}: {df} {ddf}");
        }
    }

    #[test]
    fn small_coefficients_are_left_out_from_the_end_on() {
        let values: Vec<f64> = ChebyshevCurve::nodes(ENDS, 9).into_iter().map(|s| 2.0 - s * s).collect();
        let curve = ChebyshevCurve::through(ENDS, &values, 1e-12);
        assert_eq!(curve.coefficients().len(), 3);
        assert!((curve.gradient(3.0)[0] + 7.0).abs() < 1e-13);
    }

    #[test]
    fn bounds_hold() {
        let curve = through(12, libm::sin);
        let first = curve.coefficients()[0];
        for k in 0..=50 {
            let [f, df, ddf] = curve.jet(-1.0 + 0.1 * f64::from(k));
            assert!((f - first).abs() <= curve.departure());
            let [low, high] = curve.slopes();
            assert!((low..=high).contains(&df) && ddf.abs() <= curve.sharpest_bend());
        }
        // T_k' is k^2 at an end: the bound is reached there by a series of one term besides a straight line.
        let one = ChebyshevCurve::new([-1.0, 1.0], vec![0.0, 5.0, 0.0, 2.0]);
        assert!((one.jet(1.0)[1] - one.slopes()[1]).abs() < 1e-12);
        assert!((one.jet(1.0)[2] - one.sharpest_bend()).abs() < 1e-12);
    }
}
