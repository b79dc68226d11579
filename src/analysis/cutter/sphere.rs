//! The sphere of least squares of some places, by their distances from it.

use crate::num::lsq;
use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector};

/// The search ends where a step would change the heights by no more than this, root mean square, in mm: some roundings of 100 mm.
const TOLERANCE_MM: f64 = 1e-13;

/// A sphere by a point of it, the unit normal there and its curvature towards the normal: 0 is a plane, so that no radius grows
/// beyond all numbers.
#[derive(Debug, Clone, Copy)]
struct Ball {
    vertex: DVec3,
    normal: DVec3,
    curvature: f64,
}

impl Ball {
    /// How far `p` stands above it, along its radius towards the normal, and 1 - that over the radius.
    ///
    /// From |p - c| = 1/k - D with the centre c = vertex + normal/k: D = (2 h - k s^2)/(1 + R), R = sqrt(1 - 2 k h + k^2 s^2), where h is the
    /// height of p above the vertex' plane and s its distance from the vertex.
    fn above(&self, p: DVec3) -> [f64; 2] {
        let from = p - self.vertex;
        let (h, s2, k) = (from.dot(self.normal), from.length_squared(), self.curvature);
        let root = (1.0 - 2.0 * k * h + k * k * s2).max(0.0).sqrt();
        [(2.0 * h - k * s2) / (1.0 + root), root]
    }
}

/// The heights of `places` above the sphere whose distances from them have the least squares, along its radius towards +z, in mm. The
/// search begins from the plane z = `slope` . (x, y) through their middle.
///
/// # Errors
/// When the places do not determine a sphere.
pub(super) fn heights_above(places: &[DVec3], slope: DVec2) -> Result<Vec<f64>, lsq::Failure> {
    let vertex = places.iter().sum::<DVec3>() / places.len() as f64;
    let start = Ball { vertex, normal: (-slope).extend(1.0).normalize(), curvature: 0.0 };
    let evaluate = |ball: &Ball| {
        // How a height changes with the vertex along the normal, with two turns of the normal, and with the curvature.
        let (e, f) = ball.normal.any_orthonormal_pair();
        let row = |p: &DVec3| {
            let ([d, root], from) = (ball.above(*p), *p - ball.vertex);
            let along = -1.0 + ball.curvature * from.dot(ball.normal);
            [along, from.dot(e), from.dot(f), 0.5 * (d * d - from.length_squared())].map(|change| change / root)
        };
        let rows: Vec<[f64; 4]> = places.iter().map(row).collect();
        let heights = DVector::from_fn(places.len(), |i, _| ball.above(places[i])[0]);
        Some((heights, DMatrix::from_fn(places.len(), 4, |i, k| rows[i][k])))
    };
    let step = |ball: &Ball, step: &DVector<f64>| {
        let (e, f) = ball.normal.any_orthonormal_pair();
        Ball {
            vertex: ball.vertex + ball.normal * step[0],
            normal: (ball.normal + e * step[1] + f * step[2]).normalize(),
            curvature: ball.curvature + step[3],
        }
    };
    let settings = lsq::SearchSettings { tolerance: TOLERANCE_MM, ..lsq::SearchSettings::default() };
    let found = lsq::levenberg_marquardt(start, settings, evaluate, step)?;
    Ok(found.residuals.iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places over x, y in -6 .. 6 mm.
    fn places(height: impl Fn(DVec2) -> f64) -> Vec<DVec3> {
        let at = |k: usize| DVec2::new((k % 13) as f64 - 6.0, (k / 13) as f64 - 6.0);
        (0..169).map(at).map(|p| p.extend(80.0 + height(p))).collect()
    }

    fn largest(heights: &[f64]) -> f64 {
        heights.iter().fold(0.0, |most: f64, h| most.max(h.abs()))
    }

    #[test]
    fn spheres_and_planes_are_found_again() {
        for radius in [9.0, 50.0, 1e5] {
            for sign in [1.0, -1.0] {
                // r - sqrt(r^2 - s) without its cancellation.
                let root = |s: f64| (radius * radius - s).sqrt();
                let ball = |p: DVec2| sign * p.length_squared() / (radius + root(p.length_squared()));
                let above = heights_above(&places(ball), DVec2::ZERO).expect("a sphere");
                // Some roundings of 80 mm.
                assert!(largest(&above) < 1e-12, "{radius} {sign}: {}", largest(&above));
            }
        }
        let above = heights_above(&places(|p| 0.3 * p.x - 0.1 * p.y), DVec2::new(0.3, -0.1)).expect("a plane");
        assert!(largest(&above) < 1e-12);
    }

    #[test]
    fn what_stands_towards_z_is_above() {
        let bump = |p: DVec2| if p == DVec2::ZERO { 1e-3 } else { 0.0 };
        for sign in [1.0, -1.0] {
            let ball = |p: DVec2| sign * (50.0 - (2500.0 - p.length_squared()).sqrt()) + bump(p);
            let above = heights_above(&places(ball), DVec2::ZERO).expect("a sphere");
            // One of 169 places draws the four numbers of the sphere a little its way.
            assert!(above[84] > 0.97e-3 && above[84] < 1e-3, "{}", above[84]);
        }
    }

    /// Of a saddle z = (x^2 - y^2)/200 no sphere is nearer than the plane, which is its mean: an algebraic fit of the centre would take
    /// a small ball.
    #[test]
    fn a_saddle_is_nearest_to_a_plane() {
        let above = heights_above(&places(|p| (p.x * p.x - p.y * p.y) / 200.0), DVec2::ZERO).expect("a sphere");
        let square = above.iter().map(|h| h * h).sum::<f64>();
        let plane =
            places(|p| (p.x * p.x - p.y * p.y) / 200.0).iter().map(|p| (p.z - 80.0) * (p.z - 80.0)).sum::<f64>();
        assert!(square <= plane && square > 0.9 * plane, "{square} {plane}");
    }
}
