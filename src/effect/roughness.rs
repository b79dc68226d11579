//! Rough surfaces, which scatter.

use crate::num::normal::quantile;
use crate::surface::face::Face;
use glam::DVec2;

/// Surfaces whose slopes differ from place to place, at random, far finer than a pixel's footprint: each ray is refracted
/// by one of them. This is the geometric limit of scatter (Beckmann & Spizzichino, The Scattering of Electromagnetic Waves
/// from Rough Surfaces, 1963, 5.3), for a height of many wavelengths, as grinding leaves it. What a polished surface
/// scatters by diffraction is not in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roughness {
    /// Root mean square of the slopes of front and back along each axis; they are distributed normally.
    pub slope: [f64; 2],
}

impl Roughness {
    /// Whether the surfaces are smooth.
    pub fn is_nothing(&self) -> bool {
        self.slope == [0.0; 2]
    }

    /// How many of the surfaces are rough.
    pub fn rough(&self) -> usize {
        self.slope.iter().filter(|slope| **slope > 0.0).count()
    }

    /// The slopes of the front or the back for a point of the open unit square.
    pub fn slopes(&self, face: Face, unit: DVec2) -> DVec2 {
        let normal = |u: f64| quantile(u.clamp(f64::MIN_POSITIVE, 1.0 - f64::EPSILON));
        self.slope[face as usize] * DVec2::new(normal(unit.x), normal(unit.y))
    }

    /// The steepest slope along an axis of the front or the back among so many draws: points of one even set stay
    /// below it, and of random ones 1 in 64 sets of draws has one beyond.
    pub fn steepest(&self, face: Face, draws: f64) -> f64 {
        -self.slope[face as usize] * quantile(1.0 / (256.0 * draws.max(1.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::effects::Effects;
    use crate::effect::{Points, Quadrature};

    #[test]
    fn slopes_have_their_spread() {
        let rough = Roughness { slope: [0.0, 0.02] };
        let quadrature = Quadrature { points: 4096, ..Quadrature::default() };
        let effects = Effects { roughness: Some(rough), quadrature, ..Effects::default() };
        let slopes: Vec<DVec2> = effects.variants(0).iter().map(|variant| variant.slopes[1]).collect();
        let mean = |f: &dyn Fn(&DVec2) -> f64| slopes.iter().map(f).sum::<f64>() / 4096.0;
        // The outermost of n points stand for a 1/n of the distribution, whose square is 2 log(n) of the variance.
        let bound = 2.0 * libm::log(4096.0) / 4096.0;
        assert!((mean(&|s| s.x * s.x) / 4e-4 - 1.0).abs() < bound && (mean(&|s| s.y * s.y) / 4e-4 - 1.0).abs() < bound);
        assert!((mean(&|s| s.x * s.y) / 4e-4).abs() < bound);
        assert_eq!(rough.slopes(Face::Front, DVec2::new(0.3, 0.9)), DVec2::ZERO);
        assert_eq!(rough.rough(), 1);
    }

    #[test]
    fn points_of_a_set_stay_below_the_steepest_slope() {
        let rough = Roughness { slope: [0.02; 2] };
        for (count, dimensions) in (1..200).chain([1000, 65_536]).flat_map(|n| [2, 4, 6].map(|d| (n, d))) {
            let points = Points::new(&Quadrature { points: count, ..Quadrature::default() }, dimensions, 0, 1);
            let steepest = rough.steepest(Face::Back, count as f64);
            for (k, j) in (0..count).flat_map(|k| (0..dimensions / 2).map(move |j| (k, 2 * j))) {
                let slopes = rough.slopes(Face::Back, DVec2::new(points.at(k, j), points.at(k, j + 1)));
                assert!(slopes.abs().max_element() < steepest, "{count} {dimensions}: {slopes} {steepest}");
            }
        }
    }
}
