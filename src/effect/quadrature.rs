//! Where ray effects take their samples.

use glam::DVec2;

/// How ray effects are sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quadrature {
    /// Points of the pupil.
    pub points: usize,
}

impl Default for Quadrature {
    fn default() -> Self {
        Self { points: 64 }
    }
}

/// The inverse of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Point k of n that fill the unit square evenly: equal steps in the first coordinate, multiples of the golden ratio in
/// the second, whose fractions are the most even of all (Niederreiter, Random Number Generation and Quasi-Monte Carlo
/// Methods, 1992, 3.2; on a disk this is Vogel's sunflower spiral).
pub fn unit_square(k: usize, n: usize) -> DVec2 {
    DVec2::new((k as f64 + 0.5) / n as f64, (GOLDEN * (k as f64 + 0.5)).fract())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every box [0, a) x [0, b) holds its area's share of the points, to the log(n) / n that even sets reach.
    #[test]
    fn points_are_even() {
        for n in [16, 64, 256, 1024] {
            let points: Vec<DVec2> = (0..n).map(|k| unit_square(k, n)).collect();
            let mut worst = 0.0f64;
            for (i, j) in (1..=20).flat_map(|i| (1..=20).map(move |j| (i, j))) {
                let corner = DVec2::new(f64::from(i), f64::from(j)) / 20.0;
                let inside = points.iter().filter(|p| p.cmplt(corner).all()).count();
                worst = worst.max((inside as f64 / n as f64 - corner.x * corner.y).abs());
            }
            // Random points would be off by about 1 / sqrt(n).
            assert!(worst < (1.0 + 0.5 * libm::log(n as f64)) / n as f64, "{n}: {worst}");
        }
    }
}
