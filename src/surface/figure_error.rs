//! Figure error: the departure of a surface as built from its nominal height.

use crate::num::bernstein::MAX_DEGREE;
use crate::num::poly2::{Jet, Poly2};
use glam::DVec2;

/// A height to be added to a surface, over x and y.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureError {
    /// A polynomial, in mm.
    pub sag: Poly2,
    /// Waves.
    pub waves: Vec<SurfaceWave>,
}

/// A wave across a surface, as tools leave it: amplitude cos(k . (x, y) + phase).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceWave {
    /// The amplitude, in mm.
    pub amplitude_mm: f64,
    /// The wave vector k, in rad/mm.
    pub rad_per_mm: DVec2,
    /// The phase, in rad.
    pub phase_rad: f64,
}

impl FigureError {
    /// Whether it adds nothing.
    pub fn is_nothing(&self) -> bool {
        self.sag.terms().all(|(_, _, c)| c == 0.0) && self.waves.iter().all(|wave| wave.amplitude_mm == 0.0)
    }

    /// The height with its derivatives.
    pub fn jet(&self, x: f64, y: f64) -> Jet {
        let mut jet = self.sag.jet(x, y);
        for wave in &self.waves {
            let k = wave.rad_per_mm;
            let (sin, cos) = libm::sincos(k.dot(DVec2::new(x, y)) + wave.phase_rad);
            let (height, slope) = (wave.amplitude_mm * cos, -wave.amplitude_mm * sin);
            jet.value += height;
            jet.dx += slope * k.x;
            jet.dy += slope * k.y;
            jet.dxx -= height * k.x * k.x;
            jet.dxy -= height * k.x * k.y;
            jet.dyy -= height * k.y * k.y;
        }
        jet
    }
}

/// A term of [`zernike`]: n, m and the root mean square of its height over the disk, in mm.
pub type ZernikeTerm = (usize, i32, f64);

/// A sum of Zernike terms over a disk of radius `radius_mm` about the origin, as a polynomial of x and y. Each polynomial
/// has a root mean square of 1 over the disk; m >= 0 goes with cos(m theta), m < 0 with sin(|m| theta), theta from +x to
/// +y (ANSI Z80.28; Born & Wolf, Principles of Optics, 9.2.1). `None` where a term has no |m| <= n, n - |m| even and
/// n <= 20.
pub fn zernike(radius_mm: f64, terms: &[ZernikeTerm]) -> Option<Poly2> {
    // Add term by term.
    let mut table = [[0.0; MAX_DEGREE + 1]; MAX_DEGREE + 1];
    for &(n, m, c) in terms {
        let order = m.unsigned_abs() as usize;
        if n > MAX_DEGREE || order > n || (n - order) % 2 == 1 {
            return None;
        }

        // Sum up the radial polynomial, scaled to a root mean square of 1.
        let norm = (if m == 0 { n as f64 + 1.0 } else { 2.0 * (n as f64 + 1.0) }).sqrt();
        for s in 0..=(n - order) / 2 {
            let sign = if s % 2 == 1 { -1.0 } else { 1.0 };
            let radial = sign * factorial(n - s)
                / (factorial(s) * factorial((n + order) / 2 - s) * factorial((n - order) / 2 - s));

            // Expand rho^(n - 2s) cos or sin in x and y: (x^2 + y^2)^k times the real or imaginary part of (x + i
            // y)^order.
            let k = (n - order) / 2 - s;
            for a in 0..=k {
                for b in 0..=order {
                    let imaginary = b % 2 == 1;
                    if imaginary != (m < 0) {
                        continue;
                    }
                    let turn = if (b / 2) % 2 == 1 { -1.0 } else { 1.0 };
                    let power_y = 2 * a + b;
                    let power_x = 2 * (k - a) + (order - b);
                    table[power_x][power_y] += c * norm * radial * choose(k, a) * choose(order, b) * turn;
                }
            }
        }
    }
    let degree = terms.iter().map(|term| term.0).max().unwrap_or(0);
    Some(Poly2::new(degree, [0.0; 2], [radius_mm; 2], |m, n| table[m][n]))
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|k| k as f64).product()
}

fn choose(n: usize, k: usize) -> f64 {
    factorial(n) / (factorial(k) * factorial(n - k))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::quadrature::gauss_legendre;
    use std::f64::consts::TAU;

    /// Mean over the unit disk of the product of two terms.
    fn product(a: ZernikeTerm, b: ZernikeTerm) -> f64 {
        let (a, b) = (zernike(1.0, &[a]).expect("a term"), zernike(1.0, &[b]).expect("a term"));
        let turns = 64;
        let mut sum = 0.0;
        for [r2, w] in gauss_legendre(24) {
            for k in 0..turns {
                let (sin, cos) = libm::sincos(TAU * f64::from(k) / f64::from(turns));
                let r = r2.sqrt();
                sum += w * a.value(r * cos, r * sin) * b.value(r * cos, r * sin) / f64::from(turns);
            }
        }
        sum
    }

    #[test]
    fn terms_are_orthonormal_over_the_disk() {
        let terms: Vec<(usize, i32)> =
            (0..=8usize).flat_map(|n| (0..=n).map(move |k| (n, 2 * k as i32 - n as i32))).collect();
        for (i, &(n, m)) in terms.iter().enumerate() {
            for &(p, q) in &terms[..=i] {
                let expected = f64::from(u8::from((n, m) == (p, q)));
                let found = product((n, m, 1.0), (p, q, 1.0));
                // Coefficients of degree 8 are below 1e4, and cancel.
                assert!((found - expected).abs() < 1e-10, "({n}, {m}) ({p}, {q}): {found}");
            }
        }
    }

    #[test]
    fn low_terms_are_the_known_ones() {
        let at = |term: ZernikeTerm, x: f64, y: f64| zernike(2.0, &[term]).expect("a term").value(x, y);
        let (x, y) = (0.6, -0.8);
        let (u, v) = (0.5 * x, 0.5 * y);
        assert!((at((1, 1, 1.0), x, y) - 2.0 * u).abs() < 1e-15);
        assert!((at((1, -1, 1.0), x, y) - 2.0 * v).abs() < 1e-15);
        assert!((at((2, 0, 1.0), x, y) - 3f64.sqrt() * (2.0 * (u * u + v * v) - 1.0)).abs() < 1e-15);
        assert!((at((2, -2, 1.0), x, y) - 6f64.sqrt() * 2.0 * u * v).abs() < 1e-15);
        assert!((at((3, 3, 1.0), x, y) - 8f64.sqrt() * (u * u * u - 3.0 * u * v * v)).abs() < 1e-15);
        assert!(zernike(1.0, &[(2, 1, 1.0)]).is_none() && zernike(1.0, &[(2, 4, 1.0)]).is_none());
    }

    #[test]
    fn derivatives_are_those_of_the_height() {
        let sag = zernike(10.0, &[(4, 2, 1e-3), (3, -1, 2e-3)]).expect("terms");
        let wave = SurfaceWave { amplitude_mm: 1e-3, rad_per_mm: DVec2::new(2.0, -3.0), phase_rad: 0.4 };
        let flaw = FigureError { sag, waves: vec![wave] };
        let (x, y, h) = (3.0, -2.0, 1e-4);
        let (here, right, down) = (flaw.jet(x, y), flaw.jet(x + h, y), flaw.jet(x, y + h));
        let (left, up) = (flaw.jet(x - h, y), flaw.jet(x, y - h));
        // Central differences: the third derivatives are some 1e-3 x 3^3 = 0.03, over 6, times h^2, and rounding 1e-19 / h.
        for (found, expected) in [
            ((right.value - left.value) / (2.0 * h), here.dx),
            ((down.value - up.value) / (2.0 * h), here.dy),
            ((right.dx - left.dx) / (2.0 * h), here.dxx),
            ((right.dy - left.dy) / (2.0 * h), here.dxy),
            ((down.dy - up.dy) / (2.0 * h), here.dyy),
        ] {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }
}
