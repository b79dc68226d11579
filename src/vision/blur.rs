//! Blur estimation: the median of fits of some corners in which the blur is free.

use super::blur_shape::PictureBlur;
use super::candidates::Candidates;
use super::corner_fit::{CornerFit, fit};
use super::corner_model::Effort;
use super::corner_site::CornerSite;
use super::settings::Settings;
use crate::num::stats::quantile;
use rayon::prelude::*;

/// The blur that a fit starts from, in px.
pub(super) const FIRST_SIGMA_PX: f64 = 0.7;
/// Of the corners that may be fitted so many are at first; where these agree, as without noise, they are enough.
const FIRST: usize = 6;
/// One of so many is fitted again where the blur is known nearly.
const AGAIN_OF: usize = 2;
/// They agree when the middle half of their blurs lies within this share of the median.
const AGREEMENT: f64 = 0.01;
/// Median blurs below this, in px, may come from a sharp picture; the residual decides.
pub(super) const MAYBE_SHARP_PX: f64 = 0.3;
/// Half the window of a first fit, and the blur that the pixels near an edge are chosen for, in px: a wider one needs a
/// wider window.
const HALF_PX: f64 = 12.0;
const NEAR_SIGMA_PX: f64 = 1.2;
/// How often a blur that is wider than was thought is estimated again.
const ROUNDS: usize = 4;
/// A fit is done when corner, edges and blurs move by less than this, in px.
const STEP_PX: f64 = 1e-3;
/// The same, and the steps at most, where a sharp picture is told from a narrow blur: without blur an edge on the border
/// of its pixels comes nearer by a share at each step only, and what is left of its way would count against it.
const SHARP_STEP_PX: f64 = 1e-5;
const SHARP_STEPS: usize = 20;
/// One of two blurs leaves clearly less where the other leaves so many times as much: with noise both leave nearly the same.
const CLEARLY: f64 = 2.0;
/// The second of two blurs leaves less where what n corners leave under it is less by this share over n: some 200 pixels of each
/// corner tell of it, so that noise or rounding alone make such a difference of 20 between sums of squares rarely.
const LESS: f64 = 0.1;

/// Blurs that are held, and where one of them may be none.
const HELD: Effort = Effort { free_blur: false, ..FREE };
const SHARP: Effort = Effort { steps: SHARP_STEPS, tolerance_px: SHARP_STEP_PX, ..HELD };
/// Free blurs.
const FREE: Effort = Effort { free_blur: true, steps: 15, tolerance_px: STEP_PX, most_sigma_px: f64::INFINITY };

/// Fits of some corners with free blurs in windows of a few px.
pub(super) type FirstFits = Vec<Option<CornerFit>>;

/// [`FirstFits`] of [`some_of`] the corners.
pub(super) fn first_fits(candidates: &Candidates<'_>, sites: &[CornerSite], settings: &Settings) -> FirstFits {
    fits(candidates, &some_of(sites), settings, HALF_PX, [[FIRST_SIGMA_PX; 2], [NEAR_SIGMA_PX; 2]], &FREE)
}

/// The corners that are fitted at first.
pub(super) fn some_of(sites: &[CornerSite]) -> Vec<CornerSite> {
    sites.iter().copied().step_by(sites.len().div_ceil(FIRST).max(1)).collect()
}

/// The corners that are not among these.
fn others(sites: &[CornerSite]) -> Vec<CornerSite> {
    let stride = sites.len().div_ceil(FIRST).max(1);
    sites.iter().enumerate().filter(|(k, _)| k % stride != 0).map(|(_, site)| *site).collect()
}

/// Whether windows of a few px show the blur of these whole.
pub(super) fn is_narrow(first: &FirstFits) -> bool {
    summary(first).is_some_and(|(sigma, _)| sigma[0].max(sigma[1]) < NEAR_SIGMA_PX)
}

/// The blur across the column and the row lines, in px: medians over the corners at `sites`, of which [`first_fits`] were made.
/// `None` where no corner could be fitted.
pub(super) fn estimate(
    candidates: &Candidates<'_>,
    sites: &[CornerSite],
    settings: &Settings,
    first: FirstFits,
) -> Option<[f64; 2]> {
    // Where some corners agree, they are enough; where windows of a few px are, the others are fitted in these too.
    let (few, rest) = (some_of(sites), others(sites));
    let (told, mut agree) = summary(&first)?;
    let sigma = if !is_narrow(&first) {
        let (wide, alike) = medians(candidates, &few, settings, told)?;
        agree = alike;
        if agree { wide } else { medians(candidates, sites, settings, wide)?.0 }
    } else if agree || rest.is_empty() {
        told
    } else {
        let mut all = first;
        all.extend(fits(candidates, &rest, settings, HALF_PX, [told, [NEAR_SIGMA_PX; 2]], &FREE));
        if is_narrow(&all) { summary(&all)?.0 } else { medians(candidates, sites, settings, summary(&all)?.0)?.0 }
    };
    let sharp = sigma.map(|sigma| if sigma < MAYBE_SHARP_PX { 0.0 } else { sigma });
    if sharp == sigma {
        return Some(sigma);
    }

    // See whether the picture is sharp, across one family of lines at least: what a fit says of a blur that is next to none hangs on
    // the last bits of the picture.
    let rest = if agree { Vec::new() } else { rest };
    Some(better(candidates, [&few, &rest], settings, [sharp, sigma], &SHARP))
}

/// The blur again, where it is known nearly, and clearly no sharp picture's: that of the two under which the fits leave less.
pub(super) fn estimate_again(
    candidates: &Candidates<'_>,
    sites: &[CornerSite],
    settings: &Settings,
    known: [f64; 2],
) -> [f64; 2] {
    let some: Vec<CornerSite> = sites.iter().copied().step_by(AGAIN_OF).collect();
    let found = medians(candidates, &some, settings, known);
    found.map_or(known, |(found, _)| better(candidates, [&some, &[]], settings, [found, known], &HELD))
}

/// That of two blurs under which the fits of corners leave less; the first where they leave nearly the same. Where some corners leave far
/// less under one of both, the rest of them are not asked.
fn better(
    candidates: &Candidates<'_>,
    [some, rest]: [&[CornerSite]; 2],
    settings: &Settings,
    [first, second]: [[f64; 2]; 2],
    effort: &Effort,
) -> [f64; 2] {
    let squares = |sites: &[CornerSite], sigma: [f64; 2]| -> f64 {
        let fits = fits(candidates, sites, settings, HALF_PX, [sigma, sigma], effort);
        fits.iter().flatten().map(|f| f.residual * f.residual).sum()
    };
    let [mut left, mut other] = [first, second].map(|sigma| squares(some, sigma));
    let mut corners = some.len();
    if left.max(other) < CLEARLY * left.min(other) {
        left += squares(rest, first);
        other += squares(rest, second);
        corners += rest.len();
    }
    if (1.0 - LESS / corners.max(1) as f64) * left <= other { first } else { second }
}

/// Fits corners with free blurs from these, in their whole windows: the mean square that they leave, and the medians of their blurs.
/// `None` where half of them cannot be fitted.
pub(super) fn free_fits(
    candidates: &Candidates<'_>,
    sites: &[CornerSite],
    settings: &Settings,
    sigma: [f64; 2],
) -> Option<(f64, [f64; 2])> {
    let near_px = 1.2 * sigma[0].max(sigma[1]);
    let fits = fits(candidates, sites, settings, f64::INFINITY, [sigma, [near_px; 2]], &FREE);
    let found: Vec<&CornerFit> = fits.iter().flatten().collect();
    let squares = found.iter().map(|f| f.residual * f.residual).sum::<f64>() / found.len() as f64;
    let median = |k: usize| quantile(&found.iter().map(|f| f.model.sigma_px[k]).collect::<Vec<_>>(), 0.5);
    (2 * found.len() >= sites.len()).then_some((squares, [median(0)?, median(1)?]))
}

/// Fits corners in windows of at most `half_px` to each side, from the first of two blurs, the pixels near an edge
/// chosen for the second.
fn fits(
    candidates: &Candidates<'_>,
    sites: &[CornerSite],
    settings: &Settings,
    half_px: f64,
    [start, near]: [[f64; 2]; 2],
    effort: &Effort,
) -> FirstFits {
    let run = |site: &CornerSite| {
        let half = settings.window.min(half_px / site.step_px());
        let pixels = site.window(candidates, &site.frame(&PictureBlur::gaussian(near), half, FIRST_MARGIN_PX));
        fit(
            &pixels,
            &site.model(&PictureBlur::gaussian(start), settings.light),
            &Effort { most_sigma_px: 0.5 * site.step_px(), ..*effort },
        )
    };
    sites.par_iter().map(run).collect()
}

/// The medians of the blurs of free fits, and whether the quartiles agree with them; `None` where there is no fit.
fn summary(fits: &FirstFits) -> Option<([f64; 2], bool)> {
    let (mut sigma, mut agree) = ([0.0; 2], true);
    for (k, sigma) in sigma.iter_mut().enumerate() {
        let found: Vec<f64> = fits.iter().flatten().map(|f| f.model.sigma_px[k]).collect();
        let [low, middle, high] = [0.25, 0.5, 0.75].map(|q| quantile(&found, q));
        *sigma = middle?;
        agree &= high? - low? <= AGREEMENT * *sigma;
    }
    Some((sigma, agree))
}

/// The medians of the blurs of free fits that start from `sigma`, and whether the fits agree.
fn medians(
    candidates: &Candidates<'_>,
    sites: &[CornerSite],
    settings: &Settings,
    mut sigma: [f64; 2],
) -> Option<([f64; 2], bool)> {
    // Start from a window that suits the blur.
    let mut agree = false;
    let (mut half_px, mut near_px) = if sigma[0].max(sigma[1]) < NEAR_SIGMA_PX {
        (HALF_PX, NEAR_SIGMA_PX)
    } else {
        (f64::INFINITY, 2.0 * sigma[0].max(sigma[1]))
    };
    for _ in 0..ROUNDS {
        // Fit the corners with free blurs.
        let fits = fits(candidates, sites, settings, half_px, [sigma, [near_px; 2]], &FREE);

        (sigma, agree) = summary(&fits)?;

        // Widen the window where the blur turns out wider than it was chosen for.
        let widest = sigma[0].max(sigma[1]);
        if widest < near_px {
            break;
        }
        (half_px, near_px) = (f64::INFINITY, 2.0 * widest);
    }
    Some((sigma, agree))
}
/// How far a corner may be from where a fit starts before a listed band would be too narrow, in px.
pub(super) const FIRST_MARGIN_PX: f64 = 1.0;
