//! Polynomials of two variables with value, gradient and Hessian.

use super::bernstein::{Bernstein, MAX_DEGREE};

/// p(x, y) = sum over m + n <= degree of c_mn X^m Y^n, with X = (x - x0)/sx and Y = (y - y0)/sy.
///
/// Centre and scale keep |X|, |Y| near 1 over the domain, where powers of raw mm would be ill-conditioned.
/// Coefficients are in the unit of p.
#[derive(Debug, Clone, PartialEq)]
pub struct Poly2 {
    degree: usize,
    centre: [f64; 2],
    /// 1 / scale, so that an evaluation has no division.
    inverse_scale: [f64; 2],
    scale: [f64; 2],
    /// Row n (power of Y) after row, each row by rising power of X: row n holds `degree - n + 1` values.
    coefficients: Vec<f64>,
}

/// Value, gradient and Hessian of a function of (x, y).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jet {
    /// p
    pub value: f64,
    /// dp/dx
    pub dx: f64,
    /// dp/dy
    pub dy: f64,
    /// d2p/dx2
    pub dxx: f64,
    /// d2p/dxdy
    pub dxy: f64,
    /// d2p/dy2
    pub dyy: f64,
}

impl Poly2 {
    /// A polynomial of total degree `degree` from `c(m, n)`, the coefficient of X^m Y^n.
    ///
    /// # Panics
    /// When `degree` is above [`MAX_DEGREE`], or a scale is not a positive finite number.
    pub fn new(degree: usize, centre: [f64; 2], scale: [f64; 2], c: impl Fn(usize, usize) -> f64) -> Self {
        assert!(degree <= MAX_DEGREE, "degree {degree} is above {MAX_DEGREE}");
        assert!(scale.iter().all(|s| s.is_finite() && *s > 0.0), "the scale of a polynomial must be positive");
        let coefficients =
            (0..=degree).flat_map(|n| (0..=degree - n).map(move |m| (m, n))).map(|(m, n)| c(m, n)).collect();
        Self { degree, centre, inverse_scale: [1.0 / scale[0], 1.0 / scale[1]], scale, coefficients }
    }

    /// The same polynomial about another centre, with one scale for both axes: p = sum of c_ij ((x - x0)/s)^i ((y - y0)/s)^j.
    ///
    /// # Panics
    /// As [`Poly2::new`].
    #[must_use]
    pub fn about(&self, centre: [f64; 2], scale: f64) -> Self {
        // Of X = a + b X' every power, as a polynomial in X'.
        let powers = |axis: usize| {
            let a = (centre[axis] - self.centre[axis]) / self.scale[axis];
            let b = scale / self.scale[axis];
            let mut all = vec![vec![1.0]];
            for m in 0..self.degree {
                let next = |i: usize| {
                    let below = i.checked_sub(1).map_or(0.0, |k| b * all[m][k]);
                    below + all[m].get(i).map_or(0.0, |c| a * c)
                };
                let row = (0..=m + 1).map(next).collect();
                all.push(row);
            }
            all
        };
        let [along_x, along_y] = [powers(0), powers(1)];
        let coefficient = |i: usize, j: usize| {
            let higher = self.terms().filter(|(m, n, _)| *m >= i && *n >= j);
            higher.map(|(m, n, c)| c * along_x[m][i] * along_y[n][j]).sum()
        };
        Self::new(self.degree, centre, [scale; 2], coefficient)
    }

    /// The mirror image p(-x, y).
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let coefficients = self.terms().map(|(m, _, c)| if m % 2 == 0 { c } else { -c }).collect();
        Self { centre: [-self.centre[0], self.centre[1]], coefficients, ..self.clone() }
    }

    /// Total degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// (x0, y0).
    pub fn centre(&self) -> [f64; 2] {
        self.centre
    }

    /// (sx, sy).
    pub fn scale(&self) -> [f64; 2] {
        self.scale
    }

    /// (1/sx, 1/sy)
    pub(crate) fn inverse_scale(&self) -> [f64; 2] {
        self.inverse_scale
    }

    /// The coefficients by falling power of Y; those of one power of Y by rising power of X.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        (0..=self.degree).rev().scan(self.coefficients.len(), |end, n| {
            let start = *end - (self.degree - n + 1);
            Some(&self.coefficients[start..std::mem::replace(end, start)])
        })
    }

    /// Every coefficient with the powers (m, n) of X and Y.
    pub fn terms(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let powers = (0..=self.degree).flat_map(|n| (0..=self.degree - n).map(move |m| (m, n)));
        powers.zip(&self.coefficients).map(|((m, n), &c)| (m, n, c))
    }

    /// p(x, y).
    #[inline]
    pub fn value(&self, x: f64, y: f64) -> f64 {
        self.gradient(x, y).0
    }

    /// p, dp/dx and dp/dy by nested Horner schemes.
    #[inline]
    pub fn gradient(&self, x: f64, y: f64) -> (f64, f64, f64) {
        let u = (x - self.centre[0]) * self.inverse_scale[0];
        let v = (y - self.centre[1]) * self.inverse_scale[1];
        let (mut p, mut pu, mut pv) = (0.0, 0.0, 0.0);
        let mut end = self.coefficients.len();
        for n in (0..=self.degree).rev() {
            let start = end - (self.degree - n + 1);
            let (mut r, mut ru) = (0.0, 0.0);
            for &c in self.coefficients[start..end].iter().rev() {
                ru = ru * u + r;
                r = r * u + c;
            }
            pv = pv * v + p;
            p = p * v + r;
            pu = pu * v + ru;
            end = start;
        }
        (p, pu * self.inverse_scale[0], pv * self.inverse_scale[1])
    }

    /// p along the straight way between two points, as a polynomial of the share s of the way in 0..=1.
    pub fn along(&self, from: [f64; 2], to: [f64; 2]) -> Bernstein {
        let scaled = |k: usize| [from[k], to[k]].map(|c| (c - self.centre[k]) * self.inverse_scale[k]);
        let (u, v) = (scaled(0), scaled(1));
        let mut p = Bernstein::ZERO;
        let mut end = self.coefficients.len();
        for n in (0..=self.degree).rev() {
            let start = end - (self.degree - n + 1);
            let row = self.coefficients[start..end].iter().rev();
            let row = row.enumerate().fold(Bernstein::ZERO, |r, (k, &c)| {
                // The first product would be that of nothing and only raise the degree.
                if k == 0 { Bernstein::constant(c) } else { r.times_line(u).plus_constant(c) }
            });
            p = if n == self.degree { row } else { p.times_line(v).plus(&row) };
            end = start;
        }
        p
    }

    /// p with all first and second derivatives.
    #[inline]
    pub fn jet(&self, x: f64, y: f64) -> Jet {
        let u = (x - self.centre[0]) * self.inverse_scale[0];
        let v = (y - self.centre[1]) * self.inverse_scale[1];
        let mut j = Jet::default();
        let mut end = self.coefficients.len();
        for n in (0..=self.degree).rev() {
            let start = end - (self.degree - n + 1);
            // The row's value, first derivative and half its second derivative.
            let (mut r, mut r1, mut r2) = (0.0, 0.0, 0.0);
            for &c in self.coefficients[start..end].iter().rev() {
                r2 = r2 * u + r1;
                r1 = r1 * u + r;
                r = r * u + c;
            }
            j.dyy = j.dyy * v + 2.0 * j.dy;
            j.dxy = j.dxy * v + j.dx;
            j.dy = j.dy * v + j.value;
            j.value = j.value * v + r;
            j.dx = j.dx * v + r1;
            j.dxx = j.dxx * v + 2.0 * r2;
            end = start;
        }
        let [a, b] = self.inverse_scale;
        Jet { value: j.value, dx: j.dx * a, dy: j.dy * b, dxx: j.dxx * a * a, dxy: j.dxy * a * b, dyy: j.dyy * b * b }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Poly2 {
        Poly2::new(5, [1.0, -2.0], [3.0, 0.5], |m, n| 0.1 * (m as f64 + 1.0) - 0.3 * n as f64 + 0.01 * (m * n) as f64)
    }

    #[test]
    fn value_is_the_sum_of_its_terms() {
        let p = sample();
        let (x, y) = (1.7, -1.8);
        let (u, v) = ((x - 1.0) / 3.0, (y + 2.0) / 0.5);
        let direct: f64 = p
            .terms()
            .map(|(m, n, c)| c * (0..m).map(|_| u).product::<f64>() * (0..n).map(|_| v).product::<f64>())
            .sum();
        assert!((p.value(x, y) - direct).abs() < 1e-14);
    }

    #[test]
    fn along_a_way_it_is_itself() {
        let p = sample();
        let (from, to) = ([-1.9, -2.4], [3.8, -1.6]);
        let along = p.along(from, to);
        for k in 0..=16 {
            let s = k as f64 / 16.0;
            let at = |k: usize| from[k] + (to[k] - from[k]) * s;
            assert!((along.value(s) - p.value(at(0), at(1))).abs() < 1e-13, "{s}");
        }
    }

    #[test]
    fn about_another_centre_and_mirrored_it_is_itself() {
        let p = sample();
        let (moved, mirrored) = (p.about([0.25, 0.0], 4.0), p.mirrored());
        assert_eq!((moved.centre(), moved.scale()), ([0.25, 0.0], [4.0, 4.0]));
        for k in 0..=16 {
            let (x, y) = (-1.0 + 0.3 * k as f64, -2.4 + 0.05 * k as f64);
            // Terms about (0.25, 0) reach (4 + 8 |y|/4)^5 = 5e4 here, and cancel: some ten roundings of that.
            assert!((moved.value(x, y) - p.value(x, y)).abs() < 1e-10, "{x} {y}");
            assert_eq!(mirrored.value(-x, y), p.value(x, y));
        }
    }

    #[test]
    fn derivatives_agree_with_central_differences() {
        let p = sample();
        let (x, y, h) = (1.7, -1.8, 1e-4);
        let j = p.jet(x, y);
        assert_eq!((j.value, j.dx, j.dy), p.gradient(x, y));
        let slope = |f: &dyn Fn(f64) -> f64| (f(h) - f(-h)) / (2.0 * h);
        // A central difference errs by h^2/6 times the third derivative, here below 3e-6.
        assert!((slope(&|t| p.value(x + t, y)) - j.dx).abs() < 3e-6);
        assert!((slope(&|t| p.value(x, y + t)) - j.dy).abs() < 3e-6);
        assert!((slope(&|t| p.gradient(x + t, y).1) - j.dxx).abs() < 3e-6);
        assert!((slope(&|t| p.gradient(x, y + t).1) - j.dxy).abs() < 3e-6);
        assert!((slope(&|t| p.gradient(x, y + t).2) - j.dyy).abs() < 3e-5);
    }
}
