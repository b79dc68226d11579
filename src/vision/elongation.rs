//! Elongated blur: its direction, and what it does to a crossing.
//!
//! A blur of covariance B spreads the distance from an edge of normal n by n^T B n, and makes the distances from two edges go
//! together by n0^T B n1. The first shows along the edges; the second shows at the crossing alone, which motion along a diagonal
//! of the squares draws out. So a few corners are fitted with that correlation tried over its range, and the one that leaves least
//! is taken where it leaves clearly less than that of a blur that is even all around.

use super::blur::free_fits;
use super::blur_shape::moved_width_px;
use super::candidates::Candidates;
use super::corner_site::CornerSite;
use super::detection::ElongatedBlur;
use super::settings::Settings;
use glam::{DMat2, DVec2};

/// Corners that are fitted, at most.
const PILOTS: usize = 8;
/// From this blur on, in px, across one family of lines at least: a narrower one is a few pixels of each crossing.
const LEAST_BLUR_PX: f64 = 1.0;
/// Correlations that are tried are the hyperbolic tangents of these, and of one between them: they crowd towards 1, where a blur is
/// a line.
const TRIALS: [f64; 5] = [-2.0, -1.0, 0.0, 1.0, 2.0];
/// A correlation is believed when it leaves less than this share of the squares that an even blur leaves. Over some ten thousand
/// pixels chance makes one of a few thousandths.
const LESS: f64 = 0.98;
/// A blur is called elongated from this ratio of its two standard deviations on.
const LEAST_RATIO: f64 = 1.5;

/// The correlation of the blurs across both families of lines beyond that of an even blur, and the blurs under it, in px.
pub(super) fn skew(
    candidates: &Candidates<'_>,
    sites: &[CornerSite],
    settings: &Settings,
    sigma_px: [f64; 2],
) -> (f64, [f64; 2]) {
    let even = (0.0, sigma_px);
    if sigma_px[0].max(sigma_px[1]) < LEAST_BLUR_PX || sites.is_empty() {
        return even;
    }

    // Fit some corners under a correlation: what they leave, and their blurs.
    let few: Vec<CornerSite> = sites.iter().copied().step_by(sites.len().div_ceil(PILOTS)).collect();
    let cosine = few.iter().map(CornerSite::cosine).sum::<f64>() / few.len() as f64;
    let leaves = |skew: f64| {
        let skewed: Vec<CornerSite> = few.iter().map(|site| site.skewed(skew)).collect();
        free_fits(candidates, &skewed, settings, sigma_px)
    };
    let beyond = |trial: f64| libm::tanh(trial) - cosine;

    // Try the range, and the place between where the parabola through the least and its neighbours is least.
    let trials = TRIALS.map(|trial| (trial, leaves(beyond(trial))));
    let squares = |k: usize| trials[k].1.map_or(f64::INFINITY, |(squares, _)| squares);
    let best = (0..TRIALS.len()).min_by(|&a, &b| squares(a).total_cmp(&squares(b))).unwrap_or(0);
    let middle = best.clamp(1, TRIALS.len() - 2);
    let [before, here, after] = [middle - 1, middle, middle + 1].map(squares);
    let place = TRIALS[middle] + 0.5 * (before - after) / (before - 2.0 * here + after);
    let place = if place.is_finite() { place.clamp(TRIALS[0], TRIALS[TRIALS.len() - 1]) } else { TRIALS[best] };
    let found = [(place, leaves(beyond(place))), trials[best]].into_iter();
    let found = found.filter_map(|(trial, left)| Some((trial, left?))).min_by(|a, b| a.1.0.total_cmp(&b.1.0));

    // Take it where an even blur leaves clearly more.
    match (found, leaves(0.0)) {
        (Some((trial, (least, sigma_px))), Some((even_squares, _))) if least < LESS * even_squares => {
            (beyond(trial), sigma_px)
        }
        _ => even,
    }
}

/// The blur as an ellipse, from those across edges of two normals and their correlation beyond an even blur's; `None` where it is
/// nearly round.
pub(super) fn elongation(normals: [DVec2; 2], sigma_px: [f64; 2], skew: f64) -> Option<ElongatedBlur> {
    told(ellipse(normals, sigma_px, skew))
}

/// The same of a Gaussian and a motion by `half_way_px` to both sides.
pub(super) fn elongation_by_motion(sigma_px: f64, half_way_px: DVec2) -> Option<ElongatedBlur> {
    let along_px = moved_width_px(sigma_px, half_way_px.length());
    told(ElongatedBlur { along_px, across_px: sigma_px, direction_rad: libm::atan(half_way_px.y / half_way_px.x) })
}

/// Where it is worth telling.
fn told(blur: ElongatedBlur) -> Option<ElongatedBlur> {
    (blur.along_px >= LEAST_BLUR_PX && blur.along_px >= LEAST_RATIO * blur.across_px).then_some(blur)
}

/// The blur as an ellipse, however round.
pub(super) fn ellipse(normals: [DVec2; 2], sigma_px: [f64; 2], skew: f64) -> ElongatedBlur {
    // Solve N^T B N = S for the covariance B.
    let [s0, s1] = sigma_px;
    let both = (normals[0].dot(normals[1]) + skew).clamp(-1.0, 1.0) * s0 * s1;
    let inverse = DMat2::from_cols(normals[0], normals[1]).inverse();
    let blur = inverse.transpose() * DMat2::from_cols_array(&[s0 * s0, both, both, s1 * s1]) * inverse;

    // Take its axes.
    let [xx, xy, yy] = [blur.x_axis.x, blur.x_axis.y, blur.y_axis.y];
    let (mean, spread) = (0.5 * (xx + yy), libm::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy));
    let (along_px, across_px) = ((mean + spread).sqrt(), (mean - spread).max(0.0).sqrt());
    let direction_rad = 0.5 * libm::atan2(2.0 * xy, xx - yy);
    ElongatedBlur { along_px, across_px, direction_rad }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ellipse_is_found_again_from_what_any_two_edges_show_of_it() {
        let unit = |degrees: f64| DVec2::from_angle(f64::to_radians(degrees));
        let expected = ElongatedBlur { along_px: 4.6, across_px: 0.7, direction_rad: 0.5 };
        let [a, b] = [DVec2::from_angle(0.5), DVec2::from_angle(0.5).perp()];
        for normals in [[unit(10.0), unit(100.0)], [unit(-40.0), unit(30.0)], [unit(0.0), unit(120.0)]] {
            let covariance = |n: DVec2, m: DVec2| 4.6 * 4.6 * a.dot(n) * a.dot(m) + 0.7 * 0.7 * b.dot(n) * b.dot(m);
            let sigma = normals.map(|n| covariance(n, n).sqrt());
            let skew = covariance(normals[0], normals[1]) / (sigma[0] * sigma[1]) - normals[0].dot(normals[1]);
            let found = elongation(normals, sigma, skew).unwrap();
            assert!((found.along_px - expected.along_px).abs() < 1e-9, "{found:?}");
            assert!((found.across_px - expected.across_px).abs() < 1e-9, "{found:?}");
            assert!((found.direction_rad - expected.direction_rad).abs() < 1e-9, "{found:?}");
        }
        assert_eq!(elongation([unit(10.0), unit(90.0)], [2.0; 2], 0.0), None);
    }
}
