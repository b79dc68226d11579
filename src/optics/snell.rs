//! Refraction at a surface, in vector form.

use crate::num::exact::{sum, two_product};
use glam::DVec3;

/// The square of the cosine of refraction, as a share of eta^2 - 1, below which its terms are added with more digits.
pub const CAREFUL_BELOW: f64 = 0.25;

/// A refracted ray, with what its derivatives need.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refracted {
    /// Unit direction behind the surface.
    pub direction: DVec3,
    /// The unit normal, turned against the incoming ray.
    pub normal: DVec3,
    /// Cosine of the angle of incidence, in 0..=1.
    pub cos_in: f64,
    /// Cosine of the angle of refraction, in 0..=1.
    pub cos_out: f64,
    /// The multiple of `normal` in direction = eta * incoming + gamma * normal.
    pub gamma: f64,
}

/// Refracts the unit vector `incoming` at a surface of unit normal `normal` (either orientation), with
/// `eta` = n_in / n_out. `None` beyond the critical angle.
///
/// Vector form of Snell's law (Born & Wolf, Principles of Optics, 3.2.2): t = eta i + gamma n with
/// gamma = eta cos_in - cos_out, here written as (eta^2 - 1)/(eta cos_in + cos_out), which does not cancel when the
/// two media are nearly the same and is exactly 0 when they are.
#[inline(always)]
pub fn refract(incoming: DVec3, normal: DVec3, eta: f64) -> Option<Refracted> {
    let along = normal.dot(incoming);
    let normal = if along > 0.0 { -normal } else { normal };
    let cos_in = along.abs();
    if eta == 1.0 {
        return Some(Refracted { direction: incoming, normal, cos_in, cos_out: cos_in, gamma: 0.0 });
    }
    let slowed = eta * cos_in;
    let excess = (eta - 1.0) * (eta + 1.0);
    let mut square = slowed * slowed - excess;
    // Towards the critical angle the two terms cancel, and the roundings of both grow in what is left.
    if square < CAREFUL_BELOW * excess {
        square = square_of_cos_out(eta, cos_in);
    }
    if square < 0.0 {
        return None;
    }
    let cos_out = square.sqrt();
    let gamma = excess / (slowed + cos_out);
    let direction = incoming * eta + normal * gamma;
    Some(Refracted { direction, normal, cos_in, cos_out, gamma })
}

/// The tilt alpha of a facet, in rad, behind which light at `delta_rad` to the axis goes along it, in glass of
/// `index_ratio` k to its surroundings: Snell's law k sin(alpha) = sin(alpha + delta), solved for alpha. `None` unless
/// k cos(delta) > 1: at 1 the light grazes the facet, and below it would meet it from inside.
pub(crate) fn straightening_facet_rad(index_ratio: f64, delta_rad: f64) -> Option<f64> {
    let (sin, cos) = libm::sincos(delta_rad);
    (index_ratio.is_finite() && index_ratio * cos > 1.0).then(|| libm::atan2(sin, index_ratio - cos))
}

/// 1 - eta^2 (1 - cos_in^2) of the very numbers given, with its sign and its digits, however much cancels: every product
/// is taken with its rounding error, and the terms are added as if with four times the digits.
#[cold]
fn square_of_cos_out(eta: f64, cos_in: f64) -> f64 {
    let (p, p_error) = two_product(eta, cos_in);
    let (a, a_error) = two_product(p, p);
    let (b, b_error) = two_product(eta, eta);
    let (c, c_error) = two_product(2.0 * p, p_error);
    sum([1.0, -b, a, -b_error, a_error, c, c_error, p_error * p_error])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thirty_degrees_into_glass() {
        let i = DVec3::new(0.5, 0.0, 0.75f64.sqrt());
        let r = refract(i, DVec3::Z, 1.0 / 1.5).expect("no total reflection into the denser medium");
        assert!((r.direction.x - 0.5 / 1.5).abs() < 1e-16);
        assert!((r.direction.length() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn either_normal_gives_the_same_ray() {
        let i = DVec3::new(0.3, -0.2, 0.9).normalize();
        let n = DVec3::new(0.1, 0.2, -1.0).normalize();
        let (a, b) = (refract(i, n, 1.3).expect("refracts"), refract(i, -n, 1.3).expect("refracts"));
        assert_eq!(a.direction, b.direction);
    }

    #[test]
    fn beyond_the_critical_angle_there_is_no_ray() {
        let i = DVec3::new(0.9, 0.0, (1.0f64 - 0.81).sqrt());
        assert!(refract(i, DVec3::Z, 1.5).is_none());
    }
}
