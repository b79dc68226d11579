//! The fit of one corner: two curved, blurred edges seen by square pixels under light that varies linearly.
//!
//! With r the pixel's centre from the corner, and for each edge k its normal n, tangent t and curvature kappa,
//!
//! ```text
//! d_k = n.r + kappa/2 ((t.r)^2 + s_k^2 + 1/12)         signed distance, with what blur and pixel do to a bent edge
//! p   = mean of sign(d_0) sign(d_1)                   E0 E1 and a correction where both edges are near (`crossing`)
//! I   = (m0 + mx x + my y) + (A0 + Ax x + Ay y) p
//! ```
//!
//! solved by Gauss-Newton over the corner, the two directions, the six numbers of the light and, where it is asked
//! for, the two blurs. The curvatures come from the grid: left free they would cost half as much error again.

use super::crossing::{Crossing, Pattern, Side};
use super::gauss::Gauss;
use super::profile::{Edge, Profile, SHARP_PX, Shape};
use super::window::{Sums, Window};
use glam::{DMat2, DVec2};
use nalgebra::{SMatrix, SVector};

/// Light, corner, directions, blurs.
const PARAMETERS: usize = 12;
/// How many of them are solved for when the blurs are held.
const WITHOUT_BLUR: usize = 10;
/// How many of them are the light's.
const LIGHT: usize = 6;
/// Where along an edge its turning is judged, in px from the corner.
const ARM_PX: f64 = 10.0;
/// Pixels that are worked on together.
const CHUNK: usize = 64;
/// The variance of a unit pixel in any direction, in px^2.
const PIXEL_VARIANCE: f64 = 1.0 / 12.0;

type Normal = SMatrix<f64, PARAMETERS, PARAMETERS>;
type Right = SVector<f64, PARAMETERS>;

/// A model of a corner; positions from the window's centre.
#[derive(Debug, Clone, Copy)]
pub(super) struct Model {
    /// The corner, in px.
    pub(super) corner: DVec2,
    /// Angle of each edge's normal, in rad.
    pub(super) normal_rad: [f64; 2],
    /// Bend of each edge, in 1/px.
    pub(super) curvature: [f64; 2],
    /// Blur across each edge, in px.
    pub(super) sigma_px: [f64; 2],
    /// m0, mx, my, A0, Ax, Ay; with A0 = 0 a fit finds its own start.
    pub(super) light: [f64; LIGHT],
}

impl Model {
    /// The same model, with positions from its corner.
    pub(super) fn about_corner(&self) -> Self {
        let [m0, mx, my, a0, ax, ay] = self.light;
        let DVec2 { x, y } = self.corner;
        let light = [m0 + mx * x + my * y, mx, my, a0 + ax * x + ay * y, ax, ay];
        Self { corner: DVec2::ZERO, light, ..*self }
    }

    /// Adds a step, shortened where it would leave the range of the linear model; how far the corner moved, or an edge at
    /// [`ARM_PX`] from it, or how much a blur changed, in px.
    fn advance(&mut self, step: &Right, effort: &Effort) -> f64 {
        self.light.iter_mut().zip(step.iter()).for_each(|(v, s)| *v += s);
        let shift = DVec2::new(step[6], step[7]).clamp_length_max(1.0);
        self.corner += shift;
        let mut moved = shift.length().max(ARM_PX * step[8].abs().max(step[9].abs()));
        for k in 0..2 {
            self.normal_rad[k] += step[8 + k].clamp(-0.2, 0.2);
            if effort.free_blur {
                let sigma = self.sigma_px[k];
                let wanted = sigma + step[10 + k].clamp(-0.5 * sigma, sigma);
                self.sigma_px[k] = wanted.min(effort.most_sigma_px).max(SHARP_PX);
                moved = moved.max((self.sigma_px[k] - sigma).abs());
            }
        }
        moved
    }
}

/// A fitted corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    /// The best model.
    pub(super) model: Model,
    /// Covariance of the corner, in px^2.
    pub(super) covariance_px2: DMat2,
    /// Root of the weighted mean square difference between picture and model, in the unit of the picture.
    pub(super) residual: f64,
    /// The last step, in px.
    pub(super) last_step_px: f64,
}

/// What is solved for, and for how long.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Whether the two blurs are solved for.
    pub(super) free_blur: bool,
    /// Gauss-Newton steps at most.
    pub(super) steps: usize,
    /// Stop when a step of the corner, of the edges at [`ARM_PX`], and of free blurs is below this, in px.
    pub(super) tolerance_px: f64,
    /// The largest blur that is believed, in px.
    pub(super) most_sigma_px: f64,
}

/// The profiles of both edges: tables for held blurs, the error function for free ones.
enum Profiles {
    Held([Profile; 2]),
    Free(Gauss, [Shape; 2]),
}

impl Profiles {
    fn new(model: &Model, free: bool) -> Self {
        let normals = model.normal_rad.map(unit);
        if free {
            Self::Free(Gauss::new(), [0, 1].map(|k| Shape::new(normals[k], model.sigma_px[k].max(SHARP_PX))))
        } else {
            Self::Held([0, 1].map(|k| Profile::new(normals[k], model.sigma_px[k])))
        }
    }

    fn are_sharp(&self) -> bool {
        matches!(self, Self::Held([Profile::Sharp(_), Profile::Sharp(_)]))
    }

    #[inline(always)]
    fn at(&self, k: usize, d: f64) -> (Edge, f64) {
        match self {
            Self::Held(profiles) => (profiles[k].at(d), 0.0),
            Self::Free(gauss, shapes) => shapes[k].exact(*gauss, d),
        }
    }
}

fn unit(angle: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(angle);
    DVec2::new(cos, sin)
}

/// Fits a corner, or `None` where the pixels do not determine one.
pub(super) fn fit(window: &Window, start: &Model, effort: &Effort) -> Option<Fit> {
    let mut model = *start;
    let active = if effort.free_blur { PARAMETERS } else { WITHOUT_BLUR };
    let mut profiles = Profiles::new(&model, effort.free_blur);
    if model.light[3] == 0.0 {
        model.light = first_light(window, &model, &profiles)?;
    }
    let left = window.weight - active as f64;
    if left <= 0.0 {
        return None;
    }
    for number in 1..=effort.steps {
        let (normal, right, squares) = equations(window, &model, &profiles, active);
        let factor = normal.cholesky()?;
        let step = factor.solve(&right);
        if step.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let last_step_px = model.advance(&step, effort);
        if last_step_px < effort.tolerance_px || number == effort.steps {
            // The sum of squares after the step, as the linear model foretells it.
            let variance = ((squares - step.dot(&right)) / left).max(0.0);
            let column = |i: usize| factor.solve(&Right::from_fn(|k, _| f64::from(u8::from(k == i))));
            let (x, y) = (column(6), column(7));
            let covariance_px2 = DMat2::from_cols_array(&[x[6], x[7], x[7], y[7]]) * variance;
            return Some(Fit { model, covariance_px2, residual: variance.sqrt(), last_step_px });
        }
        // A sharp profile costs nothing and depends strongly on the direction of an edge along the pixels.
        if effort.free_blur || profiles.are_sharp() {
            profiles = Profiles::new(&model, effort.free_blur);
        }
    }
    None
}

/// The light to start from: the levels of the flat parts, or where there is hardly a flat part the best for the edges.
fn first_light(window: &Window, model: &Model, profiles: &Profiles) -> Option<[f64; LIGHT]> {
    let [bright, dark] = [0, 1].map(|k| (window.flat[k].light[0], window.flat[k].moments[0]));
    if bright.1.min(dark.1) > 0.1 * window.weight {
        let (bright, dark) = (bright.0 / bright.1, dark.0 / dark.1);
        if bright != dark {
            return Some([0.5 * (bright + dark), 0.0, 0.0, 0.5 * (bright - dark), 0.0, 0.0]);
        }
    }
    let dark_model = Model { light: [0.0; LIGHT], ..*model };
    let (normal, right, _) = equations(window, &dark_model, profiles, LIGHT);
    let solved = normal.cholesky()?.solve(&right);
    Some(std::array::from_fn(|i| solved[i]))
}

/// The normal matrix, the right side and the weighted sum of squared differences at a model, over the first `active`
/// parameters; the others stand still.
fn equations(window: &Window, model: &Model, profiles: &Profiles, active: usize) -> (Normal, Right, f64) {
    let mut normal = Normal::identity();
    let mut right = Right::zeros();
    for i in 0..active {
        normal[(i, i)] = 0.0;
    }
    let mut squares = 0.0;
    let mut columns = [[0.0f64; CHUNK]; PARAMETERS + 1];
    for chunk in window.listed.chunks(CHUNK) {
        differentiate(chunk, model, profiles, &mut columns);
        // A last chunk that is not full would carry old values.
        columns.iter_mut().for_each(|c| c[chunk.len()..].fill(0.0));
        let difference = &columns[PARAMETERS];
        for i in 0..active {
            right[i] += dot(&columns[i], difference);
            for j in 0..=i {
                normal[(i, j)] += dot(&columns[i], &columns[j]);
            }
        }
        squares += dot(difference, difference);
    }
    for (sums, sign) in window.flat.iter().zip([1.0, -1.0]) {
        add_flat(sums, sign, &model.light, &mut normal, &mut right, &mut squares);
    }
    for i in 0..active {
        for j in 0..i {
            normal[(j, i)] = normal[(i, j)];
        }
    }
    (normal, right, squares)
}

/// Four lanes, summed in a fixed order.
#[inline(always)]
fn dot(a: &[f64; CHUNK], b: &[f64; CHUNK]) -> f64 {
    let mut sums = [0.0f64; 4];
    for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
        for lane in 0..4 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// For each pixel the derivatives of the model by every parameter, and last the difference picture - model, all
/// times the root of the pixel's weight.
fn differentiate(
    pixels: &[super::window::Listed],
    model: &Model,
    profiles: &Profiles,
    columns: &mut [[f64; CHUNK]; PARAMETERS + 1],
) {
    let normals = model.normal_rad.map(unit);
    let tangents = normals.map(DVec2::perp);
    let [s0, s1] = model.sigma_px;
    let crossing = Crossing::new(normals, model.sigma_px);
    // E over a Gaussian x of x^2 sign(d + x) is s^2 E + s^4 E'': the second part is what the mean shift leaves out
    // where the other edge is near. (For a sharp picture s^4 is nothing.)
    let cross = normals[0].perp_dot(normals[1]);
    let bent = [
        0.5 * model.curvature[0] * cross * cross * s1 * s1 * s1 * s1,
        0.5 * model.curvature[1] * cross * cross * s0 * s0 * s0 * s0,
    ];
    let shift = [0, 1].map(|k| 0.5 * model.curvature[k] * (model.sigma_px[k] * model.sigma_px[k] + PIXEL_VARIANCE));
    let [m0, mx, my, a0, ax, ay] = model.light;
    for (lane, pixel) in pixels.iter().enumerate() {
        let r = DVec2::new(pixel.x, pixel.y) - model.corner;
        let edge = |k: usize| {
            let (along, across) = (tangents[k].dot(r), normals[k].dot(r));
            let bend = model.curvature[k] * along;
            let distance = across + 0.5 * bend * along + shift[k];
            let (edge, by_sigma) = profiles.at(k, distance);
            let by_corner = -(normals[k] + tangents[k] * bend);
            let side = Side { edge, distance, normal: -by_corner };
            (side, by_sigma, by_corner, along - bend * across)
        };
        let (side0, sigma0, corner0, angle0) = edge(0);
        let (side1, sigma1, corner1, angle1) = edge(1);
        let (e0, e1) = (side0.edge, side1.edge);
        let Pattern { value, by_distance } = crossing.pattern(&[side0, side1]);
        let pattern = value + bent[0] * e0.slope * e1.bend + bent[1] * e0.bend * e1.slope;
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
            contrast * sigma0 * e1.value,
            contrast * sigma1 * e0.value,
            w * (pixel.value - light) - contrast * pattern,
        ];
        for (out, value) in columns.iter_mut().zip(column) {
            out[lane] = value;
        }
    }
}

/// Adds pixels where the pattern is `sign` everywhere.
fn add_flat(sums: &Sums, sign: f64, light: &[f64; LIGHT], normal: &mut Normal, right: &mut Right, squares: &mut f64) {
    let [n, x, y, xx, xy, yy] = sums.moments;
    let moments = [[n, x, y], [x, xx, xy], [y, xy, yy]];
    let level: [f64; 3] = std::array::from_fn(|i| light[i] + sign * light[i + 3]);
    *squares += sums.square;
    for i in 0..3 {
        let modelled: f64 = (0..3).map(|j| moments[i][j] * level[j]).sum();
        *squares += level[i] * (modelled - 2.0 * sums.light[i]);
        right[i] += sums.light[i] - modelled;
        right[i + 3] += sign * (sums.light[i] - modelled);
        for j in 0..3 {
            normal[(i, j)] += moments[i][j];
            normal[(i + 3, j)] += sign * moments[i][j];
            normal[(i + 3, j + 3)] += moments[i][j];
        }
    }
}
