//! An edge response prepared for many distances: the closed form of a sharp edge, and a table of a blurred one.

use super::blur_shape::{BUMPS, BlurShape, PictureBlur};
use super::column::{CHUNK, Column};
#[cfg(test)]
use super::edge_spread::Edge;
use super::edge_spread::{EdgeShape, SHARP_PX};
use crate::num::gauss::Gauss;
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use glam::DVec2;

/// Table cells in one standard deviation. The cubic errs by at most max|F''''| h^4 / 384 = 0.55 (1/5)^4 / 384 = 2.3e-6
/// of the contrast (E: twice that); at the end of the table it joins the dropped tail.
const CELLS_PER_SIGMA: f64 = 5.0;

/// The responses of an edge at many distances, and their slopes.
struct Responses<'a> {
    shape: &'a EdgeShape,
    distances: Lanes,
}

impl Kernel for Responses<'_> {
    type Out = [Lanes; 2];

    #[inline(always)]
    fn run(self) -> [Lanes; 2] {
        self.shape.exact_lanes(Gauss::new(), self.distances)
    }
}

/// Value and slope, in 1/px, at distances of 0, 1, .. `last` cells, so many of them a px.
fn responses(shape: &EdgeShape, density: f64, last: usize) -> Vec<[f64; 2]> {
    // Evaluate them where there is an edge; beyond its reach it is 1.
    let near = last.min((shape.reach() * density) as usize + 1);
    let mut nodes: Vec<[f64; 2]> = Vec::with_capacity(last + LANES);
    while nodes.len() <= near {
        let first = nodes.len();
        let distances = Lanes::of(|k| (first + k) as f64 / density);
        let [values, slopes] = widest(Responses { shape, distances });
        nodes.extend((0..LANES).map(|k| [values.0[k], slopes.0[k]]));
    }
    nodes.resize(last + 1, [1.0, 0.0]);
    // E is odd by construction, not only to rounding.
    nodes[0][0] = 0.0;
    nodes
}

/// What each pair of bumps adds to the response `plain` at some distances towards bright, and then each pair that is not alike to both
/// sides, from the response under one bump; of so many pairs.
#[inline(always)]
pub(super) fn pairs(
    shape: &BlurShape,
    bump: &Profile,
    plain: &Column,
    d: &Column,
    count: usize,
) -> [Column; 2 * BUMPS] {
    let mut pairs = [[0.0; CHUNK]; 2 * BUMPS];
    for j in 0..=BUMPS {
        let x = j as f64 * shape.spacing_px;
        let [behind, _, _] = bump.at_all(&d.map(|d| d - x));
        let [before, _, _] = bump.at_all(&d.map(|d| d + x));
        for i in 0..CHUNK {
            if j < BUMPS {
                pairs[j][i] = 0.5 * (behind[i] + before[i]) - plain[i];
            }
            if j > 0 && count > BUMPS {
                pairs[BUMPS + j - 1][i] = 0.5 * (behind[i] - before[i]);
            }
        }
    }
    pairs
}

/// Value and slope of the response under a Gaussian and what the blur is beside that, at -`half`, .. `half` cells, of which
/// `cells` are a spacing of the bumps.
struct ShapedNodes<'a> {
    beside: &'a BlurShape,
    plain: &'a EdgeShape,
    half: usize,
    cells: usize,
}

/// Both sides of an edge, from one.
#[inline(always)]
fn both_sides(nodes: &[[f64; 2]]) -> [Vec<f64>; 2] {
    let values = nodes.iter().rev().map(|n| -n[0]).chain(nodes[1..].iter().map(|n| n[0]));
    let slopes = nodes.iter().rev().map(|n| n[1]).chain(nodes[1..].iter().map(|n| n[1]));
    [values.collect(), slopes.collect()]
}

impl Kernel for ShapedNodes<'_> {
    type Out = [Vec<f64>; 2];

    #[inline(always)]
    fn run(self) -> [Vec<f64>; 2] {
        let Self { beside, plain, half, cells } = self;
        let density = cells as f64 / beside.spacing_px;
        let last = half + BUMPS * cells;
        let bump = both_sides(&responses(&plain.under(beside.bump_px()), density, last));
        let plain = both_sides(&responses(plain, density, half));
        let mut sums = plain.clone();
        for (sum, (plain, bump)) in sums.iter_mut().zip(plain.iter().zip(&bump)) {
            for j in 0..=BUMPS {
                let even = beside.weights.get(j).copied().unwrap_or(0.0);
                let uneven = if j == 0 { 0.0 } else { beside.uneven[j - 1] };
                // Bumps that are `j` spacings before and behind.
                let (low, high) = (&bump[(BUMPS - j) * cells..], &bump[(BUMPS + j) * cells..]);
                if even != 0.0 || uneven != 0.0 {
                    for (i, sum) in sum.iter_mut().enumerate() {
                        let (low, high) = (low[i], high[i]);
                        *sum += even * (0.5 * (low + high) - plain[i]) + 0.5 * uneven * (low - high);
                    }
                }
            }
        }
        sums
    }
}

/// A [`EdgeShape`] prepared for many distances.
#[derive(Debug, Clone)]
pub(super) enum Profile {
    /// No blur: the closed form is the fastest.
    Sharp(EdgeShape),
    /// Blurred: cubics between exact nodes.
    Table {
        /// Cells per px.
        density: f64,
        /// Where distance 0 lies, in cells.
        middle: f64,
        /// Per cell the cubic's coefficients in the cell's own coordinate 0..1; the first and the last cell are flat.
        cells: Vec<[f64; 4]>,
        /// Whether it is alike to both sides of an edge: E is odd. Otherwise the distance is towards bright.
        even: bool,
    },
}

impl Profile {
    /// The profile for a unit normal and a Gaussian blur in px.
    pub(super) fn new(normal: DVec2, sigma_px: f64) -> Self {
        Self::shaped(EdgeShape::new(normal, sigma_px), &PictureBlur::gaussian([sigma_px; 2]).shapes[0])
    }

    /// The profile of an edge under a Gaussian and motion, and what the blur is beside them.
    pub(super) fn shaped(shape: EdgeShape, beside: &BlurShape) -> Self {
        // Take the closed form of a sharp edge.
        let sigma_px = shape.sigma_px();
        if sigma_px < SHARP_PX {
            return Self::Sharp(shape);
        }

        // Size the table to the reach of the edge.
        let plain = beside.is_gaussian();
        let cells = (CELLS_PER_SIGMA * beside.spacing_px / sigma_px.min(beside.bump_px())).ceil();
        let density = if plain { CELLS_PER_SIGMA / sigma_px } else { cells / beside.spacing_px };
        let half = (shape.reach_under(beside.reach_px()) * density).ceil() as usize;

        // Evaluate E and its rise over a cell at distances 0, 1, .. half cells, and interpolate.
        if plain {
            let nodes = responses(&shape, density, half);
            return Self::even(density, half, |i| (nodes[i][0], nodes[i][1] / density));
        }
        let [values, slopes] = widest(ShapedNodes { beside, plain: &shape, half, cells: cells as usize });
        let node = |i: i64| {
            let place = (i + half as i64) as usize;
            (values[place], slopes[place] / density)
        };
        if beside.is_even() {
            Self::even(density, half, |i| if i == 0 { (0.0, node(0).1) } else { node(i as i64) })
        } else {
            Self::uneven(density, half, node)
        }
    }

    /// The table of an odd response, from value and rise at 0, 1, .. `half` cells; the last is the end.
    fn even(density: f64, half: usize, node: impl Fn(usize) -> (f64, f64)) -> Self {
        // Interpolate by cubics from node to node, both ways from the middle.
        let mut cells = vec![[0.0; 4]; 2 * half + 2];
        cells[0] = [-1.0, 0.0, 0.0, 0.0];
        cells[2 * half + 1] = [1.0, 0.0, 0.0, 0.0];
        let (mut value, mut slope) = node(0);
        for i in 0..half {
            let (next, next_slope) = if i + 1 == half { (1.0, 0.0) } else { node(i + 1) };
            let [.., second, third] = cubic((value, slope), (next, next_slope));
            cells[half + 1 + i] = [value, slope, second, third];
            // The same cubic from its other end, turned about the origin.
            cells[half - i] = [-next, next_slope, -second - 3.0 * third, third];
            (value, slope) = (next, next_slope);
        }
        Self::Table { density, middle: (half + 1) as f64, cells, even: true }
    }

    /// The table of a response that is not odd, from value and rise at -`half`, .. `half` cells; the outermost are the ends.
    fn uneven(density: f64, half: usize, node: impl Fn(i64) -> (f64, f64)) -> Self {
        let end = half as i64;
        let node = |i: i64| if i.abs() == end { (i.signum() as f64, 0.0) } else { node(i) };
        let nodes: Vec<(f64, f64)> = (-end..=end).map(node).collect();
        let inner = nodes.windows(2).map(|pair| cubic(pair[0], pair[1]));
        let ends = [-1.0, 1.0].map(|end| [end, 0.0, 0.0, 0.0]);
        let cells = [ends[0]].into_iter().chain(inner).chain([ends[1]]).collect();
        Self::Table { density, middle: (half + 1) as f64, cells, even: false }
    }

    /// E at distance `d` from a sharp edge.
    pub(super) fn sharp(normal: DVec2, d: f64) -> f64 {
        EdgeShape::new(normal, 0.0).sharp(d).value
    }

    /// Whether the response is odd.
    pub(super) fn is_even(&self) -> bool {
        matches!(self, Self::Sharp(_) | Self::Table { even: true, .. })
    }

    /// The response at distance `d` of an edge that is bright on the positive side, `bright` = 1, or on the negative, -1.
    #[cfg(test)]
    pub(super) fn towards(&self, d: f64, bright: f64) -> Edge {
        let edge = self.at(bright * d);
        Edge { value: bright * edge.value, slope: edge.slope, bend: bright * edge.bend }
    }

    /// The mean response over edges that are bright on either side: odd.
    #[cfg(test)]
    pub(super) fn odd(&self, d: f64) -> Edge {
        let [a, b] = [self.at(d), self.at(-d)];
        Edge { value: 0.5 * (a.value - b.value), slope: 0.5 * (a.slope + b.slope), bend: 0.5 * (a.bend - b.bend) }
    }

    /// The responses at many distances: E, its slopes and its bends, as of [`Self::at`].
    #[inline(always)]
    pub(super) fn at_all<const N: usize>(&self, distances: &[f64; N]) -> [[f64; N]; 3] {
        // Adding this rounds to a whole number, which the last bits then hold.
        const ROUNDING: f64 = 4_503_599_627_370_496.0;
        let [mut values, mut slopes, mut bends] = [[0.0; N]; 3];
        match self {
            Self::Sharp(shape) => {
                for i in 0..N {
                    let seen = shape.sharp(distances[i]);
                    (values[i], slopes[i]) = (seen.value, seen.slope);
                }
            }
            Self::Table { density, middle, cells, .. } => {
                // Find the cell of each, and the place in it.
                let last = (cells.len() - 1) as f64;
                let (mut rest, mut cell) = ([0.0; N], [0u32; N]);
                for i in 0..N {
                    let place = distances[i] * density + middle;
                    let place = if place > 0.0 { place } else { 0.0 };
                    let place = if place < last { place } else { last };
                    let rounded = place + ROUNDING;
                    let above = (rounded - ROUNDING) > place;
                    let floor = if above { rounded - 1.0 } else { rounded };
                    rest[i] = place - (floor - ROUNDING);
                    cell[i] = floor.to_bits() as u32;
                }

                // Evaluate the cubics.
                let mut cubics = [[0.0; 4]; N];
                for (cubic, &cell) in cubics.iter_mut().zip(&cell) {
                    *cubic = cells[cell as usize];
                }
                for i in 0..N {
                    let ([c0, c1, c2, c3], t) = (cubics[i], rest[i]);
                    values[i] = c0 + t * (c1 + t * (c2 + t * c3));
                    slopes[i] = (c1 + t * (2.0 * c2 + 3.0 * t * c3)) * density;
                    bends[i] = (2.0 * c2 + 6.0 * t * c3) * density * density;
                }
            }
        }
        [values, slopes, bends]
    }

    /// The response at distance `d`.
    #[cfg(test)]
    pub(super) fn at(&self, d: f64) -> Edge {
        match self {
            Self::Sharp(shape) => shape.sharp(d),
            Self::Table { density, middle, cells, .. } => {
                let place = (d * density + middle).max(0.0);
                let index = (place as usize).min(cells.len() - 1);
                let t = place - index as f64;
                let [c0, c1, c2, c3] = cells[index];
                Edge {
                    value: c0 + t * (c1 + t * (c2 + t * c3)),
                    slope: (c1 + t * (2.0 * c2 + 3.0 * t * c3)) * density,
                    bend: (2.0 * c2 + 6.0 * t * c3) * density * density,
                }
            }
        }
    }
}

/// The cubic over a cell from values and rises at both ends.
fn cubic((value, slope): (f64, f64), (next, next_slope): (f64, f64)) -> [f64; 4] {
    let rise = next - value;
    [value, slope, 3.0 * rise - 2.0 * slope - next_slope, slope + next_slope - 2.0 * rise]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal(degrees: f64) -> DVec2 {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        DVec2::new(cos, sin)
    }

    #[test]
    fn the_table_keeps_its_stated_error() {
        let gauss = Gauss::new();
        for degrees in [0.0, 1.0, 20.0, 45.0, 89.0] {
            for s in [0.03, 0.3, 0.7, 2.0, 6.0] {
                let (shape, profile) = (EdgeShape::new(normal(degrees), s), Profile::new(normal(degrees), s));
                for i in -500..=500 {
                    let d = f64::from(i) / 500.0 * (shape.reach() + 0.3);
                    let (exact, table) = (shape.exact(gauss, d), profile.at(d));
                    assert!((exact.value - table.value).abs() < 8e-6, "{degrees} {s} {d}");
                }
            }
        }
    }

    /// Weights of bumps that together are a square of a known width are its edge: the Gaussian's own share is gone, and the
    /// response is odd.
    #[test]
    fn bumps_make_the_edge_of_another_blur() {
        let gauss = Gauss::new();
        let mut shape = PictureBlur::gaussian([1.0; 2]).shapes[0];
        // Bumps of one weight from -4 to 4 spacings: a square of nine spacings with soft ends.
        shape.weights[..5].copy_from_slice(&[1.0 / 9.0, 2.0 / 9.0, 2.0 / 9.0, 2.0 / 9.0, 2.0 / 9.0]);
        let (n, half) = (normal(20.0), 4.5 * shape.spacing_px);
        let profile = Profile::shaped(EdgeShape::new(n, 1.0), &shape);
        for i in -40..=40 {
            let d = f64::from(i) * 0.13;
            // The mean of the edge under one bump's Gaussian over the square, by the midpoint rule.
            let under = EdgeShape::new(n, shape.bump_px());
            let parts = 2000;
            let at = |k: i32| half * (2.0 * (f64::from(k) + 0.5) / f64::from(parts) - 1.0);
            let mean = (0..parts).map(|k| under.exact(gauss, d - at(k)).value).sum::<f64>() / f64::from(parts);
            // A sum over points one spacing apart for a mean over it: spacing^2 / 24 of the curvature, at most 0.6 / px^2.
            assert!((profile.at(d).value - mean).abs() < 0.6 * shape.spacing_px * shape.spacing_px / 24.0, "{d}");
            assert!((profile.at(d).value + profile.at(-d).value).abs() < 1e-12, "{d}");
        }
    }

    #[test]
    fn many_distances_go_through_as_one_does() {
        let mut uneven = PictureBlur::gaussian([0.7; 2]).shapes[0];
        uneven.uneven[1] = -0.3;
        let profiles = [0.0, 0.03, 0.7, 2.0].map(|s| (s, Profile::new(normal(20.0), s)));
        for (s, profile) in
            profiles.into_iter().chain([(0.7, Profile::shaped(EdgeShape::new(normal(20.0), 0.7), &uneven))])
        {
            // Within the reach, at its ends, and far beyond.
            let distances: [f64; 64] = std::array::from_fn(|i| (i as f64 - 32.0) * 0.05 * (1.0 + 4.0 * s));
            let far = [0.0, -0.0, 1e9, -1e9, 1e300, -1e300, 7.0, -7.0];
            let of = |i: usize| if i < far.len() { far[i] } else { distances[i] };
            let [values, slopes, bends] = profile.at_all(&std::array::from_fn::<f64, 64, _>(of));
            for i in 0..64 {
                let Edge { value, slope, bend } = profile.at(of(i));
                assert_eq!([values[i], slopes[i], bends[i]], [value, slope, bend], "{s} {}", of(i));
            }
        }
    }

    #[test]
    fn the_sharp_form_is_the_limit_of_the_blurred_one() {
        let gauss = Gauss::new();
        for degrees in [0.0, 20.0, 45.0] {
            let profile = Profile::new(normal(degrees), 0.0);
            let blurred = EdgeShape::new(normal(degrees), 1e-4);
            for i in -20..=20 {
                let d = f64::from(i) * 0.05 + 0.013;
                assert!((profile.at(d).value - blurred.exact(gauss, d).value).abs() < 1e-4, "{degrees} {d}");
            }
        }
    }
}
