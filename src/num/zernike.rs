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
pub(crate) struct ZernikeSeries {
    /// For each m, by rising n.
    orders: Vec<Vec<(RadialStep, Amplitudes)>>,
}

/// The factors of a radial polynomial's cosine and sine.
type Amplitudes = DVec2;

impl ZernikeSeries {
    /// The series of `degree` that is nearest, in the mean square over the disc, to the function with these values at
    /// [`nodes`]`(degree)`.
    pub(crate) fn new(degree: usize, values: &[f64]) -> Self {
        let mut orders: Vec<Vec<(RadialStep, Amplitudes)>> =
            (0..=degree).map(|m| radial_steps(degree, m).map(|step| (step, DVec2::ZERO)).collect()).collect();
        for (node, value) in nodes(degree).iter().zip(values) {
            let mut power = DVec2::X;
            for order in &mut orders {
                let mut radial = Radial::new(node.at);
                for (step, sum) in order {
                    *sum += power * (node.weight * value * step.scale * step.scale * radial.next(step));
                }
                power = turned(power, node.at);
            }
        }
        Self { orders }
    }

    /// Its value at a point.
    pub(crate) fn at(&self, point: DVec2) -> f64 {
        let (mut sum, mut power) = (0.0, DVec2::X);
        for order in &self.orders {
            let (mut radial, mut of_order) = (Radial::new(point), DVec2::ZERO);
            for (step, amplitudes) in order {
                of_order += *amplitudes * radial.next(step);
            }
            sum += of_order.dot(power);
            power = turned(power, point);
        }
        sum
    }
}

/// r^m (cos m t, sin m t) of the next m, as a complex power.
fn turned(power: DVec2, point: DVec2) -> DVec2 {
    DVec2::new(power.x * point.x - power.y * point.y, power.x * point.y + power.y * point.x)
}

/// How one radial polynomial follows from the two before: (`slope` x + `level`) P_(k-1) - `back` P_(k-2), x = 2 r^2 - 1.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RadialStep {
    slope: f64,
    level: f64,
    back: f64,
    /// Makes its mean square over the disc 1.
    scale: f64,
}

/// The steps of one m, by rising n.
fn radial_steps(degree: usize, m: usize) -> impl Iterator<Item = RadialStep> {
    let mf = m as f64;
    (0..=(degree - m) / 2).map(move |k| {
        let kf = k as f64;
        let t = 2.0 * kf + mf;
        let scale = ((t + 1.0) * if m == 0 { 1.0 } else { 2.0 }).sqrt();
        match k {
            0 => RadialStep { slope: 0.0, level: 1.0, back: 0.0, scale },
            1 => RadialStep { slope: 0.5 * (mf + 2.0), level: -0.5 * mf, back: 0.0, scale },
            _ => {
                let under = 2.0 * kf * (kf + mf) * (t - 2.0);
                RadialStep {
                    slope: (t - 1.0) * t * (t - 2.0) / under,
                    level: -(t - 1.0) * mf * mf / under,
                    back: 2.0 * (kf - 1.0) * (kf + mf - 1.0) * t / under,
                    scale,
                }
            }
        }
    })
}

/// The radial polynomials of one m at a point, without r^m and unscaled.
struct Radial {
    x: f64,
    before: f64,
    now: f64,
}

impl Radial {
    fn new(point: DVec2) -> Self {
        Self { x: 2.0 * point.length_squared() - 1.0, before: 0.0, now: 1.0 }
    }

    fn next(&mut self, step: &RadialStep) -> f64 {
        let next = (step.slope * self.x + step.level) * self.now - step.back * self.before;
        (self.before, self.now) = (self.now, next);
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every scaled polynomial at `point`: of each m the cosines and, but for m = 0, the sines.
    fn terms(degree: usize, point: DVec2) -> Vec<f64> {
        let (mut all, mut power) = (Vec::new(), DVec2::X);
        for m in 0..=degree {
            let mut radial = Radial::new(point);
            for step in radial_steps(degree, m) {
                let term = power * (step.scale * radial.next(&step));
                all.extend([term.x, term.y].into_iter().take(if m == 0 { 1 } else { 2 }));
            }
            power = turned(power, point);
        }
        all
    }

    /// The means of products are 1 of equals, 0 of others.
    #[test]
    fn polynomials_are_orthonormal() {
        let degree = 9;
        let count = (degree + 1) * (degree + 2) / 2;
        let mut products = vec![vec![0.0; count]; count];
        for node in nodes(degree) {
            let values = terms(degree, node.at);
            assert_eq!(values.len(), count);
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
