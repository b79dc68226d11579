//! Smooth functions of two variables as polynomials over the square [-1, 1]^2, by tensor Chebyshev interpolation.
//!
//! Where the function is analytic the coefficients fall geometrically, so that their size tells the error (Trefethen,
//! "Approximation Theory and Approximation Practice", chapters 8 and 16).

use nalgebra::DMatrix;

/// Highest degree in each variable.
pub const MAX_DEGREE: usize = 16;

/// The Chebyshev points of the first kind, rising: the zeros of T_n.
pub fn points(n: usize) -> Vec<f64> {
    (0..n).map(|k| -libm::cos(std::f64::consts::PI * (k as f64 + 0.5) / n as f64)).collect()
}

/// sum over k, l of c_kl T_k(s) T_l(t).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ChebyshevSeries {
    /// c_kl in row k, column l.
    c: DMatrix<f64>,
}

/// Interpolation through fixed points of the square.
#[derive(Debug, Clone)]
pub(crate) struct Interpolation {
    inverse_s: DMatrix<f64>,
    inverse_t: DMatrix<f64>,
}

impl Interpolation {
    /// Through the points (s, t) of all `s` and `t`, which should be near [`points`]; `None` where two coincide.
    pub(crate) fn new(s: &[f64], t: &[f64]) -> Option<Self> {
        let inverse = |p: &[f64]| DMatrix::from_fn(p.len(), p.len(), |i, k| chebyshev(k, p[i])).try_inverse();
        Some(Self { inverse_s: inverse(s)?, inverse_t: inverse(t)? })
    }

    /// The series that has `value(i, j)` at (s_i, t_j).
    pub(crate) fn series(&self, value: impl FnMut(usize, usize) -> f64) -> ChebyshevSeries {
        let values = DMatrix::from_fn(self.inverse_s.ncols(), self.inverse_t.ncols(), value);
        ChebyshevSeries { c: &self.inverse_s * values * self.inverse_t.transpose() }
    }
}

/// T_k(x) by its recurrence.
fn chebyshev(k: usize, x: f64) -> f64 {
    let (mut a, mut b) = (1.0, x);
    for _ in 0..k {
        (a, b) = (b, 2.0 * x * b - a);
    }
    a
}

impl ChebyshevSeries {
    /// The sum of the magnitudes of all coefficients of a degree above `s` in the first or above `t` in the second
    /// variable: what leaving them out changes nowhere by more.
    pub(crate) fn beyond(&self, s: usize, t: usize) -> f64 {
        let (m, n) = self.c.shape();
        (0..m).flat_map(|k| (0..n).map(move |l| (k, l))).filter(|&(k, l)| k > s || l > t).map(|p| self.c[p].abs()).sum()
    }

    /// Degrees in the two variables.
    pub(crate) fn degrees(&self) -> [usize; 2] {
        [self.c.nrows() - 1, self.c.ncols() - 1]
    }

    /// Bounds over the square of the magnitudes of the derivatives of orders (`s`, `t`), each up to 3: the sum of those
    /// of the terms, for |T_k'| <= k^2, |T_k''| <= k^2 (k^2 - 1)/3 and |T_k'''| <= k^2 (k^2 - 1)(k^2 - 4)/15.
    pub(crate) fn bound(&self, s: usize, t: usize) -> f64 {
        let most = |k: usize, order: usize| {
            let q = (k * k) as f64;
            [1.0, q, q * (q - 1.0) / 3.0, q * (q - 1.0) * (q - 4.0) / 15.0][order]
        };
        let (m, n) = self.c.shape();
        let terms = (0..m).flat_map(|k| (0..n).map(move |l| (k, l)));
        terms.map(|(k, l)| self.c[(k, l)].abs() * most(k, s) * most(l, t)).sum()
    }

    /// The coefficients of s^k t^l, `[k][l]`, cut to the degrees `s` and `t`.
    pub(crate) fn powers(&self, s: usize, t: usize) -> Vec<Vec<f64>> {
        let (to_s, to_t) = (power_table(s), power_table(t));
        let cut = self.c.view((0, 0), (s + 1, t + 1));
        let powers = to_s.transpose() * cut * to_t;
        powers.row_iter().map(|row| row.iter().copied().collect()).collect()
    }
}

/// Row k holds the coefficients of T_k by rising power.
pub(crate) fn power_table(degree: usize) -> DMatrix<f64> {
    let mut table = DMatrix::zeros(degree + 1, degree + 1);
    table[(0, 0)] = 1.0;
    if degree > 0 {
        table[(1, 1)] = 1.0;
    }
    for k in 2..=degree {
        for p in 0..=k {
            let risen = if p > 0 { 2.0 * table[(k - 1, p - 1)] } else { 0.0 };
            table[(k, p)] = risen - table[(k - 2, p)];
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn through(n: usize, f: impl Fn(f64, f64) -> f64) -> ChebyshevSeries {
        let p = points(n);
        Interpolation::new(&p, &p).expect("the points differ").series(|i, j| f(p[i], p[j]))
    }

    fn value(powers: &[Vec<f64>], s: f64, t: f64) -> f64 {
        powers.iter().rev().fold(0.0, |sum, row| sum * s + row.iter().rev().fold(0.0, |r, c| r * t + c))
    }

    #[test]
    fn a_polynomial_is_its_own_series() {
        let f = |s: f64, t: f64| 1.0 - 2.0 * s * t * t + 0.5 * s * s * s;
        let powers = through(6, f).powers(5, 5);
        for (k, l, c) in [(0, 0, 1.0), (1, 2, -2.0), (3, 0, 0.5), (2, 2, 0.0)] {
            assert!((powers[k][l] - c).abs() < 1e-14, "{k} {l}: {}", powers[k][l]);
        }
    }

    /// 1/(3 - s - t) is analytic up to s + t = 3; what is left out beyond a degree bounds the error there.
    #[test]
    fn coefficients_tell_the_error() {
        let f = |s: f64, t: f64| 1.0 / (3.0 - s - t);
        let series = through(17, f);
        for degree in [4, 8, 12] {
            let powers = series.powers(degree, degree);
            let worst = (0..400).fold(0.0f64, |w, k| {
                let (s, t) = (libm::sin(1.3 * k as f64), libm::cos(0.7 * k as f64));
                w.max((value(&powers, s, t) - f(s, t)).abs())
            });
            // The series itself is wrong by the terms beyond its own degree, here below a hundredth of the kept tail.
            let left_out = series.beyond(degree, degree);
            assert!(worst < 1.02 * left_out && worst > 0.01 * left_out, "{degree}: {worst} {left_out}");
        }
    }

    #[test]
    fn bounds_hold_and_are_not_far() {
        let series = through(12, |s, t| libm::exp(0.3 * s) * (1.0 + 0.2 * t));
        let slope = |s: usize, t: usize, largest: f64| {
            let bound = series.bound(s, t);
            assert!(bound >= largest * (1.0 - 1e-12) && bound < 1.3 * largest, "{s} {t}: {bound} {largest}");
        };
        let e = libm::exp(0.3);
        slope(0, 0, 1.2 * e);
        slope(1, 0, 0.3 * 1.2 * e);
        slope(2, 0, 0.09 * 1.2 * e);
        slope(0, 1, 0.2 * e);
        slope(3, 0, 0.027 * 1.2 * e);
    }
}
