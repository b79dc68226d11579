//! The edge spread function of a square pixel under a Gaussian blur: exact, and as a table.
//!
//! With unit normal n, a = |nx|/2, b = |ny|/2 and blur s, the bright share of a pixel at signed distance d is
//!
//! ```text
//! F(d) = [R(d+a+b) - R(d+a-b) - R(d-a+b) + R(d-a-b)] / (4ab),   R(t) = ((t^2 + s^2) Phi(t/s) + t s phi(t/s)) / 2
//! ```
//!
//! with the Gaussian phi and its integral Phi; F', F'' follow with R', R''. An edge is used as E = 2F - 1, which runs from
//! -1 to 1. Blur is diffusion: dE/ds = s E''.

use super::blur_shape::{BUMPS, BlurShape, PictureBlur};
use crate::num::gauss::Gauss;
use glam::DVec2;

/// Below this a and b count as this: the four terms would cancel, and the edge moves by less than 1e-6 px.
const LEAST_HALF_WIDTH: f64 = 2e-3;
/// How much wider a pixel is, in px, for the slope of a sharp edge.
const SHARP_MARGIN: f64 = 0.03;
/// A blur below this, in px, is taken as none.
pub(super) const SHARP_PX: f64 = 0.02;
/// The Gaussian's tail beyond this many standard deviations is dropped: it holds 7e-6, alike on both sides of an edge,
/// so that no edge moves.
const TAIL: f64 = 4.5;
/// Table cells in one standard deviation. The cubic errs by at most max|F''''| h^4 / 384 = 0.55 (1/5)^4 / 384 = 2.3e-6
/// of the contrast (E: twice that); at the end of the table it joins the dropped tail.
const CELLS_PER_SIGMA: f64 = 5.0;

/// The edge response and its derivatives at one distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    /// E
    pub(super) value: f64,
    /// dE/dd, in 1/px
    pub(super) slope: f64,
    /// d2E/dd2, in 1/px^2
    pub(super) bend: f64,
}

/// The pixel's half widths across an edge, and the blur.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EdgeShape {
    a: f64,
    b: f64,
    sigma: f64,
}

impl EdgeShape {
    /// The shape for a unit normal and a blur in px.
    pub(super) fn new(normal: DVec2, sigma_px: f64) -> Self {
        let half = |n: f64| (0.5 * n.abs()).max(LEAST_HALF_WIDTH);
        Self { a: half(normal.x), b: half(normal.y), sigma: sigma_px }
    }

    /// Beyond this distance, in px, the edge is -1 or 1.
    pub(super) fn reach(&self) -> f64 {
        self.a + self.b + SHARP_MARGIN + TAIL * self.sigma
    }

    /// The same with what the blur is beside the Gaussian.
    pub(super) fn reach_under(&self, beside: &BlurShape) -> f64 {
        self.reach().max(self.a + self.b + beside.reach_px())
    }

    /// The sum of the four corner terms of `f`, over 4ab.
    #[inline(always)]
    fn corners(&self, d: f64, f: impl Fn(f64) -> f64) -> f64 {
        let (sum, difference) = (self.a + self.b, self.a - self.b);
        ((f(d + sum) - f(d + difference)) - (f(d - difference) - f(d - sum))) / (4.0 * self.a * self.b)
    }

    /// The response at distance `d`.
    pub(super) fn exact(&self, gauss: Gauss, d: f64) -> Edge {
        if d.abs() >= self.reach() {
            return Edge { value: d.signum(), slope: 0.0, bend: 0.0 };
        }
        let s = self.sigma;
        let (sum, difference) = (self.a + self.b, self.a - self.b);
        let inverse = 1.0 / s;
        let term = |t: f64| {
            let [big, small] = gauss.at(t * inverse);
            [0.5 * ((t * t + s * s) * big + t * s * small), t * big + s * small, big]
        };
        let (t0, t1, t2, t3) = (term(d + sum), term(d + difference), term(d - difference), term(d - sum));
        let over = 1.0 / (4.0 * self.a * self.b);
        let mix = |i: usize| ((t0[i] - t1[i]) - (t2[i] - t3[i])) * over;
        Edge { value: 2.0 * mix(0) - 1.0, slope: 2.0 * mix(1), bend: 2.0 * mix(2) }
    }

    /// The response of a pixel to a sharp edge (s = 0): a parabola, a line and a parabola.
    ///
    /// The slope is that of a slightly wider pixel: where an edge lies on a pixel's border, neither pixel beside it would
    /// tell which way to move, and a fit would stop there.
    #[inline(always)]
    fn sharp(&self, d: f64) -> Edge {
        if d.abs() >= self.a + self.b + SHARP_MARGIN {
            return Edge { value: d.signum(), slope: 0.0, bend: 0.0 };
        }
        let value = if d.abs() < self.a + self.b {
            2.0 * self.corners(d, |t| 0.5 * t.max(0.0) * t.max(0.0)) - 1.0
        } else {
            d.signum()
        };
        let wide = Self { b: self.b.max(SHARP_MARGIN), a: self.a.max(SHARP_MARGIN), ..*self };
        Edge { value, slope: 2.0 * wide.corners(d, |t| t.max(0.0)), bend: 0.0 }
    }
}

/// The response under each pair of bumps, less `plain`, at distance `d`, from that under one bump.
pub(super) fn bump_pairs(shape: &BlurShape, bump: &Profile, plain: Edge, d: f64) -> [f64; BUMPS] {
    std::array::from_fn(|j| {
        let x = j as f64 * shape.spacing_px;
        0.5 * (bump.at(d - x).value + bump.at(d + x).value) - plain.value
    })
}

/// What each pair that is not alike to both sides adds at distance `d` towards bright.
pub(super) fn uneven_pairs(shape: &BlurShape, bump: &Profile, d: f64) -> [f64; BUMPS] {
    std::array::from_fn(|j| {
        let x = (j + 1) as f64 * shape.spacing_px;
        0.5 * (bump.at(d - x).value - bump.at(d + x).value)
    })
}

/// The response under a Gaussian and what the blur is beside that, at multiples of a cell: so many cells a spacing of the bumps.
struct ShapedNodes<'a> {
    beside: &'a BlurShape,
    plain: EdgeShape,
    /// Value and slope under one bump at the cells from 0 on.
    bump: Vec<[f64; 2]>,
    cells: i64,
}

impl<'a> ShapedNodes<'a> {
    /// For nodes up to `half` cells away, in cells of a share of the spacing.
    fn new(beside: &'a BlurShape, plain: EdgeShape, normal: DVec2, (half, cells): (usize, usize)) -> Self {
        let (gauss, under) = (Gauss::new(), EdgeShape::new(normal, beside.bump_px()));
        let at = |i: usize| {
            let edge = under.exact(gauss, i as f64 * beside.spacing_px / cells as f64);
            [edge.value, edge.slope]
        };
        let bump = (0..=half + BUMPS * cells).map(at).collect();
        Self { beside, plain, bump, cells: cells as i64 }
    }

    /// Value and slope under one bump.
    fn bump(&self, i: i64) -> [f64; 2] {
        let [value, slope] = self.bump[i.unsigned_abs() as usize];
        [if i < 0 { -value } else { value }, slope]
    }

    /// Value and slope at a cell.
    fn at(&self, gauss: Gauss, i: i64) -> [f64; 2] {
        let edge = self.plain.exact(gauss, i as f64 * self.beside.spacing_px / self.cells as f64);
        let plain = [edge.value, edge.slope];
        let mut sum = plain;
        for j in 0..BUMPS {
            let away = |k: usize| [self.bump(i - k as i64 * self.cells), self.bump(i + k as i64 * self.cells)];
            let ([low, high], [before, behind]) = (away(j), away(j + 1));
            for k in 0..2 {
                sum[k] += self.beside.weights[j] * (0.5 * (low[k] + high[k]) - plain[k])
                    + 0.5 * self.beside.uneven[j] * (before[k] - behind[k]);
            }
        }
        sum
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
        Self::shaped(normal, sigma_px, &PictureBlur::gaussian([sigma_px; 2]).shapes[0])
    }

    /// The profile for a unit normal and a blur: the standard deviation of a Gaussian, in px, and what it is beside that.
    pub(super) fn shaped(normal: DVec2, sigma_px: f64, beside: &BlurShape) -> Self {
        // Take the closed form of a sharp edge.
        let shape = EdgeShape::new(normal, sigma_px);
        if sigma_px < SHARP_PX {
            return Self::Sharp(shape);
        }

        // Size the table to the reach of the edge.
        let gauss = Gauss::new();
        let plain = beside.is_gaussian();
        let cells = (CELLS_PER_SIGMA * beside.spacing_px / sigma_px.min(beside.bump_px())).ceil();
        let density = if plain { CELLS_PER_SIGMA / sigma_px } else { cells / beside.spacing_px };
        let half = (shape.reach_under(beside) * density).ceil() as usize;
        let shaped = (!plain).then(|| ShapedNodes::new(beside, shape, normal, (half, cells as usize)));
        let exact = |i: i64| match &shaped {
            Some(nodes) => nodes.at(gauss, i),
            None => {
                let edge = shape.exact(gauss, i as f64 / density);
                [edge.value, edge.slope]
            }
        };

        // Where it is not alike to both sides, interpolate by cubics from end to end.
        if !beside.is_even() {
            let node = |i: i64| {
                let [value, slope] = exact(i);
                if i.unsigned_abs() as usize == half { (i.signum() as f64, 0.0) } else { (value, slope / density) }
            };
            let nodes: Vec<(f64, f64)> = (-(half as i64)..=half as i64).map(node).collect();
            let inner = nodes.windows(2).map(|pair| cubic(pair[0], pair[1]));
            let ends = [-1.0, 1.0].map(|end| [end, 0.0, 0.0, 0.0]);
            let cells = [ends[0]].into_iter().chain(inner).chain([ends[1]]).collect();
            return Self::Table { density, middle: (half + 1) as f64, cells, even: false };
        }

        // Evaluate E and its rise over a cell at distances 0, 1, .. half cells; E is odd by construction, not only to
        // rounding.
        let node = |i: usize| match i {
            _ if i == half => (1.0, 0.0),
            0 => (0.0, exact(0)[1] / density),
            _ => {
                let [value, slope] = exact(i as i64);
                (value, slope / density)
            }
        };

        // Interpolate by cubics from node to node, both ways from the middle.
        let mut cells = vec![[0.0; 4]; 2 * half + 2];
        cells[0] = [-1.0, 0.0, 0.0, 0.0];
        cells[2 * half + 1] = [1.0, 0.0, 0.0, 0.0];
        let (mut value, mut slope) = node(0);
        for i in 0..half {
            let (next, next_slope) = node(i + 1);
            let [.., second, third] = cubic((value, slope), (next, next_slope));
            cells[half + 1 + i] = [value, slope, second, third];
            // The same cubic from its other end, turned about the origin.
            cells[half - i] = [-next, next_slope, -second - 3.0 * third, third];
            (value, slope) = (next, next_slope);
        }
        Self::Table { density, middle: (half + 1) as f64, cells, even: true }
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
    #[inline]
    pub(super) fn towards(&self, d: f64, bright: f64) -> Edge {
        let edge = self.at(bright * d);
        Edge { value: bright * edge.value, slope: edge.slope, bend: bright * edge.bend }
    }

    /// The mean response over edges that are bright on either side: odd.
    #[inline]
    pub(super) fn odd(&self, d: f64) -> Edge {
        let [a, b] = [self.at(d), self.at(-d)];
        Edge { value: 0.5 * (a.value - b.value), slope: 0.5 * (a.slope + b.slope), bend: 0.5 * (a.bend - b.bend) }
    }

    /// The response at distance `d`.
    #[inline(always)]
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
    fn exact_response_is_the_mean_over_the_pixel_of_a_blurred_edge() {
        let gauss = Gauss::new();
        for (degrees, s, d) in [(0.0, 0.5, 0.2), (20.0, 0.3, -0.4), (45.0, 1.0, 0.9), (77.0, 0.1, 0.05)] {
            let n = normal(degrees);
            let side = 400;
            let mean = (0..side * side)
                .map(|k| {
                    let at = |i: usize| (i as f64 + 0.5) / side as f64 - 0.5;
                    let t = d + n.dot(DVec2::new(at(k % side), at(k / side)));
                    libm::erf(t / s * std::f64::consts::FRAC_1_SQRT_2)
                })
                .sum::<f64>()
                / (side * side) as f64;
            // The midpoint rule errs by E'' h^2 / 24 < 1e-4 / s^2 / 400^2; the floor of b by b^2.
            assert!((EdgeShape::new(n, s).exact(gauss, d).value - mean).abs() < 5e-6, "{degrees} {s} {d}");
        }
    }

    #[test]
    fn derivatives_agree_with_central_differences() {
        let gauss = Gauss::new();
        let h = 1e-5;
        for (degrees, s, d) in [(3.0, 0.5, 0.2), (20.0, 0.3, -0.4), (45.0, 1.0, 0.9)] {
            let shape = EdgeShape::new(normal(degrees), s);
            let edge = shape.exact(gauss, d);
            let (low, high) = (shape.exact(gauss, d - h), shape.exact(gauss, d + h));
            assert!((edge.slope - (high.value - low.value) / (2.0 * h)).abs() < 1e-7);
            assert!((edge.bend - (high.slope - low.slope) / (2.0 * h)).abs() < 1e-7);
            let wider = EdgeShape::new(normal(degrees), s + h).exact(gauss, d).value;
            let narrower = EdgeShape::new(normal(degrees), s - h).exact(gauss, d).value;
            assert!((s * edge.bend - (wider - narrower) / (2.0 * h)).abs() < 1e-7);
        }
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
        let profile = Profile::shaped(n, 1.0, &shape);
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
