//! The pixel response at a crossing of two edges, of a picture that may have moved while it was taken.
//!
//! On its way w both distances go together, by t n0.w and t n1.w for t in -1..1, so that no correlation of two Gaussians tells what
//! motion makes of a crossing. With P the response at rest (`corner_pixel_model`) the product of the two edges' responses under motion
//! lacks
//!
//! ```text
//! mean of P(d0(t), d1(t)) - mean of E0(d0(t)) mean of E1(d1(t)),   d_k(t) = d_k + t n_k.w + kappa_k/2 (t^2 - 1/3) (t_k.w)^2
//! ```
//!
//! with means over the way by the rule of Gauss and Legendre.

use super::column::{CHUNK, Column};
use super::corner_model::Model;
use super::corner_pixel_model::{CornerPixelModel, Patterns, SeenEdges};
use super::edge_spread::PIXEL_VARIANCE;
use super::profile::Profile;
use crate::num::quadrature::gauss_legendre;
use glam::DVec2;

/// Nodes lie no farther apart, in the middle of the way, than this many standard deviations of blur and pixel: the rule's error falls
/// with exp(-2 pi^2 / this^2) there, to 3e-6.
const NODE_SIGMAS: f64 = 1.25;
/// So many nodes at least.
const LEAST_NODES: usize = 4;

/// Two edges prepared for many pixels.
#[derive(Debug, Clone)]
pub(super) struct CrossingResponse {
    still: CornerPixelModel,
    way: Option<Motion>,
}

/// What motion needs besides.
#[derive(Debug, Clone)]
struct Motion {
    half_px: DVec2,
    /// t and weight of each node.
    nodes: Vec<[f64; 2]>,
    /// The responses to each edge at rest.
    profiles: [Profile; 2],
    /// kappa_k (t_k.w)^2 / 2, in px.
    bends_px: [f64; 2],
}

impl CrossingResponse {
    /// The crossing of a model's edges.
    pub(super) fn of(model: &Model) -> Self {
        let way = (model.half_way_px != DVec2::ZERO).then(|| Motion::of(model));
        Self { still: CornerPixelModel::of(model), way }
    }

    /// The means of the product of both edges, for the first `count` pixels.
    #[inline(always)]
    pub(super) fn patterns(&self, seen: &SeenEdges, count: usize) -> Patterns {
        match &self.way {
            None => self.still.patterns(seen, count),
            Some(way) => way.patterns(&self.still, seen, count),
        }
    }
}

impl Motion {
    fn of(model: &Model) -> Self {
        let normals = model.normals();
        let half_px = model.half_way_px;
        let narrowest = model.sigma_px[0].min(model.sigma_px[1]);
        let apart = NODE_SIGMAS * (narrowest * narrowest + PIXEL_VARIANCE).sqrt();
        let count = LEAST_NODES.max((std::f64::consts::PI * half_px.length() / apart).ceil() as usize);
        let along = [0, 1].map(|k| normals[k].perp().dot(half_px));
        Self {
            half_px,
            nodes: gauss_legendre(count).into_iter().map(|[at, weight]| [2.0 * at - 1.0, weight]).collect(),
            profiles: [0, 1].map(|k| Profile::new(normals[k], model.sigma_px[k])),
            bends_px: [0, 1].map(|k| 0.5 * model.curvature[k] * along[k] * along[k]),
        }
    }

    #[inline(always)]
    fn patterns(&self, still: &CornerPixelModel, seen: &SeenEdges, count: usize) -> Patterns {
        // Sum up the response at rest, and both edges alone, over the way.
        let mut sum = Patterns { values: [0.0; CHUNK], by_distance: [[0.0; CHUNK]; 2] };
        let mut alone = [[[0.0; CHUNK]; 2]; 2];
        for &[at, weight] in &self.nodes {
            let moved = self.moved(seen, at);
            let here = still.patterns(&moved, count);
            add(&mut sum.values, weight, &here.values);
            for (k, [value, slope]) in alone.iter_mut().enumerate() {
                add(&mut sum.by_distance[k], weight, &here.by_distance[k]);
                add(value, weight, &moved.edges[k][0]);
                add(slope, weight, &moved.edges[k][1]);
            }
        }

        // Add what the product of both lacks.
        let [[e0, slope0, _], [e1, slope1, _]] = &seen.edges;
        let [[m0, rise0], [m1, rise1]] = &alone;
        for i in 0..CHUNK {
            sum.values[i] += e0[i] * e1[i] - m0[i] * m1[i];
            sum.by_distance[0][i] += slope0[i] * e1[i] - rise0[i] * m1[i];
            sum.by_distance[1][i] += e0[i] * slope1[i] - m0[i] * rise1[i];
        }
        sum
    }

    /// Both edges at rest from a place on the way.
    #[inline(always)]
    fn moved(&self, seen: &SeenEdges, at: f64) -> SeenEdges {
        let mut moved = *seen;
        for k in 0..2 {
            let [x, y] = &seen.normals[k];
            let bend = self.bends_px[k] * (at * at - 1.0 / 3.0);
            for i in 0..CHUNK {
                moved.distances[k][i] += at * (x[i] * self.half_px.x + y[i] * self.half_px.y) + bend;
            }
            moved.edges[k] = self.profiles[k].at_all(&moved.distances[k]);
        }
        moved
    }
}

/// Adds `weight` times a column to a sum.
#[inline(always)]
fn add(sum: &mut Column, weight: f64, by: &Column) {
    for i in 0..CHUNK {
        sum[i] += weight * by[i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::blur_shape::PictureBlur;
    use crate::vision::edge_spread::EdgeShape;

    fn unit(degrees: f64) -> DVec2 {
        DVec2::from_angle(degrees.to_radians())
    }

    /// The mean of the signs' product over pixel, blur and way, point by point.
    fn brute(normals: [DVec2; 2], distances: [f64; 2], sigma: f64, half_px: DVec2) -> f64 {
        // The place in a pixel and on the way, and the blur's deviate, on lattices.
        let middle = |k: i32, count: i32| (f64::from(k) + 0.5) / f64::from(count) - 0.5;
        let (parts, steps, reach) = (16, 48, 6);
        let weight = |i: i32| libm::exp(-0.5 * f64::from(i * i) / 4.0);
        let (mut sum, mut whole) = (0.0, 0.0);
        for k in 0..parts * parts * steps {
            let pixel = DVec2::new(middle(k % parts, parts), middle(k / parts % parts, parts));
            let at = pixel + 2.0 * middle(k / (parts * parts), steps) * half_px;
            for (i, j) in (-reach..=reach).flat_map(|i| (-reach..=reach).map(move |j| (i, j))) {
                let r = at + DVec2::new(f64::from(i), f64::from(j)) * (0.5 * sigma);
                let d = [0, 1].map(|k| normals[k].dot(r) + distances[k]);
                sum += weight(i) * weight(j) * d[0].signum() * d[1].signum();
                whole += weight(i) * weight(j);
            }
        }
        sum / whole
    }

    #[test]
    fn a_crossing_that_moved_is_the_mean_over_its_way() {
        for (degrees, sigma, half_px, distances) in [
            ([10.0, 95.0], 0.3, DVec2::new(2.0, 1.5), [0.4, -0.3]),
            ([10.0, 95.0], 0.3, DVec2::new(-1.0, 1.0), [0.9, 0.7]),
            ([-20.0, 50.0], 0.6, DVec2::new(0.0, 3.0), [0.2, 1.1]),
        ] {
            let normals = degrees.map(unit);
            let shapes = PictureBlur::moved(sigma, half_px, normals).shapes;
            let model = Model {
                corner: DVec2::ZERO,
                normal_rad: degrees.map(f64::to_radians),
                curvature: [0.0; 2],
                sigma_px: [sigma; 2],
                skew: 0.0,
                shapes,
                half_way_px: half_px,
                leans_px: [0.0; 2],
                lean_rates: [0.0; 2],
                light: [0.0; 6],
                light_is_blurred: true,
            };
            let profile = |k: usize| Profile::shaped(EdgeShape::moved(normals[k], sigma, half_px), &shapes[k]);
            let seen = |distances: [f64; 2]| SeenEdges {
                distances: distances.map(|d| [d; CHUNK]),
                normals: normals.map(|n| n.to_array().map(|v| [v; CHUNK])),
                edges: [0, 1].map(|k| profile(k).at_all(&[distances[k]; CHUNK])),
            };
            let crossing = CrossingResponse::of(&model);
            let found = crossing.patterns(&seen(distances), CHUNK);
            let expected = brute(normals, distances, sigma, half_px);
            // The response at rest is within 0.002 (`corner_pixel_model`); the product of both edges is off by 0.04 and more here.
            assert!((found.values[0] - expected).abs() < 2.5e-3, "{degrees:?}: {} for {expected}", found.values[0]);
            let [e0, e1] = [0, 1].map(|k| profile(k).at_all(&[distances[k]; 1])[0][0]);
            assert!((e0 * e1 - expected).abs() > 0.04, "{degrees:?}: {} {expected}", e0 * e1);

            // Its derivatives are those of its values, to the order in which those at rest are.
            for k in 0..2 {
                let beside = |h: f64| {
                    let mut at = distances;
                    at[k] += h;
                    crossing.patterns(&seen(at), CHUNK).values[0]
                };
                let slope = (beside(1e-3) - beside(-1e-3)) / 2e-3;
                let told = found.by_distance[k][0];
                assert!((told - slope).abs() < 0.05, "{degrees:?} {k}: {told} for {slope}");
            }
        }
    }
}
