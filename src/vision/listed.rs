//! The pixels near both edges of a corner, some at a time: what the model says of them, and its derivatives.

use super::column::{CHUNK, Column};
use super::corner_model::{Model, PARAMETERS, Right};
use super::corner_pixel_model::{Patterns, SeenEdges};
use super::crossing::CrossingResponse;
use super::edge_spread::PIXEL_VARIANCE;
use super::equation_sums::Equations;
use super::profile::Profile;
use super::window::{ListedPixel, Window};
use crate::num::simd::Kernel;
use glam::DVec2;

/// Lanes of a sum.
const LANES: usize = 4;

/// What of a model is the same for all pixels.
pub(super) struct Ready {
    pub(super) normals: [DVec2; 2],
    pub(super) tangents: [DVec2; 2],
    /// What blur and pixel add to the distance from an edge that is bent, or lies in light that is not even, in px.
    pub(super) shifts_px: [f64; 2],
    /// [`Model::steps_px`]
    pub(super) steps_px: [f64; 2],
    /// Whether the profiles are not alike to both sides of an edge.
    uneven: bool,
    /// Whether the smaller squares are bright, 1, or dark, -1.
    smaller: f64,
}

impl Ready {
    pub(super) fn new(model: &Model, profiles: &[Profile; 2]) -> Self {
        let normals = model.normals();
        // A mean over a spread of variance v of a pattern p in light that varies by the share g is p + v g p', to first
        // order p shifted by v g.
        let [_, _, _, a0, ax, ay] = model.light;
        let share = if a0 == 0.0 { DVec2::ZERO } else { DVec2::new(ax, ay) / a0 };
        let shifts_px = [0, 1].map(|k| {
            let blur = model.sigma_px[k] * model.sigma_px[k];
            let spread = PIXEL_VARIANCE + if model.light_is_blurred { blur } else { 0.0 };
            // Of motion the way along the edge counts for the bend, and the light on it for the shift.
            let way = model.half_way_px;
            let (along, across) = (normals[k].perp().dot(way), normals[k].dot(way));
            let lit = if model.light_is_blurred { across * way.dot(share) / 3.0 } else { 0.0 };
            0.5 * model.curvature[k] * (blur + PIXEL_VARIANCE + along * along / 3.0)
                + spread * share.dot(normals[k])
                + lit
        });
        let uneven = profiles.iter().any(|profile| !profile.is_even());
        let smaller = -model.leans_px[0].signum();
        Self { normals, tangents: normals.map(DVec2::perp), shifts_px, steps_px: model.steps_px(), uneven, smaller }
    }

    /// What couples each edge's bend with the other's blur: E over a Gaussian x of x^2 sign(d + x) is s^2 E + s^4 E'', of which the
    /// mean shift leaves out the second part where the other edge is near. (For a sharp picture s^4 is nothing.)
    fn couplings(&self, model: &Model) -> [f64; 2] {
        let cross = self.normals[0].perp_dot(self.normals[1]);
        let [s0, s1] = model.sigma_px;
        [
            0.5 * model.curvature[0] * cross * cross * s1 * s1 * s1 * s1,
            0.5 * model.curvature[1] * cross * cross * s0 * s0 * s0 * s0,
        ]
    }

    /// The responses to an edge at some distances, without its lean.
    #[inline(always)]
    fn seen(&self, profile: &Profile, distances: &Column) -> [Column; 3] {
        let [values, slopes, bends] = profile.at_all(distances);
        if !self.uneven {
            return [values, slopes, bends];
        }
        // The mean over edges that are bright on either side is odd.
        let [other_values, other_slopes, other_bends] = profile.at_all(&distances.map(|d| -d));
        [
            column(|i| 0.5 * (values[i] - other_values[i])),
            column(|i| 0.5 * (slopes[i] + other_slopes[i])),
            column(|i| 0.5 * (bends[i] - other_bends[i])),
        ]
    }

    /// Share and slope of edge `k` on the side of `sign`, moved inwards by its lean.
    #[inline(always)]
    fn part(&self, profile: &Profile, distances: &Column, growth: &Column, (k, sign): (usize, f64)) -> [Column; 2] {
        let step = self.steps_px[k].abs();
        let side = if self.uneven { self.smaller } else { 1.0 };
        let inwards = column(|i| side * (sign * distances[i] - step * (1.0 + growth[i])));
        let [values, slopes, _] = profile.at_all(&inwards);
        [column(|i| 0.5 * (1.0 + side * values[i])), column(|i| 0.5 * sign * slopes[i])]
    }

    /// The patterns where both edges lean: the squares of the positive sign are larger by `steps_px` at both edges, or the others.
    ///
    /// Where they are larger, the pattern is 1 but for the two squares of the other sign, each the product of its two edges. The
    /// correction where both edges are near is that of the crossing without lean.
    #[inline(always)]
    fn leaning(&self, profiles: &[Profile; 2], seen: &SeenEdges, growth: &[Column; 2], plain: &Patterns) -> Patterns {
        // Where the positive sign is larger, the smaller squares have the distances' signs apart.
        let other = if self.steps_px[0] > 0.0 { -1.0 } else { 1.0 };
        let a0 = self.part(&profiles[0], &seen.distances[0], &growth[0], (0, 1.0));
        let a1 = self.part(&profiles[1], &seen.distances[1], &growth[1], (1, other));
        let b0 = self.part(&profiles[0], &seen.distances[0], &growth[0], (0, -1.0));
        let b1 = self.part(&profiles[1], &seen.distances[1], &growth[1], (1, -other));

        // Add the share of the two squares that are smaller to the correction, and its derivatives by both distances.
        let [[e0, slope0, _], [e1, slope1, _]] = &seen.edges;
        let share = column(|i| a0[0][i] * a1[0][i] + b0[0][i] * b1[0][i]);
        let by0 = column(|i| a0[1][i] * a1[0][i] + b0[1][i] * b1[0][i]);
        let by1 = column(|i| a0[0][i] * a1[1][i] + b0[0][i] * b1[1][i]);
        Patterns {
            values: column(|i| plain.values[i] - e0[i] * e1[i] + other * (2.0 * share[i] - 1.0)),
            by_distance: [
                column(|i| plain.by_distance[0][i] - slope0[i] * e1[i] + 2.0 * other * by0[i]),
                column(|i| plain.by_distance[1][i] - e0[i] * slope1[i] + 2.0 * other * by1[i]),
            ],
        }
    }
}

#[inline(always)]
fn column(of: impl Fn(usize) -> f64) -> Column {
    let mut out = [0.0; CHUNK];
    for (i, out) in out.iter_mut().enumerate() {
        *out = of(i);
    }
    out
}

/// Adds the pixels near both edges to the equations over the first `active` parameters.
pub(super) struct ListedSums<'a> {
    pub(super) sum: &'a mut Equations,
    pub(super) pixels: &'a [ListedPixel],
    pub(super) model: &'a Model,
    pub(super) ready: &'a Ready,
    pub(super) profiles: &'a [Profile; 2],
    pub(super) crossing: &'a CrossingResponse,
    pub(super) active: usize,
}

impl Kernel for ListedSums<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { sum, pixels, model, ready, profiles, crossing, active } = self;
        let bent = ready.couplings(model);
        for chunk in pixels.chunks(CHUNK) {
            let columns = differentiate(chunk, model, ready, profiles, crossing, bent);
            let end = chunk.len().next_multiple_of(LANES);
            let columns = columns.each_ref().map(|column| &column[..end]);
            let difference = columns[PARAMETERS];
            for i in 0..active {
                sum.right[i] += dot(columns[i], difference);
                for j in 0..=i {
                    sum.normal[(i, j)] += dot(columns[i], columns[j]);
                }
            }
            sum.squares += dot(difference, difference);
        }
    }
}

/// What a model leaves of the pixels near both edges, each times the root of its weight.
pub(super) fn differences(
    window: &Window,
    model: &Model,
    profiles: &[Profile; 2],
    crossing: &CrossingResponse,
) -> Vec<f64> {
    let ready = Ready::new(model, profiles);
    let bent = ready.couplings(model);
    let chunk = |pixels| differentiate(pixels, model, &ready, profiles, crossing, bent)[PARAMETERS];
    window.listed.chunks(CHUNK).flat_map(chunk).collect()
}

/// How the blurs across both edges go together beyond what a model says, by least squares over its own parameters as well: the equations
/// of that number alone, its square and its right side, from a fit of at most so many parameters.
pub(super) fn skew_equation(
    window: &Window,
    model: &Model,
    (profiles, crossing): (&[Profile; 2], &CrossingResponse),
    Equations { normal, right, .. }: &Equations,
) -> Option<[f64; 2]> {
    // Sum up the products of its column, which is there near both edges only.
    let ready = Ready::new(model, profiles);
    let bent = ready.couplings(model);
    let scale = model.sigma_px[0] * model.sigma_px[1];
    let [_, _, _, a0, ax, ay] = model.light;
    let (mut by, mut square, mut own) = (Right::zeros(), 0.0, 0.0);
    for pixels in window.listed.chunks(CHUNK) {
        let columns = differentiate(pixels, model, &ready, profiles, crossing, bent);
        let [mut x, mut y] = [[0.0; CHUNK]; 2];
        pixels.iter().enumerate().for_each(|(i, pixel)| (x[i], y[i]) = (pixel.x, pixel.y));
        let (seen, _, _) = measured([&x, &y], model, &ready, profiles);
        let [[_, slope0, _], [_, slope1, _]] = &seen.edges;
        for i in 0..CHUNK {
            let skewed = columns[0][i] * (a0 + ax * x[i] + ay * y[i]) * scale * slope0[i] * slope1[i];
            (0..PARAMETERS).for_each(|k| by[k] += skewed * columns[k][i]);
            square += skewed * skewed;
            own += skewed * columns[PARAMETERS][i];
        }
    }

    // Take away what the other parameters explain.
    let explained = normal.cholesky()?.solve(&by);
    Some([square - by.dot(&explained), own - right.dot(&explained)])
}

/// Four lanes, summed in a fixed order.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0f64; LANES];
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// Both edges as pixels at `x` and `y` see them without their leans, the derivatives of their distances by the edges' angles, and by what
/// share the leans have grown there.
#[inline(always)]
fn measured(
    [x, y]: [&Column; 2],
    model: &Model,
    ready: &Ready,
    profiles: &[Profile; 2],
) -> (SeenEdges, [Column; 2], [Column; 2]) {
    let mut seen =
        SeenEdges { distances: [[0.0; CHUNK]; 2], normals: [[[0.0; CHUNK]; 2]; 2], edges: [[[0.0; CHUNK]; 3]; 2] };
    let [mut turned, mut growth] = [[[0.0; CHUNK]; 2]; 2];
    for k in 0..2 {
        let (normal, tangent) = (ready.normals[k], ready.tangents[k]);
        for i in 0..CHUNK {
            let (dx, dy) = (x[i] - model.corner.x, y[i] - model.corner.y);
            let along = tangent.x * dx + tangent.y * dy;
            let across = normal.x * dx + normal.y * dy;
            let bend = model.curvature[k] * along;
            seen.distances[k][i] = across + 0.5 * bend * along + ready.shifts_px[k];
            seen.normals[k][0][i] = normal.x + tangent.x * bend;
            seen.normals[k][1][i] = normal.y + tangent.y * bend;
            turned[k][i] = along - bend * across;
            growth[k][i] = along * model.lean_rates[k];
        }
        seen.edges[k] = ready.seen(&profiles[k], &seen.distances[k]);
    }
    (seen, turned, growth)
}

/// For each pixel the derivatives of the model by every parameter, and last the difference picture - model, all
/// times the root of the pixel's weight; zeros beyond the last pixel.
#[inline(always)]
fn differentiate(
    pixels: &[ListedPixel],
    model: &Model,
    ready: &Ready,
    profiles: &[Profile; 2],
    crossing: &CrossingResponse,
    bent: [f64; 2],
) -> [Column; PARAMETERS + 1] {
    // Spread the pixels out; beyond the last all weigh nothing.
    let [mut x, mut y, mut value, mut weight] = [[0.0; CHUNK]; 4];
    for (i, pixel) in pixels.iter().enumerate() {
        (x[i], y[i], value[i], weight[i]) = (pixel.x, pixel.y, pixel.value, pixel.root_weight);
    }

    let (seen, turned, growth) = measured([&x, &y], model, ready, profiles);

    // Evaluate the pattern, and its derivatives by the two distances.
    let mut patterns = crossing.patterns(&seen, pixels.len());
    if ready.steps_px != [0.0; 2] {
        patterns = ready.leaning(profiles, &seen, &growth, &patterns);
    }

    // Write the derivatives by light, corner, directions and blurs, and the difference.
    let [m0, mx, my, a0, ax, ay] = model.light;
    let [[e0, slope0, bend0], [e1, slope1, bend1]] = &seen.edges;
    let [n0, n1] = &seen.normals;
    let mut columns = [[0.0; CHUNK]; PARAMETERS + 1];
    for i in 0..CHUNK {
        let w = weight[i];
        let pattern = patterns.values[i] + bent[0] * slope0[i] * bend1[i] + bent[1] * bend0[i] * slope1[i];
        let contrast = (a0 + ax * x[i] + ay * y[i]) * w;
        let [by0, by1] = [contrast * patterns.by_distance[0][i], contrast * patterns.by_distance[1][i]];
        let light = m0 + mx * x[i] + my * y[i];
        let lit = w * pattern;
        let all = [
            w,
            w * x[i],
            w * y[i],
            lit,
            lit * x[i],
            lit * y[i],
            -(by0 * n0[0][i] + by1 * n1[0][i]),
            -(by0 * n0[1][i] + by1 * n1[1][i]),
            by0 * turned[0][i],
            by1 * turned[1][i],
            0.5 * contrast * bend0[i] * e1[i],
            0.5 * contrast * bend1[i] * e0[i],
            w * (value[i] - light) - contrast * pattern,
        ];
        for (column, value) in columns.iter_mut().zip(all) {
            column[i] = value;
        }
    }
    columns
}
