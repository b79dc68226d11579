//! The normal equations of the corner fit: pixels near both edges one by one, strips and flat parts by their sums.

use super::corner_model::{LIGHT, Model, PARAMETERS, Right};
use super::crossing::CrossingResponse;
use super::equation_sums::{Equations, Normal};
use super::listed::{ListedSums, Ready};
use super::pixel_sums::PixelSums;
use super::profile::Profile;
use super::strip::{EdgeModel, EdgeStrip, StripSums, strip_sums};
use super::window::Window;
use crate::num::simd::widest;

/// The equations over the first `active` parameters; the others stand still.
pub(super) fn equations(
    window: &Window,
    model: &Model,
    (profiles, crossing): (&[Profile; 2], &CrossingResponse),
    active: usize,
) -> Equations {
    // Clear the sums; parameters that stand still keep the identity.
    let ready = Ready::new(model, profiles);
    let mut sum = Equations { normal: Normal::identity(), right: Right::zeros(), squares: 0.0 };
    for i in 0..active {
        sum.normal[(i, i)] = 0.0;
    }

    // Add the pixels near both edges.
    widest(ListedSums { sum: &mut sum, pixels: &window.listed, model, ready: &ready, profiles, crossing, active });

    // Add the strips and the flat parts by their sums.
    let edges = ready_models(&ready, model, profiles, active == PARAMETERS);
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
    ready_models(&Ready::new(model, profiles), model, profiles, free_blur)
}

fn ready_models<'a>(ready: &Ready, model: &Model, profiles: &'a [Profile; 2], free_blur: bool) -> [EdgeModel<'a>; 2] {
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
