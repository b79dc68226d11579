//! The normal equations of the corner fit: pixels near both edges one by one, strips and flat parts by their sums.

use super::corner_model::{LIGHT, Model, PARAMETERS, Right};
use super::corner_pixel_model::{CornerPattern, CornerPixelModel, EdgeSide};
use super::edge_spread::Edge;
use super::pixel_sums::PixelSums;
use super::profile::Profile;
use super::strip::{EdgeModel, EdgeStrip, StripSums, strip_sums};
use super::window::{ListedPixel, Window};
use crate::num::simd::{Kernel, widest};
use glam::DVec2;
use nalgebra::SMatrix;

/// Pixels that are worked on together: few are near both edges.
const CHUNK: usize = 32;
/// Lanes of a sum over them.
const LANES: usize = 4;
/// The variance of a unit pixel in any direction, in px^2.
const PIXEL_VARIANCE: f64 = 1.0 / 12.0;

pub(super) type Normal = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// The normal matrix, the right side and the weighted sum of squared differences at a model.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    pub(super) normal: Normal,
    pub(super) right: Right,
    pub(super) squares: f64,
}

/// What of a model is the same for all pixels.
struct Ready {
    normals: [DVec2; 2],
    tangents: [DVec2; 2],
    /// What blur and pixel add to the distance from an edge that is bent, or lies in light that is not even, in px.
    shifts_px: [f64; 2],
    /// [`Model::steps_px`]
    steps_px: [f64; 2],
    /// Whether the profiles are not alike to both sides of an edge.
    uneven: bool,
    /// Whether the smaller squares are bright, 1, or dark, -1.
    smaller: f64,
}

impl Ready {
    fn new(model: &Model, profiles: &[Profile; 2]) -> Self {
        let normals = model.normal_rad.map(|angle| {
            let (sin, cos) = libm::sincos(angle);
            DVec2::new(cos, sin)
        });
        // A mean over a spread of variance v of a pattern p in light that varies by the share g is p + v g p', to first
        // order p shifted by v g.
        let [_, _, _, a0, ax, ay] = model.light;
        let share = if a0 == 0.0 { DVec2::ZERO } else { DVec2::new(ax, ay) / a0 };
        let shifts_px = [0, 1].map(|k| {
            let blur = model.sigma_px[k] * model.sigma_px[k];
            let spread = PIXEL_VARIANCE + if model.light_is_blurred { blur } else { 0.0 };
            0.5 * model.curvature[k] * (blur + PIXEL_VARIANCE) + spread * share.dot(normals[k])
        });
        let uneven = profiles.iter().any(|profile| !profile.is_even());
        let smaller = -model.leans_px[0].signum();
        Self { normals, tangents: normals.map(DVec2::perp), shifts_px, steps_px: model.steps_px(), uneven, smaller }
    }

    /// Edge `k` as a pixel `r` from the corner sees it without its lean, the derivatives of its distance by the corner and by its
    /// angle, and by what share the lean has grown there.
    #[inline(always)]
    fn edge_at(&self, model: &Model, profiles: &[Profile; 2], k: usize, r: DVec2) -> (EdgeSide, DVec2, f64, f64) {
        let (normal, tangent) = (self.normals[k], self.tangents[k]);
        let (along, across) = (tangent.dot(r), normal.dot(r));
        let bend = model.curvature[k] * along;
        let distance = across + 0.5 * bend * along + self.shifts_px[k];
        let by_corner = -(normal + tangent * bend);
        let side = EdgeSide { edge: self.seen(&profiles[k], distance), distance, normal: -by_corner };
        (side, by_corner, along - bend * across, along * model.lean_rates[k])
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

    /// The response to an edge at a distance, without its lean.
    #[inline(always)]
    fn seen(&self, profile: &Profile, distance: f64) -> Edge {
        if self.uneven { profile.odd(distance) } else { profile.at(distance) }
    }

    /// The pattern, and its derivatives by the two distances; by what share the leans have grown along the edges.
    #[inline(always)]
    fn pattern(
        &self,
        profiles: &[Profile; 2],
        sides: &[EdgeSide; 2],
        growth: [f64; 2],
        crossing: &CornerPixelModel,
    ) -> CornerPattern {
        if self.steps_px == [0.0; 2] {
            crossing.pattern(sides)
        } else {
            self.leaning(profiles, sides, growth, crossing)
        }
    }

    /// The pattern where both edges lean: the squares of the positive sign are larger by `steps_px` at both edges, or the others.
    ///
    /// Where they are larger, the pattern is 1 but for the two squares of the other sign, each the product of its two edges. The
    /// correction where both edges are near is that of the crossing without lean.
    #[inline(never)]
    fn leaning(
        &self,
        profiles: &[Profile; 2],
        sides: &[EdgeSide; 2],
        growth: [f64; 2],
        crossing: &CornerPixelModel,
    ) -> CornerPattern {
        // Take the correction.
        let plain = crossing.pattern(sides);
        let [e0, e1] = [sides[0].edge, sides[1].edge];
        let product = [e0.slope * e1.value, e0.value * e1.slope];

        // Add the share of the two squares that are smaller, and its derivatives by both distances: share and slope of one
        // edge on the side of `sign`, moved inwards.
        let part = |k: usize, sign: f64| {
            let inwards = sign * sides[k].distance - self.steps_px[k].abs() * (1.0 + growth[k]);
            let edge = if self.uneven { profiles[k].towards(inwards, self.smaller) } else { profiles[k].at(inwards) };
            [0.5 * (1.0 + edge.value), 0.5 * sign * edge.slope]
        };
        // Where the positive sign is larger, the smaller squares have the distances' signs apart.
        let other = if self.steps_px[0] > 0.0 { -1.0 } else { 1.0 };
        let [a0, a1, b0, b1] = [part(0, 1.0), part(1, other), part(0, -1.0), part(1, -other)];
        let share = a0[0] * a1[0] + b0[0] * b1[0];
        let by = [a0[1] * a1[0] + b0[1] * b1[0], a0[0] * a1[1] + b0[0] * b1[1]];
        CornerPattern {
            value: plain.value - e0.value * e1.value + other * (2.0 * share - 1.0),
            by_distance: [0, 1].map(|k| plain.by_distance[k] - product[k] + 2.0 * other * by[k]),
        }
    }
}

/// The equations over the first `active` parameters; the others stand still.
pub(super) fn equations(window: &Window, model: &Model, profiles: &[Profile; 2], active: usize) -> Equations {
    // Clear the sums; parameters that stand still keep the identity.
    let ready = Ready::new(model, profiles);
    let mut sum = Equations { normal: Normal::identity(), right: Right::zeros(), squares: 0.0 };
    for i in 0..active {
        sum.normal[(i, i)] = 0.0;
    }

    // Add the pixels near both edges.
    let mut columns = [[0.0f64; CHUNK]; PARAMETERS + 1];
    let crossing = CornerPixelModel::new(ready.normals, model.sigma_px, model.skew);
    for chunk in window.listed.chunks(CHUNK) {
        differentiate(chunk, model, &ready, profiles, &crossing, &mut columns);
        widest(ListedSums { sum: &mut sum, columns: &mut columns, count: chunk.len(), active });
    }

    // Add the strips and the flat parts by their sums.
    let edges = edge_models(model, profiles, active == PARAMETERS);
    for (k, (strip, edge)) in window.strips.iter().zip(&edges).enumerate() {
        add_strip(&mut sum, strip, model, edge, k, active);
    }
    for (sums, sign) in window.flat.iter().zip([1.0, -1.0]) {
        add_flat(&mut sum, sums, sign, &model.light);
    }

    // Mirror the lower triangle.
    for i in 0..active {
        for j in 0..i {
            sum.normal[(j, i)] = sum.normal[(i, j)];
        }
    }
    sum
}

/// Both edges of a model as their strips see them.
pub(super) fn edge_models<'a>(model: &Model, profiles: &'a [Profile; 2], free_blur: bool) -> [EdgeModel<'a>; 2] {
    let ready = Ready::new(model, profiles);
    [0, 1].map(|k| EdgeModel {
        profile: &profiles[k],
        normal: ready.normals[k],
        tangent: ready.tangents[k],
        curvature: model.curvature[k],
        shift_px: ready.shifts_px[k],
        step_px: ready.steps_px[k],
        step_rate: model.lean_rates[k],
        bright: if profiles[k].is_even() { 0.0 } else { model.light[3].signum() },
        free_blur,
    })
}

/// Adds the products of the first `count` places of the columns.
struct ListedSums<'a> {
    sum: &'a mut Equations,
    columns: &'a mut [[f64; CHUNK]; PARAMETERS + 1],
    count: usize,
    active: usize,
}

impl Kernel for ListedSums<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        // The last lanes that are not full would carry old values.
        let Self { sum, columns, count, active } = self;
        let end = count.next_multiple_of(LANES);
        columns.iter_mut().for_each(|c| c[count..end].fill(0.0));
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

/// For each pixel the derivatives of the model by every parameter, and last the difference picture - model, all
/// times the root of the pixel's weight.
fn differentiate(
    pixels: &[ListedPixel],
    model: &Model,
    ready: &Ready,
    profiles: &[Profile; 2],
    crossing: &CornerPixelModel,
    columns: &mut [[f64; CHUNK]; PARAMETERS + 1],
) {
    let bent = ready.couplings(model);

    // Differentiate pixel by pixel.
    let [m0, mx, my, a0, ax, ay] = model.light;
    for (lane, pixel) in pixels.iter().enumerate() {
        // Evaluate both edges at the pixel.
        let r = DVec2::new(pixel.x, pixel.y) - model.corner;
        let [(side0, corner0, angle0, growth0), (side1, corner1, angle1, growth1)] =
            [ready.edge_at(model, profiles, 0, r), ready.edge_at(model, profiles, 1, r)];

        // Evaluate the pattern, and its derivatives by the two distances.
        let (e0, e1) = (side0.edge, side1.edge);
        let growth = [growth0, growth1];
        let CornerPattern { value, by_distance } = ready.pattern(profiles, &[side0, side1], growth, crossing);
        let pattern = value + bent[0] * e0.slope * e1.bend + bent[1] * e0.bend * e1.slope;

        // Write the derivatives by light, corner, directions and blurs, and the difference.
        let w = pixel.root_weight;
        let contrast = (a0 + ax * pixel.x + ay * pixel.y) * w;
        let [by0, by1] = by_distance.map(|d| contrast * d);
        let light = m0 + mx * pixel.x + my * pixel.y;
        let column = [
            w,
            w * pixel.x,
            w * pixel.y,
            w * pattern,
            w * pattern * pixel.x,
            w * pattern * pixel.y,
            by0 * corner0.x + by1 * corner1.x,
            by0 * corner0.y + by1 * corner1.y,
            by0 * angle0,
            by1 * angle1,
            0.5 * contrast * e0.bend * e1.value,
            0.5 * contrast * e1.bend * e0.value,
            w * (pixel.value - light) - contrast * pattern,
        ];
        for (out, value) in columns.iter_mut().zip(column) {
            out[lane] = value;
        }
    }
}

/// The symmetric matrix of the 1, x, y moments in the order of [`PixelSums::moments`].
fn moments([n, x, y, xx, xy, yy]: [f64; 6]) -> [[f64; 3]; 3] {
    [[n, x, y], [x, xx, xy], [y, xy, yy]]
}

/// Adds a strip of pixels near edge `k` only.
fn add_strip(sum: &mut Equations, strip: &EdgeStrip, model: &Model, edge: &EdgeModel, k: usize, active: usize) {
    let sums = strip_sums(strip, model, edge);
    add_strip_light(sum, &strip.sums, &sums, &model.light);

    // Write corner, direction and blur as combinations of T, T t and the blur's column.
    let (n, bend) = (edge.normal, edge.tangent * model.curvature[k]);
    let combinations = [
        (LIGHT, [-n.x, -bend.x, 0.0]),
        (LIGHT + 1, [-n.y, -bend.y, 0.0]),
        (LIGHT + 2 + k, [0.0, 1.0, 0.0]),
        (LIGHT + 4 + k, [0.0, 0.0, 1.0]),
    ];
    let [t00, t01, t11, t20, t21, t22] = sums.squares;
    let square = [[t00, t01, t20], [t01, t11, t21], [t20, t21, t22]];
    let dot3 = |a: &[f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

    // Add the rows of those that are solved for, with the light and with each other.
    for &(row, ref own) in combinations.iter().filter(|(row, _)| *row < active) {
        let column: [f64; 7] = std::array::from_fn(|i| dot3(own, sums.turns.map(|t| t[i])));
        sum.right[row] += column[LIGHT] - times_light(&column[..LIGHT], &model.light);
        for (i, value) in column[..LIGHT].iter().enumerate() {
            sum.normal[(row, i)] += value;
        }
        let products = square.map(|line| dot3(own, line));
        for (other, combination) in combinations.iter().filter(|(other, _)| *other <= row) {
            sum.normal[(row, *other)] += dot3(combination, products);
        }
    }
}

/// Adds what a strip says of the light. The model is linear in it: the differences follow from the same sums.
fn add_strip_light(sum: &mut Equations, flat: &PixelSums, sums: &StripSums, light: &[f64; LIGHT]) {
    // Put the moments of 1, E and E^2 together.
    let mut own = [[0.0; LIGHT]; LIGHT];
    let blocks = [moments(flat.moments), moments(sums.edge), moments(sums.edge_squared)];
    for i in 0..3 {
        for j in 0..3 {
            own[i][j] = blocks[0][i][j];
            own[i + 3][j] = blocks[1][i][j];
            own[i][j + 3] = blocks[1][i][j];
            own[i + 3][j + 3] = blocks[2][i][j];
        }
    }

    // Add them to the equations.
    let picture = [flat.light, sums.edge_light].concat();
    sum.squares += flat.square;
    for i in 0..LIGHT {
        let modelled = times_light(&own[i], light);
        sum.squares += light[i] * (modelled - 2.0 * picture[i]);
        sum.right[i] += picture[i] - modelled;
        for (j, value) in own[i][..=i].iter().enumerate() {
            sum.normal[(i, j)] += value;
        }
    }
}

fn times_light(row: &[f64], light: &[f64; LIGHT]) -> f64 {
    row.iter().zip(light).map(|(a, b)| a * b).sum()
}

/// Adds pixels where the pattern is `sign` everywhere.
fn add_flat(sum: &mut Equations, sums: &PixelSums, sign: f64, light: &[f64; LIGHT]) {
    let moments = moments(sums.moments);
    let level: [f64; 3] = std::array::from_fn(|i| light[i] + sign * light[i + 3]);
    sum.squares += sums.square;
    for i in 0..3 {
        let modelled: f64 = moments[i].iter().zip(level).map(|(m, l)| m * l).sum();
        sum.squares += level[i] * (modelled - 2.0 * sums.light[i]);
        sum.right[i] += sums.light[i] - modelled;
        sum.right[i + 3] += sign * (sums.light[i] - modelled);
        for (j, moment) in moments[i].into_iter().enumerate() {
            sum.normal[(i, j)] += moment;
            sum.normal[(i + 3, j)] += sign * moment;
            sum.normal[(i + 3, j + 3)] += moment;
        }
    }
}
