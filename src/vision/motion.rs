//! The search for motion: a picture that moved on a straight way while it was taken.
//!
//! Motion is a line of the way's length and direction under a Gaussian: three numbers, that are fitted to what some corners leave near
//! their edges and at their crossing. It is sought where Gaussians leave something and their ellipse is clearly longer than wide.

use super::blur_shape::PictureBlur;
use super::candidates::Candidates;
use super::corner_fit::{CornerFit, profiles};
use super::corner_model::{Effort, WITHOUT_BLUR};
use super::corner_site::CornerSite;
use super::crossing::CrossingResponse;
use super::elongation::ellipse;
use super::equations::equations;
use super::listed::skew_equation;
use super::pilot_fits::{EFFORT, FittedPixels, PilotFit, fit_again, fit_pilots, leavings, squares};
use super::settings::Settings;
use super::window::Window;
use glam::DVec2;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// Corners that it is found from, at most.
const PILOTS: usize = 4;
/// It is sought where the ellipse of the blur is this many times as long as wide: of a shorter one a Gaussian of two widths tells enough.
const LEAST_RATIO: f64 = 2.0;
/// A shorter one, in px, is that of a way below 1.7 px, which a Gaussian of two widths tells well enough.
const LEAST_ALONG_PX: f64 = 0.5;
/// The Gaussian under it is no narrower than this, in px: the responses are tables, and a pixel shows nothing finer.
pub(super) const LEAST_SIGMA_PX: f64 = 0.05;
/// The pixels near an edge are chosen for a way that is longer by this share, and by so many px.
const MARGIN: (f64, f64) = (1.2, 0.3);
/// Steps at most, and the change in px below which they end.
const STEPS: usize = 8;
const TOLERANCE_PX: f64 = 1e-3;
/// Shares of a step that are tried in turn until less is left.
const SHARES: [f64; 4] = [1.0, 0.5, 0.2, 0.05];
/// Shares of the Gaussian's variance and of the way, and px at least, over which what is left is differentiated.
const PROBE: (f64, f64) = (0.02, 0.01);
/// Motion is believed when it leaves less than this share of what Gaussians leave: both have three numbers.
const LESS: f64 = 0.85;
/// Corners that leave more than this share of their contrasts, RMS, tell nothing of a blur.
const MOST: f64 = 0.1;
/// A step that leaves more than this share of what the one before left leads no farther.
const SLOW: f64 = 0.95;

/// Steps of the fits while the blur changes a little.
const FEW: Effort = Effort { steps: 3, tolerance_px: 1e-4, ..EFFORT };

/// Half the way in px, and the variance of the Gaussian in px^2.
#[derive(Debug, Clone, Copy)]
struct Moved {
    variance: f64,
    half_way: DVec2,
}

impl Moved {
    fn blur(self, normals: [DVec2; 2]) -> PictureBlur {
        PictureBlur::moved(self.variance.sqrt(), self.half_way, normals)
    }

    fn plus(self, step: Vector3<f64>) -> Self {
        let variance = (self.variance + step[0]).max(LEAST_SIGMA_PX * LEAST_SIGMA_PX);
        Self { variance, half_way: self.half_way + DVec2::new(step[1], step[2]) }
    }
}

/// The blur of a picture that moved, from the fits under Gaussians; `None` where motion leaves hardly less than they do.
pub(super) fn find_motion(
    candidates: &Candidates<'_>,
    sites: &[CornerSite],
    settings: &Settings,
    fits: &[PilotFit],
) -> Option<PictureBlur> {
    // Start from the ellipse of the blur, with all of its length beyond a circle for motion.
    let stride = sites.len().div_ceil(PILOTS).max(1);
    let few: Vec<CornerSite> = sites.iter().copied().step_by(stride).collect();
    let normals = few.get(few.len() / 2)?.normals();
    let model = fits.iter().flatten().next()?.1.model;
    let skew = model.skew + skew_change(fits, stride);
    let told = ellipse(normals, model.sigma_px, skew);
    let across_px = told.across_px.max(LEAST_SIGMA_PX);
    if told.along_px < (LEAST_RATIO * across_px).max(LEAST_ALONG_PX) {
        return None;
    }
    let way = (3.0 * (told.along_px * told.along_px - across_px * across_px)).sqrt();
    let mut best = Moved { variance: across_px * across_px, half_way: DVec2::from_angle(told.direction_rad) * way };

    // Fit the pilots in windows with room for a longer way, and find the least squares of what they leave.
    let roomy = Moved { half_way: best.half_way * MARGIN.0 + DVec2::from_angle(told.direction_rad) * MARGIN.1, ..best };
    let gaussian = PictureBlur::gaussian(model.sigma_px);
    let roomy_px = roomy.blur(normals).widest_px() * 3f64.sqrt();
    let skewed: Vec<CornerSite> = few.iter().map(|site| site.skewed(skew)).collect();
    let pilots = fit_pilots(candidates, &skewed, settings, &gaussian, [roomy_px + 4.5 * across_px; 2]);
    let (windows, still): (Vec<Option<&Window>>, Vec<Option<CornerFit>>) =
        pilots.iter().map(|pilot| pilot.as_ref().map(|(window, fit)| (window, *fit)).unzip()).unzip();
    let under = |moved: Moved, from: &[FittedPixels<'_>]| fit_again(from, &moved.blur(normals), &FEW);
    let left = |fits: &[Option<CornerFit>]| squares(fits.iter().flatten());
    let plain = left(&still);
    let tells = |fits: &[Option<CornerFit>]| left(fits) < (LESS * plain).min(MOST * MOST * few.len() as f64);
    let mut here = fit_again(&fitted(&windows, &still), &best.blur(normals), &EFFORT);
    for _ in 0..STEPS {
        let from = fitted(&windows, &here);
        let Some(step) = step(&from, best, |moved| under(moved, &from)) else { break };
        let shorter = SHARES.into_iter().map(|share| {
            let next = best.plus(share * step);
            (next, under(next, &from))
        });
        let Some(next) = shorter.into_iter().find(|(_, there)| left(there) < left(&here)) else { break };
        let before = left(&here);
        (best, here) = next;
        if left(&here) >= plain || (left(&here) > SLOW * before && !tells(&here)) {
            return None;
        }
        if DVec2::new(step[1], step[2]).length() < TOLERANCE_PX {
            break;
        }
    }
    (here.iter().all(Option::is_some) && tells(&here)).then(|| best.blur(normals))
}

/// Pixels with fits of them.
fn fitted<'a>(windows: &[Option<&'a Window>], fits: &'a [Option<CornerFit>]) -> Vec<FittedPixels<'a>> {
    windows.iter().zip(fits).map(|(window, fit)| window.zip(fit.as_ref())).collect()
}

/// The step of Gauss and Newton of variance and way, from what the fits leave there and beside it.
fn step(
    from: &[FittedPixels<'_>],
    best: Moved,
    under: impl Fn(Moved) -> Vec<Option<CornerFit>>,
) -> Option<Vector3<f64>> {
    let probe = |k: usize| {
        let size = if k == 0 { best.variance } else { best.half_way.length() };
        (PROBE.0 * size).max(PROBE.1)
    };
    let leaves = |fits: &[Option<CornerFit>]| -> Option<Vec<f64>> {
        let one = |(pixels, fit): (&FittedPixels<'_>, &Option<CornerFit>)| {
            let ((window, _), fit) = ((*pixels)?, fit.as_ref()?);
            let scale = 1.0 / fit.model.light[3];
            Some(leavings(window, &fit.model).into_iter().map(|v| v * scale).collect::<Vec<_>>())
        };
        let all: Option<Vec<Vec<f64>>> = from.par_iter().zip(fits).map(one).collect();
        Some(all?.concat())
    };
    let own: Vec<Option<CornerFit>> = from.iter().map(|pixels| pixels.map(|(_, fit)| *fit)).collect();
    let here = leaves(&own)?;
    let mut columns = Vec::new();
    for k in 0..3 {
        let mut change = Vector3::zeros();
        change[k] = probe(k);
        let there = leaves(&under(best.plus(change)))?;
        columns.push(there.iter().zip(&here).map(|(a, b)| (a - b) / probe(k)).collect::<Vec<_>>());
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let normal = Matrix3::from_fn(|i, j| dot(&columns[i], &columns[j]));
    let right = Vector3::from_fn(|i, _| -dot(&columns[i], &here));
    let step = normal.cholesky()?.solve(&right);
    step.iter().all(|v| v.is_finite()).then_some(step)
}

/// By how much the blurs across both families go together beyond what fits were told, by one step of least squares over one of `stride`
/// of them.
fn skew_change(fits: &[PilotFit], stride: usize) -> f64 {
    let one = |pilot: &PilotFit| {
        let (window, CornerFit { model, .. }) = pilot.as_ref()?;
        let (profiles, crossing) = (profiles(model), CrossingResponse::of(model));
        let sums = equations(window, model, (&profiles, &crossing), WITHOUT_BLUR);
        skew_equation(window, model, (&profiles, &crossing), &sums)
    };
    let all: Vec<Option<[f64; 2]>> = fits.par_iter().step_by(stride).map(one).collect();
    let [square, right] = all.iter().flatten().fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
    if square > 0.0 { right / square } else { 0.0 }
}
