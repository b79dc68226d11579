//! Series of Zernike's polynomials, which are orthogonal over the unit disc.
//!
//! For n = m + 2k the radial part is r^m P_k(2 r^2 - 1), with Jacobi's polynomial of parameters (0, m), here scaled so that the mean
//! square of every polynomial over the disc is 1 (M. Born, E. Wolf, Principles of Optics, 9.2; recurrence: M. Abramowitz, I. Stegun,
//! Handbook of Mathematical Functions, 22.7.1).

use super::quadrature::gauss_legendre;
use glam::DVec2;
use std::f64::consts::TAU;

/// A point of the disc with its share of the area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiscNode {
    /// The point.
    pub at: DVec2,
    /// Its weight; the weights of all have the sum 1.
    pub weight: f64,
}

/// Points with weights that give the exact mean over the disc of polynomials up to degree 2 `degree`.
pub fn nodes(degree: usize) -> Vec<DiscNode> {
    let spokes = 2 * degree + 2;
    let rings = gauss_legendre(degree / 2 + 1);
    let on = |[square, weight]: [f64; 2], spoke: usize| {
        let angle = TAU * (spoke as f64 + 0.5) / spokes as f64;
        let at = square.sqrt() * DVec2::new(libm::cos(angle), libm::sin(angle));
        DiscNode { at, weight: weight / spokes as f64 }
    };
    rings.into_iter().flat_map(|ring| (0..spokes).map(move |spoke| on(ring, spoke))).collect()
}

/// A function over the unit disc, as sum over n, m of polynomials up to a degree.
#[derive(Debug, Clone, PartialEq)]
pub struct ZernikeSeries {
    degree: usize,
    /// In the order in which [`terms`] makes the polynomials.
    coefficients: Vec<f64>,
}

impl ZernikeSeries {
    /// The series of `degree` that is nearest, in the mean square over the disc, to the function with these values at
    /// [`nodes`]`(degree)`.
    pub fn new(degree: usize, values: &[f64]) -> Self {
        let mut coefficients = vec![0.0; count(degree)];
        for (node, value) in nodes(degree).iter().zip(values) {
            terms(degree, node.at, |k, term| coefficients[k] += node.weight * value * term);
        }
        Self { degree, coefficients }
    }

    /// Its value at a point.
    pub fn at(&self, point: DVec2) -> f64 {
        let mut sum = 0.0;
        terms(self.degree, point, |k, term| sum += self.coefficients[k] * term);
        sum
    }
}

/// How many polynomials there are up to a degree.
fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

/// Gives every polynomial's value at `point`, with its number: for each m the cosines and then, but for m = 0, the sines, by rising
/// n.
fn terms(degree: usize, point: DVec2, mut each: impl FnMut(usize, f64)) {
    let x = 2.0 * point.length_squared() - 1.0;
    let (mut number, mut power) = (0, DVec2::X);
    for m in 0..=degree {
        let steps = (degree - m) / 2 + 1;
        let mf = m as f64;
        let (mut before, mut now) = (0.0, 1.0);
        for k in 0..steps {
            let kf = k as f64;
            if k == 1 {
                (before, now) = (1.0, 1.0 + 0.5 * (mf + 2.0) * (x - 1.0));
            } else if k > 1 {
                let t = 2.0 * kf + mf;
                let next = ((t - 1.0) * (t * (t - 2.0) * x - mf * mf) * now
                    - 2.0 * (kf - 1.0) * (kf + mf - 1.0) * t * before)
                    / (2.0 * kf * (kf + mf) * (t - 2.0));
                (before, now) = (now, next);
            }
            let scale = ((2.0 * kf + mf + 1.0) * if m == 0 { 1.0 } else { 2.0 }).sqrt();
            each(number + k, scale * power.x * now);
            if m > 0 {
                each(number + steps + k, scale * power.y * now);
            }
        }
        number += if m == 0 { steps } else { 2 * steps };
        // r^m (cos m t, sin m t), as a complex power.
        power = DVec2::new(power.x * point.x - power.y * point.y, power.x * point.y + power.y * point.x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The means of products are 1 of equals, 0 of others.
    #[test]
    fn polynomials_are_orthonormal() {
        let degree = 9;
        let mut products = vec![vec![0.0; count(degree)]; count(degree)];
        for node in nodes(degree) {
            let mut values = vec![f64::NAN; count(degree)];
            terms(degree, node.at, |k, value| values[k] = value);
            for (row, a) in products.iter_mut().zip(&values) {
                row.iter_mut().zip(&values).for_each(|(sum, b)| *sum += node.weight * a * b);
            }
        }
        for (i, row) in products.iter().enumerate() {
            for (j, found) in row.iter().enumerate() {
                let wanted = f64::from(u8::from(i == j));
                assert!((found - wanted).abs() < 1e-12, "{i} {j}: {found}");
            }
        }
    }

    #[test]
    fn a_polynomial_is_its_own_series() {
        let f = |p: DVec2| 1.0 + p.x - 2.0 * p.y * p.x * p.x + 0.3 * p.y * p.y * p.y * p.y * p.x;
        let values: Vec<f64> = nodes(6).iter().map(|node| f(node.at)).collect();
        let series = ZernikeSeries::new(6, &values);
        for p in [DVec2::new(0.3, -0.8), DVec2::ZERO, DVec2::new(-1.0, 0.0)] {
            assert!((series.at(p) - f(p)).abs() < 1e-13, "{p}");
        }
    }
}
