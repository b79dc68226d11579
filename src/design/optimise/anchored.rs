//! The surface of the search: Chebyshev polynomials over the glass that the half image is seen through.
//!
//! sag(x, y) = h + sum of c_mn (T_m(X) T_n(Y) - mean of T_m T_n) over 0 < m + n <= p with even n, X and Y from -1 to 1 over the
//! glass. Its mean height h is held: both surfaces moved together are a direction that hardly matters. Over this basis the
//! condition of the search is about 5 where that of powers is thousands.

use crate::geom::Rect;
use crate::num::chebyshev::power_table;
use crate::num::poly2::Poly2;
use crate::num::scalar::Differentiable;
use crate::scene::{DESIGN_DEGREE, Rear};
use glam::DVec2;

/// Values of T_0, T_1, ... at one place.
type Row<N> = [N; DESIGN_DEGREE + 1];

/// Which surfaces can be reached, and where their glass is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AnchoredBasis {
    degree: usize,
    centre: DVec2,
    scale: DVec2,
    /// h, in mm.
    pub(super) mean_mm: f64,
    /// (m, n) of each unknown.
    terms: Vec<(usize, usize)>,
}

/// The mean of T_k over -1 .. 1.
fn mean(k: usize) -> f64 {
    if k % 2 == 1 { 0.0 } else { 1.0 / (1.0 - (k * k) as f64) }
}

/// T_k(t) and its slope, k = 0 .. degree.
fn rows<N: Differentiable>(t: N, degree: usize) -> [Row<N>; 2] {
    let (mut value, mut slope) = ([N::constant(0.0); DESIGN_DEGREE + 1], [N::constant(0.0); DESIGN_DEGREE + 1]);
    (value[0], value[1], slope[1]) = (N::constant(1.0), t, N::constant(1.0));
    for k in 2..=degree {
        value[k] = (t * value[k - 1]).times(2.0) - value[k - 2];
        slope[k] = (value[k - 1] + t * slope[k - 1]).times(2.0) - slope[k - 2];
    }
    [value, slope]
}

impl AnchoredBasis {
    /// The surfaces of degree `degree` over `glass`, which is symmetric in y, of the mean height `mean_mm`.
    pub(super) fn new(glass: Rect, degree: usize, shape: Rear, mean_mm: f64) -> Self {
        debug_assert!(glass.min.y == -glass.max.y, "{glass:?}");
        let mut scale = 0.5 * (glass.max - glass.min);
        let mut centre = 0.5 * (glass.max + glass.min);
        if shape != Rear::Own {
            (scale.x, centre.x) = (glass.min.x.abs().max(glass.max.x.abs()), 0.0);
        }
        let all = (0..=degree).step_by(2).flat_map(|n| (0..=degree - n).map(move |m| (m, n)));
        let kept = |&(m, n): &(usize, usize)| match shape {
            Rear::Own => m + n > 0,
            Rear::Even => m + n > 0 && m % 2 == 0,
            Rear::Flat => false,
        };
        Self { degree, centre, scale, mean_mm, terms: all.filter(kept).collect() }
    }

    /// Total degree.
    pub(super) fn degree(&self) -> usize {
        self.degree
    }

    /// How many unknowns it has.
    pub(super) fn len(&self) -> usize {
        self.terms.len()
    }

    /// The coefficients of the plane of slope `slope` along x.
    pub(super) fn plane(&self, slope: f64) -> Vec<f64> {
        self.terms.iter().map(|&term| if term == (1, 0) { slope * self.scale.x } else { 0.0 }).collect()
    }

    /// The coefficients in this basis of the surface that has `c` in `lower`.
    pub(super) fn raised(&self, lower: &Self, c: &[f64]) -> Vec<f64> {
        let own = |term| lower.terms.iter().position(|t| *t == term).map_or(0.0, |k| c[k]);
        self.terms.iter().map(|&term| own(term)).collect()
    }

    /// z, dz/dx and dz/dy at (x, y), where `times(k, t)` is t times the k-th coefficient.
    pub(super) fn heights<N: Differentiable>(&self, x: N, y: N, times: impl Fn(usize, N) -> N) -> [N; 3] {
        let zero = N::constant(0.0);
        let [t, dt] = rows((x - N::constant(self.centre.x)).times(1.0 / self.scale.x), self.degree);
        let [u, du] = rows((y - N::constant(self.centre.y)).times(1.0 / self.scale.y), self.degree);
        let mut z = [N::constant(self.mean_mm), zero, zero];
        let mut k = 0;
        while k < self.terms.len() {
            // Sum up the terms of one power of y.
            let n = self.terms[k].1;
            let (mut sum, mut slope, mut level) = (zero, zero, zero);
            while let Some(&(m, _)) = self.terms.get(k).filter(|term| term.1 == n) {
                sum = sum + times(k, t[m]);
                slope = slope + times(k, dt[m]);
                level = level + times(k, N::constant(mean(m) * mean(n)));
                k += 1;
            }
            z = [z[0] + sum * u[n] - level, z[1] + slope * u[n], z[2] + sum * du[n]];
        }
        [z[0], z[1].times(1.0 / self.scale.x), z[2].times(1.0 / self.scale.y)]
    }

    /// z, dz/dx and dz/dy of every basis function at (x, y).
    pub(super) fn functions(&self, x: f64, y: f64) -> impl Iterator<Item = [f64; 3]> + '_ {
        let [t, dt] = rows((x - self.centre.x) / self.scale.x, self.degree);
        let [u, du] = rows((y - self.centre.y) / self.scale.y, self.degree);
        self.terms.iter().map(move |&(m, n)| {
            [t[m] * u[n] - mean(m) * mean(n), dt[m] * u[n] / self.scale.x, t[m] * du[n] / self.scale.y]
        })
    }

    /// The same surface by powers.
    pub(super) fn polynomial(&self, c: &[f64]) -> Poly2 {
        let table = power_table(self.degree.max(1));
        let power = |p: usize, q: usize| {
            let own = |(k, &(m, n)): (usize, &(usize, usize))| {
                let level = if p + q == 0 { mean(m) * mean(n) } else { 0.0 };
                c[k] * (table[(m, p)] * table[(n, q)] - level)
            };
            let sum: f64 = self.terms.iter().enumerate().map(own).sum();
            if p + q == 0 { self.mean_mm + sum } else { sum }
        };
        Poly2::new(self.degree, self.centre.to_array(), self.scale.to_array(), power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::quadrature::gauss_legendre;

    fn basis(shape: Rear) -> AnchoredBasis {
        AnchoredBasis::new(Rect { min: DVec2::new(-0.5, -7.0), max: DVec2::new(12.0, 7.0) }, 6, shape, 81.0)
    }

    fn coefficients(basis: &AnchoredBasis) -> Vec<f64> {
        (0..basis.len()).map(|k| 0.3 * libm::sin(1.0 + 2.0 * k as f64)).collect()
    }

    /// The polynomial by powers is the same surface, and its mean height over the glass is the one that was given.
    #[test]
    fn the_polynomial_is_the_same_surface_of_the_same_mean_height() {
        for shape in [Rear::Own, Rear::Even, Rear::Flat] {
            let basis = basis(shape);
            let c = coefficients(&basis);
            let powers = basis.polynomial(&c);
            for (x, y) in [(-0.4, 6.5), (3.0, 0.0), (11.0, -4.0)] {
                let [z, zx, zy] = basis.heights(x, y, |k, t| c[k] * t);
                let (value, dx, dy) = powers.gradient(x, y);
                assert!((z - value).abs() < 1e-12 && (zx - dx).abs() < 1e-12 && (zy - dy).abs() < 1e-12, "{shape:?}");
                let mirrored = basis.heights(-x, y, |k, t| c[k] * t)[0];
                assert_eq!(mirrored == z, shape != Rear::Own, "{shape:?}");
            }
            let rule = gauss_legendre(8);
            let at = |k: usize, s: f64| basis.centre[k] + basis.scale[k] * (2.0 * s - 1.0);
            let line = |s: f64| rule.iter().map(|[r, w]| w * powers.value(at(0, s), at(1, *r))).sum::<f64>();
            let mean: f64 = rule.iter().map(|[s, w]| w * line(*s)).sum();
            assert!((mean - 81.0).abs() < 1e-12, "{shape:?}: {mean}");
        }
    }
}
