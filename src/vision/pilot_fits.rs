//! Fits of some corners from which the kind of the blur is told, and what they leave.

use super::blur::FIRST_MARGIN_PX;
use super::blur_shape::PictureBlur;
use super::candidates::Candidates;
use super::corner_fit::{CornerFit, fit, profiles};
use super::corner_model::{Effort, Model};
use super::corner_site::CornerSite;
use super::crossing::CrossingResponse;
use super::equations::edge_models;
use super::listed::differences;
use super::settings::Settings;
use super::strip::left_of;
use super::window::{Window, gather};
use rayon::prelude::*;

/// A pilot's pixels and its fit; `None` where there is none.
pub(super) type PilotFit = Option<(Window, CornerFit)>;

pub(super) const EFFORT: Effort =
    Effort { free_blur: false, steps: 8, tolerance_px: 1e-3, most_sigma_px: f64::INFINITY };

/// Fits corners in full windows under a blur, the pixels near an edge chosen for so many px beside its Gaussian.
pub(super) fn fit_pilots(
    candidates: &Candidates<'_>,
    sites: &[CornerSite],
    settings: &Settings,
    blur: &PictureBlur,
    reach_px: [f64; 2],
) -> Vec<PilotFit> {
    let one = |site: &CornerSite| {
        let half = site.half(settings.window, blur);
        let frame = site.frame_reaching(blur, half, FIRST_MARGIN_PX, reach_px);
        let window = gather(candidates.image, candidates.valid.as_ref(), &frame);
        let fit = fit(&window, &site.model(blur, settings.light), &EFFORT)?;
        Some((window, fit))
    };
    sites.par_iter().map(one).collect()
}

/// A pilot's pixels, and a fit of them.
pub(super) type FittedPixels<'a> = Option<(&'a Window, &'a CornerFit)>;

/// Fits pixels again under another blur, from where fits ended.
pub(super) fn fit_again(from: &[FittedPixels<'_>], blur: &PictureBlur, effort: &Effort) -> Vec<Option<CornerFit>> {
    let one = |before: &FittedPixels<'_>| {
        let (window, CornerFit { model, .. }) = (*before)?;
        let PictureBlur { sigma_px, shapes, half_way_px } = *blur;
        let skew = blur.skew(model.skew);
        fit(window, &Model { sigma_px, shapes, half_way_px, skew, ..*model }, effort)
    };
    from.par_iter().map(one).collect()
}

/// The sum of the squares that fits leave, in units of their contrasts.
pub(super) fn squares<'a>(fits: impl Iterator<Item = &'a CornerFit>) -> f64 {
    let share = |fit: &CornerFit| fit.residual / fit.model.light[3];
    fits.map(|fit| share(fit) * share(fit)).sum()
}

/// What a model leaves of a window near its edges, each pixel times the root of its weight.
pub(super) fn leavings(window: &Window, model: &Model) -> Vec<f64> {
    let seen_as = profiles(model);
    let mut all = differences(window, model, &seen_as, &CrossingResponse::of(model));
    for (strip, edge) in window.strips.iter().zip(&edge_models(model, &seen_as, false)) {
        for pixels in strip.chunks() {
            let [_, _, left] = left_of(pixels, model, edge);
            all.extend(left.iter().zip(&pixels[3]).map(|(left, weight)| left * weight.sqrt()));
        }
    }
    all
}
