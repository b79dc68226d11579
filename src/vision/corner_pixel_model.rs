//! The pixel response at a crossing of two edges: the product of the two edge responses, and a correction.
//!
//! Pixel and blur average over the product of the two patterns at once. Over a pixel at distances d0 and d1 from edges
//! with normals n0 and n1 the mean of sign(d0) sign(d1) is E0 E1 plus a correction, which vanishes for edges along the
//! pixel's sides and is needed for all others: without it a slanted crossing errs by up to 0.03 px.

use super::edge_spread::{Edge, SHARP_PX};
use super::profile::Profile;
use crate::num::gauss::Gauss;
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use glam::DVec2;

/// From this blur on, in px, the square pixel counts as a Gaussian of its variance in the correction.
const SMOOTH_PX: f64 = 0.45;
/// From this blur on, in px, the pixel's own part of the correction is summed over a lattice of NODES x NODES points.
const LATTICE_PX: f64 = 0.2;
const NODES: usize = LANES;
/// Below this correlation two terms of the series are enough: the third is below 0.35^3 / 6 = 0.007 of the contrast.
const SERIES: f64 = 0.35;
/// The variance of a unit pixel in any direction, in px^2.
const PIXEL_VARIANCE: f64 = 1.0 / 12.0;
/// Nodes and weights of Gauss and Legendre on 0..1, and two of no weight.
const LEGENDRE: [(f64, f64); LANES] = [
    (0.033_765_242_898_423_99, 0.085_662_246_189_585_18),
    (0.169_395_306_766_867_74, 0.180_380_786_524_069_3),
    (0.380_690_406_958_401_55, 0.233_956_967_286_345_52),
    (0.619_309_593_041_598_5, 0.233_956_967_286_345_52),
    (0.830_604_693_233_132_3, 0.180_380_786_524_069_3),
    (0.966_234_757_101_576, 0.085_662_246_189_585_18),
    (0.0, 0.0),
    (0.0, 0.0),
];
/// Nodes (in standard deviations) and weights of Gauss and Hermite.
const HERMITE: [(f64, f64); 5] = [
    (-2.856_970_013_872_805_6, 0.011_257_411_327_720_69),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_64),
    (0.0, 8.0 / 15.0),
    (1.355_626_179_974_266, 0.222_075_922_005_612_64),
    (2.856_970_013_872_805_6, 0.011_257_411_327_720_69),
];

/// One edge at one pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgeSide {
    /// The pixel's response to this edge without the other.
    pub(super) edge: Edge,
    /// Signed distance, in px.
    pub(super) distance: f64,
    /// Unit normal, nearly.
    pub(super) normal: DVec2,
}

/// The mean pattern and its derivatives by the two distances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CornerPattern {
    pub(super) value: f64,
    pub(super) by_distance: [f64; 2],
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
    /// The crossing of edges with these unit normals under these blurs, in px, with what their correlation is beyond an even blur's.
    pub(super) fn new(normals: [DVec2; 2], sigma_px: [f64; 2], skew: f64) -> Self {
        let mean_sigma = (sigma_px[0] * sigma_px[1]).sqrt();
        let pixel = match mean_sigma {
            s if s < SHARP_PX => Pixel::Sharp,
            s if s < LATTICE_PX => Pixel::Nodes,
            s if s < SMOOTH_PX => Pixel::Lattice(ExcessLattice::new(normals)),
            _ => Pixel::Smooth,
        };
        Self { sigma: sigma_px, mean_sigma, skew, pixel, gauss: Gauss::new() }
    }

    /// The mean of the product of both edges.
    #[inline(always)]
    pub(super) fn pattern(&self, sides: &[EdgeSide; 2]) -> CornerPattern {
        let [e0, e1] = [&sides[0].edge, &sides[1].edge];
        let product =
            CornerPattern { value: e0.value * e1.value, by_distance: [e0.slope * e1.value, e0.value * e1.slope] };
        // Where one edge is far, the response is that of the other, up to its sign.
        if e0.slope == 0.0 || e1.slope == 0.0 { product } else { self.corrected(product, sides) }
    }

    fn corrected(&self, product: CornerPattern, sides: &[EdgeSide; 2]) -> CornerPattern {
        let distances = [sides[0].distance, sides[1].distance];
        let normals = [sides[0].normal, sides[1].normal];
        let sigma = self.mean_sigma;
        let cosine = normals[0].dot(normals[1]);

        // Find the square pixel's part of the correction, and what its variance adds to the covariance of the two
        // distances, over their cosine.
        let (pixel, variance) = match &self.pixel {
            Pixel::Sharp => return CornerPattern { value: product.value + excess(normals, distances), ..product },
            Pixel::Nodes => {
                let moved = |at: DVec2| [0, 1].map(|k| distances[k] + normals[k].dot(at));
                let nodes =
                    HERMITE.iter().flat_map(|&(x, u)| HERMITE.iter().map(move |&(y, v)| (DVec2::new(x, y), u * v)));
                (nodes.map(|(at, weight)| weight * excess(normals, moved(at * sigma))).sum(), 0.0)
            }
            Pixel::Lattice(lattice) => (widest(BlurredExcess { lattice, distances, cosine, sigma }), 0.0),
            Pixel::Smooth => (0.0, PIXEL_VARIANCE),
        };

        // Add the blur's part: a bivariate normal integral of the correlation of the two distances.
        let covariance = (cosine + self.skew) * sigma * sigma + cosine * variance;
        let [v0, v1] = self.sigma.map(|s| s * s + PIXEL_VARIANCE);
        let correlation = covariance / (v0 * v1).sqrt();
        let blurred = if correlation.abs() < SERIES {
            series(product, sides, covariance)
        } else {
            self.integral(product, sides, [v0.sqrt(), v1.sqrt()], correlation.clamp(-0.999, 0.999))
        };
        CornerPattern { value: blurred.value + pixel, ..blurred }
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
                let here = cell * crate::vision::corner_pixel_model::excess(normals, at);
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

/// The excess under a Gaussian of the plane, whose parts along two normals have a given cosine as correlation.
struct BlurredExcess<'a> {
    lattice: &'a ExcessLattice,
    distances: [f64; 2],
    cosine: f64,
    sigma: f64,
}

impl Kernel for BlurredExcess<'_> {
    type Out = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        // Sum the excess under the Gaussian exp(-rate (a^2 - 2 c a b + b^2)), which is exp(-rate free a^2) times
        // exp(-rate (b - c a)^2), which falls off about a moved centre.
        let Self { lattice, distances, cosine, sigma } = self;
        let free = (1.0 - cosine * cosine).max(1e-3);
        let rate = 0.5 / (sigma * sigma * free);
        let offset =
            |k: usize| Lanes::of(|i| (distances[k] - ExcessLattice::place(lattice.reach[k], i)).clamp(-9.0, 9.0));
        let (a, b) = (offset(0), offset(1));
        let fall = (a * a * Lanes::splat(-rate * free)).exp();
        let mut sum = Lanes::splat(0.0);
        for i in 0..NODES {
            let moved = b - Lanes::splat(cosine * a.0[i]);
            sum += lattice.excess[i] * Lanes::splat(fall.0[i]) * (moved * moved * Lanes::splat(-rate)).exp();
        }
        sum.sum() * rate * free.sqrt() * std::f64::consts::FRAC_1_PI
    }
}

/// The integral of the density of two normal deviates h and k by their correlation, from 0 to the sine of an angle, over that angle.
struct MeanDensity {
    h: f64,
    k: f64,
    end: f64,
}

impl Kernel for MeanDensity {
    type Out = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { h, k, end } = self;
        let node = Lanes::of(|i| LEGENDRE[i].0);
        let sin = (Lanes::splat(end) * node).sin();
        let square = Lanes::splat(1.0) - sin * sin;
        let quadratic = Lanes::splat(h * h + k * k) - Lanes::splat(2.0 * h * k) * sin;
        let density = (-quadratic / (square + square)).exp();
        (Lanes::of(|i| LEGENDRE[i].1) * density).sum()
    }
}

impl CornerPixelModel {
    /// The bivariate normal integral: its derivative by the correlation is the density (Plackett), here with the correlation
    /// written as a sine.
    fn integral(
        &self,
        product: CornerPattern,
        sides: &[EdgeSide; 2],
        widths: [f64; 2],
        correlation: f64,
    ) -> CornerPattern {
        let (h, k) = (sides[0].distance / widths[0], sides[1].distance / widths[1]);
        let end = libm::asin(correlation);
        let mean = widest(MeanDensity { h, k, end });
        let root = (1.0 - correlation * correlation).sqrt();
        let odd = |z: f64| 2.0 * self.gauss.at(z)[0] - 1.0;
        CornerPattern {
            value: product.value + std::f64::consts::FRAC_2_PI * end * mean,
            by_distance: [
                sides[0].edge.slope * odd((k - correlation * h) / root),
                sides[1].edge.slope * odd((h - correlation * k) / root),
            ],
        }
    }
}

/// Mehler's series in the covariance of the two distances, to second order.
fn series(product: CornerPattern, sides: &[EdgeSide; 2], covariance: f64) -> CornerPattern {
    let [e0, e1] = [&sides[0].edge, &sides[1].edge];
    let second = 0.5 * covariance * covariance * e0.bend * e1.bend;
    CornerPattern {
        value: product.value + covariance * e0.slope * e1.slope + second,
        by_distance: [
            product.by_distance[0] + covariance * e0.bend * e1.slope,
            product.by_distance[1] + covariance * e0.slope * e1.bend,
        ],
    }
}

/// For sharp edges: the mean of the product over the pixel, less the product of the means.
fn excess(normals: [DVec2; 2], distances: [f64; 2]) -> f64 {
    let beyond = |k: usize| distances[k].abs() >= 0.5 * (normals[k].x.abs() + normals[k].y.abs());
    if beyond(0) || beyond(1) {
        return 0.0;
    }
    let share = |k: usize| 0.5 * (Profile::sharp(normals[k], distances[k]) + 1.0);
    4.0 * (common_area(normals, distances) - share(0) * share(1))
}

/// The area of the unit square around the origin where n.r + d > 0 for both edges.
fn common_area(normals: [DVec2; 2], distances: [f64; 2]) -> f64 {
    // Start from the unit square: each half-plane cuts at most one vertex more into a convex polygon.
    let mut polygon = [DVec2::ZERO; 8];
    let corners = [DVec2::new(-0.5, -0.5), DVec2::new(0.5, -0.5), DVec2::new(0.5, 0.5), DVec2::new(-0.5, 0.5)];
    polygon[..4].copy_from_slice(&corners);
    let mut count = 4;

    // Clip the polygon to each half-plane (Sutherland & Hodgman 1974).
    for (normal, distance) in normals.into_iter().zip(distances) {
        let source = polygon;
        let mut kept = 0;
        for k in 0..count {
            let (p, q) = (source[k], source[(k + 1) % count]);
            let (dp, dq) = (normal.dot(p) + distance, normal.dot(q) + distance);
            if dp > 0.0 {
                polygon[kept] = p;
                kept += 1;
            }
            if (dp > 0.0) != (dq > 0.0) {
                polygon[kept] = p.lerp(q, dp / (dp - dq));
                kept += 1;
            }
        }
        count = kept;
    }

    // Sum up its area.
    let twice: f64 = (0..count).map(|k| polygon[k].perp_dot(polygon[(k + 1) % count])).sum();
    0.5 * twice
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let sides = [0, 1].map(|k| EdgeSide {
            edge: Profile::new(unit(angles[k]), sigma[k]).at(distances[k]),
            distance: distances[k],
            normal: unit(angles[k]),
        });
        CornerPixelModel::new(angles.map(unit), sigma, 0.0).pattern(&sides).value
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
