//! The sampling of ray effects: quadrature rules and random sets.

use crate::num::deviates::Stream;
use glam::DVec2;
use std::f64::consts::TAU;

/// How ray effects are sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadrature {
    /// Points of one set, at least: of the pupil, and of the slopes of rough surfaces.
    pub points: usize,
    /// Sets, each shifted at random; a single one is not. Their spread tells the error of their mean.
    pub replicates: usize,
    /// No further set is taken once the standard error of the mean is all but surely below this, of full scale 1, in the worst block of
    /// the picture.
    pub noise: Option<f64>,
    /// Of the random shifts.
    pub seed: u64,
    /// Whether each point of the pupil stands for the part of it around it: points are spaced so that their shadows are even in every
    /// direction, and their mean is spread by what a part of the pupil blurs. Of a single set, of which nothing else is drawn.
    pub fill: bool,
}

impl Default for Quadrature {
    fn default() -> Self {
        Self { points: 64, replicates: 1, noise: None, seed: 1, fill: false }
    }
}

/// The purpose of the random shifts among the random numbers of a scene.
const PURPOSE: u32 = 0x5AF7;
/// Sets before a spread tells anything.
pub(crate) const LEAST_REPLICATES: usize = 4;

/// Points that fill the unit cube of some dimensions evenly.
///
/// The first coordinate runs in equal steps, the second in multiples of the inverse of the golden ratio, whatever others
/// there are: an effect that is left out must not move the points of another. The others are multiples of the inverse
/// powers of the root of x^(d + 1) = x + 1 (Roberts, "The unreasonable effectiveness of quasirandom sequences",
/// 2018; Niederreiter, Random Number Generation and Quasi-Monte Carlo Methods, 1992, 3.2). Two of them on a disk are
/// Vogel's sunflower spiral. Random shifts modulo 1 keep the set even and make each of its points uniform (Cranley &
/// Patterson, SIAM J. Numer. Anal. 13, 1976, 904), so that the mean over sets is without bias and their spread tells its
/// error.
///
/// What is drawn from them may be the same when it is turned about the axis by a part of a full turn. Then the points fill
/// that part only, and each stands for its copies in all parts (`turned`), which together have their middle on the axis:
/// a picture of few points would be shifted otherwise. A copy of a point is as uniform as the point.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    count: usize,
    steps: Vec<f64>,
    shifts: Vec<f64>,
}

impl Points {
    /// Set number `replicate` in `dimensions`, at least 1, whose points have `copies` each.
    pub fn new(quadrature: &Quadrature, dimensions: usize, replicate: usize, copies: usize) -> Self {
        let count = quadrature.points.div_ceil(copies);
        let multiples = |d: usize| {
            let root = root(d);
            std::iter::successors(Some(1.0 / root), move |power| Some(power / root))
        };
        let first = std::iter::once(1.0 / count as f64).chain(multiples(1).take(1));
        let steps: Vec<f64> = first.chain(multiples(dimensions.saturating_sub(1)).skip(1)).take(dimensions).collect();
        let mut random = Stream::new(quadrature.seed, PURPOSE, 0, replicate as u32);
        let shifts = steps.iter().enumerate().map(|(k, step)| match (quadrature.replicates, k) {
            (1, _) => 0.5 * step,
            (_, 0) => random.uniform() * step,
            _ => random.uniform(),
        });
        let shifts = shifts.collect();
        Self { count, steps, shifts }
    }

    /// How many, without their copies.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Coordinate j of point k, in 0..1.
    pub fn at(&self, k: usize, j: usize) -> f64 {
        (self.steps[j] * k as f64 + self.shifts[j]).fract()
    }
}

/// `v`, turned by `part` of `parts` of a full turn.
pub(super) fn turned(v: DVec2, part: usize, parts: usize) -> DVec2 {
    match part {
        0 => v,
        _ if 2 * part == parts => -v,
        _ => {
            let (sin, cos) = libm::sincos(TAU * part as f64 / parts as f64);
            DVec2::new(cos, sin).rotate(v)
        }
    }
}

/// The root above 1 of x^(d + 1) = x + 1, by its fixed point x = (1 + x)^(1/(d + 1)), which contracts.
fn root(d: usize) -> f64 {
    (0..64).fold(1.5, |x, _| libm::pow(1.0 + x, 1.0 / (d as f64 + 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::Lens;
    use crate::effect::effects::Effects;
    use crate::effect::thin_lens::{Aperture, ThinLens};
    use crate::effect::variant::Variant;
    use crate::effect::{Roughness, Telecentric};

    fn largest_gap(points: &Points, i: usize, j: usize) -> f64 {
        let n = points.count();
        let mut worst = 0.0f64;
        for (a, b) in (1..=20).flat_map(|a| (1..=20).map(move |b| (a, b))) {
            let (a, b) = (f64::from(a) / 20.0, f64::from(b) / 20.0);
            let inside = (0..n).filter(|&k| points.at(k, i) < a && points.at(k, j) < b).count();
            worst = worst.max((inside as f64 / n as f64 - a * b).abs());
        }
        worst
    }

    /// Every box [0, a) x [0, b) of the first two coordinates holds its area's share of the points, to the log(n) / n that
    /// even sets reach; and so does, to a few times that, every pair of the six of a lens with two rough surfaces.
    #[test]
    fn points_are_even() {
        for n in [16, 64, 256, 1024] {
            for replicates in [1, 8] {
                let quadrature = Quadrature { points: n, replicates, ..Quadrature::default() };
                let even = (1.0 + 0.5 * libm::log(n as f64)) / n as f64;
                // Random points would be off by about 1 / sqrt(n).
                let two = Points::new(&quadrature, 2, 3, 1);
                let found = largest_gap(&two, 0, 1);
                assert!(found < 2.0 * even, "{n} {replicates}: {found}");
                let six = Points::new(&quadrature, 6, 3, 1);
                for (i, j) in (0..6).flat_map(|j| (0..j).map(move |i| (i, j))) {
                    let found = largest_gap(&six, i, j);
                    assert!(found < (8.0 * even).min(2.0 / (n as f64).sqrt()), "{n} {replicates} {i} {j}: {found}");
                }
            }
        }
    }

    #[test]
    fn sets_differ_by_seed_and_number_and_are_the_same_again() {
        let of = |seed, replicate| {
            Points::new(&Quadrature { replicates: 4, seed, ..Quadrature::default() }, 2, replicate, 1)
        };
        assert_eq!(of(1, 2), of(1, 2));
        assert!(of(1, 2) != of(1, 3) && of(1, 2) != of(2, 2));
    }

    /// Every set, regular or random, has its middle on the axis, whatever the aperture: or edges out of focus would move.
    #[test]
    fn every_set_is_centred() {
        let circle = Aperture::Circle;
        let blades = |blades| Aperture::Polygon { blades, rotation_rad: 0.4 };
        let lens = |aperture| Lens::Thin(ThinLens { focus_mm: 900.0, focal_mm: 35.0, radius_mm: 2.0, aperture });
        let lenses = [Lens::Pinhole, lens(circle)].into_iter().chain((3..=15).map(|n| lens(blades(n))));
        let cone = Lens::Telecentric(Telecentric { magnification: 0.5, na: 0.1, focus_mm: 300.0 });
        for lens in lenses.chain([cone]) {
            for slope in [[0.0, 0.0], [0.0, 0.03], [0.02, 0.01]] {
                for (points, replicates, set) in [(1, 1, 0), (16, 1, 0), (64, 1, 0), (33, 8, 3), (64, 8, 7)] {
                    let quadrature = Quadrature { points, replicates, ..Quadrature::default() };
                    let roughness = Some(Roughness { slope });
                    let effects = Effects { lens, roughness, quadrature, ..Effects::default() };
                    let variants: Vec<Variant> = effects.variants(set).iter().collect();
                    let sum = |of: &dyn Fn(&Variant) -> DVec2| variants.iter().map(of).sum::<DVec2>().length();
                    // Each of the terms, of at most 2 mm, is rounded by some units of its last place, and so is each sum.
                    let bound = 8.0 * f64::EPSILON * (variants.len() * variants.len()) as f64;
                    assert!(sum(&|v| v.pupil) <= bound, "{effects:?}");
                    assert!(sum(&|v| v.slopes[0]) <= bound && sum(&|v| v.slopes[1]) <= bound, "{effects:?}");
                }
            }
        }
    }
}
