//! The fit of one corner by Gauss-Newton: two curved, blurred edges seen by square pixels under light that varies
//! linearly.
//!
//! With r the pixel's centre from the corner, and for each edge k its normal n, tangent t and curvature kappa,
//!
//! ```text
//! d_k = n.r + kappa/2 ((t.r)^2 + s_k^2 + 1/12) + g_k    signed distance, with what blur and pixel do to a bent edge
//!                                                     and in light that varies (`equations`)
//! p   = mean of sign(d_0) sign(d_1)                   E0 E1 and a correction where both edges are near (`corner_pixel_model`)
//! I   = (m0 + mx x + my y) + (A0 + Ax x + Ay y) p
//! ```
//!
//! solved over the corner, the two directions, the six numbers of the light and, where they are free, the two blurs.
//! The curvatures come from the lattice: left free they would cost half as much error again.

use super::corner_model::{Effort, LIGHT, Model, PARAMETERS, Right, WITHOUT_BLUR};
use super::crossing::CrossingResponse;
use super::edge_spread::EdgeShape;
use super::equation_sums::Equations;
use super::equations::equations;
use super::profile::Profile;
use super::window::Window;
use glam::DMat2;

/// A fit that takes more steps than these may go to and fro between two places, as where a mosaic of colours lies over the edges:
/// from then on half of each step is taken.
const WHOLE_STEPS: usize = 12;

/// A fitted corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct CornerFit {
    /// The best model.
    pub(super) model: Model,
    /// Covariance of the corner, in px^2.
    pub(super) covariance_px2: DMat2,
    /// Root of the weighted mean square difference between picture and model, in the unit of the picture.
    pub(super) residual: f64,
    /// The last step, in px.
    pub(super) last_step_px: f64,
}

/// The profiles of both edges.
pub(super) fn profiles(model: &Model) -> [Profile; 2] {
    let normals = model.normals();
    [0, 1].map(|k| {
        let shape = EdgeShape::moved(normals[k], model.sigma_px[k], model.half_way_px);
        Profile::shaped(shape, &model.shapes[k])
    })
}

/// Fits a corner, or `None` where the pixels do not determine one.
pub(super) fn fit(window: &Window, start: &Model, effort: &Effort) -> Option<CornerFit> {
    // Start from the given model, with light of its own where none is known.
    let mut model = *start;
    let active = if effort.free_blur { PARAMETERS } else { WITHOUT_BLUR };
    let mut ready = profiles(&model);
    let mut crossing = CrossingResponse::of(&model);
    if model.light[3] == 0.0 {
        model.light = first_light(window, &model, &ready, &crossing)?;
    }
    let left = window.weight - active as f64;
    if left <= 0.0 {
        return None;
    }

    // Take Gauss-Newton steps.
    for number in 1..=effort.steps {
        let Equations { normal, right, squares } = equations(window, &model, (&ready, &crossing), active);
        let factor = normal.cholesky()?;
        let step = factor.solve(&right);
        if step.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let last_step_px = model.advance(&if number > WHOLE_STEPS { 0.5 * step } else { step }, effort);

        // End with residual and covariance.
        if last_step_px < effort.tolerance_px || number == effort.steps {
            // The sum of squares after the step, as the linear model foretells it.
            let variance = ((squares - step.dot(&right)) / left).max(0.0);
            let column = |i: usize| factor.solve(&Right::from_fn(|k, _| f64::from(u8::from(k == i))));
            let (x, y) = (column(6), column(7));
            let covariance_px2 = DMat2::from_cols_array(&[x[6], x[7], x[7], y[7]]) * variance;
            return Some(CornerFit { model, covariance_px2, residual: variance.sqrt(), last_step_px });
        }

        // Follow the edges' directions and blurs with their profiles. A sharp one costs nothing and depends strongly on
        // the direction of an edge along the pixels.
        if effort.free_blur || matches!(ready, [Profile::Sharp(_), Profile::Sharp(_)]) {
            ready = profiles(&model);
            crossing = CrossingResponse::of(&model);
        }
    }
    None
}

/// The light to start from: the levels of the flat parts, or where there is hardly a flat part the best for the edges.
fn first_light(
    window: &Window,
    model: &Model,
    profiles: &[Profile; 2],
    crossing: &CrossingResponse,
) -> Option<[f64; LIGHT]> {
    let [bright, dark] = [0, 1].map(|k| (window.flat[k].light[0], window.flat[k].moments[0]));
    if bright.1.min(dark.1) > 0.1 * window.weight {
        let (bright, dark) = (bright.0 / bright.1, dark.0 / dark.1);
        if bright != dark {
            return Some([0.5 * (bright + dark), 0.0, 0.0, 0.5 * (bright - dark), 0.0, 0.0]);
        }
    }
    let dark_model = Model { light: [0.0; LIGHT], ..*model };
    let Equations { normal, right, .. } = equations(window, &dark_model, (profiles, crossing), LIGHT);
    let solved = normal.cholesky()?.solve(&right);
    Some(std::array::from_fn(|i| solved[i]))
}
