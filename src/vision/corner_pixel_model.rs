//! The pixel response at a crossing of two edges: the product of the two edge responses, and a correction.
//!
//! Pixel and blur average over the product of the two patterns at once. Over a pixel at distances d0 and d1 from edges
//! with normals n0 and n1 the mean of sign(d0) sign(d1) is E0 E1 plus a correction, which vanishes for edges along the
//! pixel's sides and is needed for all others: without it a slanted crossing errs by up to 0.03 px.

use super::column::{CHUNK, Column};
use super::corner_model::Model;
use super::edge_spread::{PIXEL_VARIANCE, SHARP_PX};
use super::sharp_crossing::{excess, half_extent};
use crate::num::gauss::Gauss;
use crate::num::simd::{LANES, Lanes};
use glam::DVec2;

/// From this blur on, in px, the square pixel counts as a Gaussian of its variance in the correction.
const SMOOTH_PX: f64 = 0.45;
/// From this blur on, in px, the pixel's own part of the correction is summed over a lattice of NODES x NODES points.
const LATTICE_PX: f64 = 0.2;
const NODES: usize = LANES;
/// Below this correlation two terms of the series are enough: the third is below 0.35^3 / 6 = 0.007 of the contrast.
const SERIES: f64 = 0.35;
/// Nodes and weights of Gauss and Legendre on 0..1.
const LEGENDRE: [(f64, f64); 6] = [
    (0.033_765_242_898_423_99, 0.085_662_246_189_585_18),
    (0.169_395_306_766_867_74, 0.180_380_786_524_069_3),
    (0.380_690_406_958_401_55, 0.233_956_967_286_345_52),
    (0.619_309_593_041_598_5, 0.233_956_967_286_345_52),
    (0.830_604_693_233_132_3, 0.180_380_786_524_069_3),
    (0.966_234_757_101_576, 0.085_662_246_189_585_18),
];
/// Nodes (in standard deviations) and weights of Gauss and Hermite.
const HERMITE: [(f64, f64); 5] = [
    (-2.856_970_013_872_805_6, 0.011_257_411_327_720_69),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_64),
    (0.0, 8.0 / 15.0),
    (1.355_626_179_974_266, 0.222_075_922_005_612_64),
    (2.856_970_013_872_805_6, 0.011_257_411_327_720_69),
];

/// Where so many squares of a blur lie between a pixel and the place where both edges are within it, nothing is left of the pixel's
/// own part: 1e-6 of the contrast.
const NOTHING: f64 = 22.0;

/// Both edges as some pixels see them.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenEdges {
    /// Signed distance of each, in px.
    pub(super) distances: [Column; 2],
    /// x and y of the unit normal, nearly, of each.
    pub(super) normals: [[Column; 2]; 2],
    /// E, its slope and its bend: the pixels' response to each without the other.
    pub(super) edges: [[Column; 3]; 2],
}

/// The mean patterns of some pixels, and their derivatives by the two distances.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patterns {
    pub(super) values: Column,
    pub(super) by_distance: [Column; 2],
}

/// Two edges prepared for many pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct CornerPixelModel {
    /// The blur across each edge, in px.
    sigma: [f64; 2],
    /// Their geometric mean.
    mean_sigma: f64,
    /// What an elongated blur adds to the correlation of the two blurs; 0 of an even one.
    skew: f64,
    pixel: Pixel,
    gauss: Gauss,
}

/// How the part of the correction that the square pixel makes is found.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::large_enum_variant, reason = "one is made for a window of pixels")]
enum Pixel {
    /// Without blur: exactly.
    Sharp,
    /// Under a narrow blur: at the nodes of Gauss and Hermite.
    Nodes,
    /// Under a wider one: on a lattice.
    Lattice(ExcessLattice),
    /// Under a wide blur: as a Gaussian of its variance.
    Smooth,
}

/// The excess of a sharp crossing over the product of its edges, on points of the plane of both distances.
#[derive(Debug, Clone, Copy)]
struct ExcessLattice {
    /// Half the range of each distance where there is an excess.
    reach: [f64; 2],
    /// Excess times the area of a point's cell, by the first distance, then by the second.
    excess: [Lanes; NODES],
}

impl CornerPixelModel {
    /// The crossing of a model's edges.
    pub(super) fn of(model: &Model) -> Self {
        Self::new(model.normals(), model.sigma_px, model.skew)
    }

    /// The crossing of edges with these unit normals under these blurs, in px, with what their correlation is beyond an even blur's.
    fn new(normals: [DVec2; 2], sigma_px: [f64; 2], skew: f64) -> Self {
        let mean_sigma = (sigma_px[0] * sigma_px[1]).sqrt();
        let pixel = match mean_sigma {
            s if s < SHARP_PX => Pixel::Sharp,
            s if s < LATTICE_PX => Pixel::Nodes,
            s if s < SMOOTH_PX => Pixel::Lattice(ExcessLattice::new(normals)),
            _ => Pixel::Smooth,
        };
        Self { sigma: sigma_px, mean_sigma, skew, pixel, gauss: Gauss::new() }
    }

    /// The means of the product of both edges, for the first `count` pixels.
    #[inline(always)]
    pub(super) fn patterns(&self, seen: &SeenEdges, count: usize) -> Patterns {
        // Where one edge is far, the response is that of the other, up to its sign.
        let mut patterns = Patterns { values: [0.0; CHUNK], by_distance: [[0.0; CHUNK]; 2] };
        let [[e0, slope0, _], [e1, slope1, _]] = &seen.edges;
        for i in 0..CHUNK {
            patterns.values[i] = e0[i] * e1[i];
            patterns.by_distance[0][i] = slope0[i] * e1[i];
            patterns.by_distance[1][i] = e0[i] * slope1[i];
        }

        // Add the blur's part of the correction, and that of the square pixel.
        if !matches!(self.pixel, Pixel::Sharp) {
            for first in (0..count).step_by(LANES) {
                self.add_blur(seen, &mut patterns, first);
            }
        }
        if !matches!(self.pixel, Pixel::Smooth) {
            self.add_pixel(seen, &mut patterns, count);
        }
        patterns
    }

    /// Adds the square pixel's part of the correction where both edges are near.
    #[inline(always)]
    fn add_pixel(&self, seen: &SeenEdges, patterns: &mut Patterns, count: usize) {
        let sigma = self.mean_sigma;
        let inverse = 1.0 / (sigma * sigma).max(1e-12);
        for i in 0..count {
            let distances = [seen.distances[0][i], seen.distances[1][i]];
            let normals = [0, 1].map(|k| DVec2::new(seen.normals[k][0][i], seen.normals[k][1][i]));
            let cosine = normals[0].dot(normals[1]);

            // Both distances go together by the cosine.
            let away = |k: usize| (distances[k].abs() - half_extent(normals[k])).max(0.0);
            let (a, b) = (away(0), away(1));
            if (a * a + b * b) * inverse > NOTHING * (1.0 + cosine.abs()) {
                continue;
            }
            patterns.values[i] += match &self.pixel {
                Pixel::Sharp => excess(normals, distances),
                Pixel::Nodes => {
                    let moved = |at: DVec2| [0, 1].map(|k| distances[k] + normals[k].dot(at));
                    let nodes =
                        HERMITE.iter().flat_map(|&(x, u)| HERMITE.iter().map(move |&(y, v)| (DVec2::new(x, y), u * v)));
                    nodes.map(|(at, weight)| weight * excess(normals, moved(at * sigma))).sum()
                }
                Pixel::Lattice(lattice) => lattice.blurred(distances, cosine, sigma),
                Pixel::Smooth => 0.0,
            };
        }
    }

    /// Adds the blur's part for the [`LANES`] pixels from `first` on: a bivariate normal integral of the correlation of the two
    /// distances. A wide blur has the square pixel's part in it, as a Gaussian of its variance.
    #[inline(always)]
    fn add_blur(&self, seen: &SeenEdges, patterns: &mut Patterns, first: usize) {
        // Find the covariance of the two distances, and the correlation.
        let of = Lanes::splat;
        let load = |column: &Column| Lanes::load(&column[first..]);
        let [[x0, y0], [x1, y1]] = &seen.normals;
        let cosine = load(x0) * load(x1) + load(y0) * load(y1);
        let square = self.mean_sigma * self.mean_sigma;
        let variance = if matches!(self.pixel, Pixel::Smooth) { PIXEL_VARIANCE } else { 0.0 };
        let covariance = (cosine + of(self.skew)) * of(square) + cosine * of(variance);
        let [v0, v1] = self.sigma.map(|s| s * s + PIXEL_VARIANCE);
        let correlation = covariance * of(1.0 / (v0 * v1).sqrt());

        // Take Mehler's series in the covariance, to second order, where that is enough.
        let [[e0, slope0, bend0], [e1, slope1, bend1]] = &seen.edges;
        let ([s0, b0], [s1, b1]) = ([load(slope0), load(bend0)], [load(slope1), load(bend1)]);
        let few = correlation.abs().lt(of(SERIES));
        let second = of(0.5) * covariance * covariance * b0 * b1;
        let mut added = covariance * s0 * s1 + second;
        let mut by = [covariance * b0 * s1, covariance * s0 * b1];
        if !few.all() {
            let (h, k) =
                (load(&seen.distances[0]) * of(1.0 / v0.sqrt()), load(&seen.distances[1]) * of(1.0 / v1.sqrt()));
            let [value, odd0, odd1] = self.integral([h, k], correlation.max(of(-0.999)).min(of(0.999)));
            // Nothing where one edge is far.
            let far = (of(0.0).lt(s0.abs())) & (of(0.0).lt(s1.abs()));
            let value = far.select(value, of(0.0));
            let by_integral =
                [far.select(s0 * (odd0 - load(e1)), of(0.0)), far.select(s1 * (odd1 - load(e0)), of(0.0))];
            added = few.select(added, value);
            by = [few.select(by[0], by_integral[0]), few.select(by[1], by_integral[1])];
        }
        for i in 0..LANES {
            patterns.values[first + i] += added.0[i];
            patterns.by_distance[0][first + i] += by[0].0[i];
            patterns.by_distance[1][first + i] += by[1].0[i];
        }
    }

    /// The bivariate normal integral of two deviates over their product: its derivative by the correlation is the density (Plackett),
    /// here with the correlation written as a sine. And the odd responses that the slopes by the two distances go with.
    #[inline(always)]
    fn integral(&self, [h, k]: [Lanes; 2], correlation: Lanes) -> [Lanes; 3] {
        let of = Lanes::splat;
        let end = Lanes::of(|i| libm::asin(correlation.0[i]));
        let (squares, product) = (h * h + k * k, of(2.0) * h * k);
        let mut mean = of(0.0);
        for (node, weight) in LEGENDRE {
            let sin = (end * of(node)).sin();
            let square = of(1.0) - sin * sin;
            mean += of(weight) * ((product * sin - squares) / (square + square)).exp();
        }
        let root = (of(1.0) - correlation * correlation).sqrt();
        let odd = [(k - correlation * h) / root, (h - correlation * k) / root];
        let [first, second] = [self.gauss.at_lanes(odd[0])[0], self.gauss.at_lanes(odd[1])[0]];
        let twice = |share: Lanes| of(2.0) * share - of(1.0);
        [of(std::f64::consts::FRAC_2_PI) * end * mean, twice(first), twice(second)]
    }
}

impl ExcessLattice {
    fn new(normals: [DVec2; 2]) -> Self {
        let reach = normals.map(|n| 0.5 * (n.x.abs() + n.y.abs()));
        let cell = 4.0 * reach[0] * reach[1] / (NODES * NODES) as f64;
        let mut excess = [Lanes::splat(0.0); NODES];
        // With both distances turned round it is the same.
        for i in 0..NODES / 2 {
            for j in 0..NODES {
                let at = [Self::place(reach[0], i), Self::place(reach[1], j)];
                let here = cell * crate::vision::sharp_crossing::excess(normals, at);
                (excess[i].0[j], excess[NODES - 1 - i].0[NODES - 1 - j]) = (here, here);
            }
        }
        Self { reach, excess }
    }

    #[inline(always)]
    fn place(reach: f64, i: usize) -> f64 {
        reach * ((2 * i + 1) as f64 / NODES as f64 - 1.0)
    }
}

impl ExcessLattice {
    /// The excess under a Gaussian of the plane, whose parts along two normals have a given cosine as correlation.
    #[inline(always)]
    fn blurred(&self, distances: [f64; 2], cosine: f64, sigma: f64) -> f64 {
        // Sum the excess under the Gaussian exp(-rate (a^2 - 2 c a b + b^2)), which is exp(-rate free a^2) times
        // exp(-rate (b - c a)^2), which falls off about a moved centre.
        let free = (1.0 - cosine * cosine).max(1e-3);
        let rate = 0.5 / (sigma * sigma * free);
        let mut offsets = [Lanes::splat(0.0); 2];
        for k in 0..2 {
            for i in 0..NODES {
                offsets[k].0[i] = (distances[k] - Self::place(self.reach[k], i)).clamp(-9.0, 9.0);
            }
        }
        let [a, b] = offsets;
        let fall = (a * a * Lanes::splat(-rate * free)).exp();
        let mut sum = Lanes::splat(0.0);
        for i in 0..NODES {
            let moved = b - Lanes::splat(cosine * a.0[i]);
            sum += self.excess[i] * Lanes::splat(fall.0[i]) * (moved * moved * Lanes::splat(-rate)).exp();
        }
        sum.sum() * rate * free.sqrt() * std::f64::consts::FRAC_1_PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::profile::Profile;

    fn unit(degrees: f64) -> DVec2 {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        DVec2::new(cos, sin)
    }

    /// The mean over pixel and blur of the signs' product, by brute force: uniform times normal deviates on a lattice.
    fn brute(angles: [f64; 2], distances: [f64; 2], sigma: f64) -> f64 {
        let normals = angles.map(unit);
        let side = 1200;
        // A pixel under a Gaussian, point by point: density (erf difference) on a lattice.
        let reach = 0.5 + 5.0 * sigma;
        let density = |x: f64| {
            if sigma == 0.0 {
                return f64::from(u8::from(x.abs() < 0.5));
            }
            let up = |t: f64| 0.5 * libm::erf(t / sigma * std::f64::consts::FRAC_1_SQRT_2);
            up(x + 0.5) - up(x - 0.5)
        };
        let step = 2.0 * reach / f64::from(side);
        let at = |i: i32| -reach + (f64::from(i) + 0.5) * step;
        let weights: Vec<f64> = (0..side).map(|i| density(at(i)) * step).collect();
        let mut sum = 0.0;
        for j in 0..side {
            for i in 0..side {
                let r = DVec2::new(at(i), at(j));
                let d = [0, 1].map(|k| normals[k].dot(r) + distances[k]);
                sum += weights[i as usize] * weights[j as usize] * d[0].signum() * d[1].signum();
            }
        }
        sum
    }

    fn modelled(angles: [f64; 2], distances: [f64; 2], sigma: [f64; 2]) -> f64 {
        // One pixel in each place.
        let edges = [0, 1].map(|k| Profile::new(unit(angles[k]), sigma[k]).at_all(&[distances[k]; CHUNK]));
        let normals = angles.map(|angle| unit(angle).to_array().map(|v| [v; CHUNK]));
        let seen = SeenEdges { distances: distances.map(|d| [d; CHUNK]), normals, edges };
        CornerPixelModel::new(angles.map(unit), sigma, 0.0).patterns(&seen, 1).values[0]
    }

    #[test]
    fn sharp_crossings_are_exact() {
        for (angles, distances) in [
            ([0.0, 90.0], [0.1, -0.3]),
            ([20.0, 110.0], [0.1, 0.0]),
            ([20.0, 70.0], [0.3, -0.2]),
            ([-130.0, 70.0], [0.0, 0.4]),
        ] {
            // A lattice of 1200 points a side resolves an area to a few 1e-4.
            let error = modelled(angles, distances, [0.0; 2]) - brute(angles, distances, 0.0);
            assert!(error.abs() < 2e-3, "{angles:?} {distances:?} {error}");
        }
    }

    #[test]
    fn blurred_crossings_are_right_to_their_stated_error() {
        for sigma in [0.1, 0.19, 0.2, 0.21, 0.3, 0.4, 0.44, 0.46, 0.5, 0.7, 1.0, 2.0] {
            // Edges that cross at 90, 85, 50 and 35 deg. What is wrong is alike on opposite sides of a crossing, and so
            // moves no corner.
            for (angles, most) in
                [([10.0, 100.0], 5e-3), ([30.0, 115.0], 5e-3), ([20.0, 70.0], 0.015), ([-130.0, 85.0], 0.025)]
            {
                for distances in [[0.0, 0.0], [0.2, -0.3], [0.5, 0.6]] {
                    let exact = brute(angles, distances, sigma);
                    let error = modelled(angles, distances, [sigma; 2]) - exact;
                    assert!(error.abs() < most, "{sigma} {angles:?} {distances:?} {error}");
                    // Estimated blurs differ a little, and may lie on both sides of a change of method.
                    let uneven = modelled(angles, distances, [1.0005 * sigma, sigma / 1.0005]) - exact;
                    assert!(uneven.abs() < most, "{sigma} {angles:?} {distances:?} {uneven}");
                }
            }
        }
    }
}
