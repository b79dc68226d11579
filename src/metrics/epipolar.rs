//! Epipolar curves: whether they are straight, and whether they are horizontal.
//!
//! Fix a pixel of one half and let the scene point it sees run over a range of depths: its image in the other half
//! draws a curve. Two pinholes draw a straight line; through a prism it is straight only nearly, so slope *and*
//! departure from the best line are reported. No fundamental matrix is fitted: one would hide the departure.

use super::deviation::{Unmeasurable, at_least};
use super::line::Line;
use super::observation::Pair;
use super::pixel_map::{Correspondence, PixelMap};
use crate::num::stats::{max_abs, mean};
use glam::DVec2;

/// Points needed on a curve: two always lie on a line, and would say nothing of its straightness.
pub const POINTS_PER_CURVE: usize = 3;

/// One epipolar curve against its line of total least squares. Frame: raw half image, px.
#[derive(Debug, Clone, PartialEq)]
pub struct EpipolarCurve {
    /// The best line, each sample with the same weight. Sample at equal steps of 1/depth to weigh equal disparities.
    pub line: Line,
    /// Signed perpendicular distance of each sample from the line, in px.
    pub departures_px: Vec<f64>,
    /// Length of the curve along its line, in px: a slope over a short curve says little.
    pub extent_px: f64,
}

/// The best line of one sampled curve.
///
/// # Errors
/// [`Unmeasurable::TooFew`] below [`POINTS_PER_CURVE`] samples, [`Unmeasurable::NotFinite`],
/// [`Unmeasurable::Degenerate`] when the samples single out no direction.
pub fn curve(samples: &[DVec2]) -> Result<EpipolarCurve, Unmeasurable> {
    at_least("points on an epipolar curve", samples.len(), POINTS_PER_CURVE)?;
    let line = Line::through(samples)?;
    let departures_px = samples.iter().map(|p| line.distance(*p)).collect();
    Ok(EpipolarCurve { line, departures_px, extent_px: line.extent(samples) })
}

/// Many epipolar curves.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Curves with a line; the slopes are over these.
    pub curves: usize,
    /// Samples on them; the departures are over these.
    pub samples: usize,
    /// Curves without a line, by place in the input, each with its reason.
    pub rejected: Vec<(usize, Unmeasurable)>,
    /// Mean slope, signed: a roll common to all lines.
    pub slope_mean_rad: f64,
    /// Mean of |slope|.
    pub slope_mean_abs_rad: f64,
    /// Largest |slope|.
    pub slope_max_rad: f64,
    /// width tan(largest |slope|): rise of the steepest line across the image, in px.
    pub rise_max_px: f64,
    /// sqrt(sum d^2 / N) of the perpendicular departures over all N samples of all curves, in px.
    pub departure_rms_px: f64,
    /// Largest |d|, in px.
    pub departure_max_px: f64,
    /// Shortest curve, in px.
    pub extent_min_px: f64,
}

/// Slopes and departures of many curves in a half image `width_px` wide.
///
/// # Errors
/// [`Unmeasurable::TooFew`] of none; when no curve has a line, the reason of the first.
pub fn summary(curves: &[Vec<DVec2>], width_px: f64) -> Result<Summary, Unmeasurable> {
    at_least("epipolar curves", curves.len(), 1)?;
    let mut rejected = Vec::new();
    let mut fitted = Vec::new();
    for (place, samples) in curves.iter().enumerate() {
        match curve(samples) {
            Ok(c) => fitted.push(c),
            Err(reason) => rejected.push((place, reason)),
        }
    }
    if let (true, Some((_, reason))) = (fitted.is_empty(), rejected.first()) {
        return Err(*reason);
    }
    let slopes: Vec<f64> = fitted.iter().map(|c| c.line.slope_rad()).collect();
    let magnitudes: Vec<f64> = slopes.iter().map(|s| s.abs()).collect();
    let departures: Vec<f64> = fitted.iter().flat_map(|c| c.departures_px.iter().copied()).collect();
    let slope_max_rad = max_abs(&slopes);
    Ok(Summary {
        curves: fitted.len(),
        samples: departures.len(),
        rejected,
        slope_mean_rad: mean(&slopes),
        slope_mean_abs_rad: mean(&magnitudes),
        slope_max_rad,
        rise_max_px: width_px * libm::tan(slope_max_rad),
        departure_rms_px: crate::num::stats::rms(&departures),
        departure_max_px: max_abs(&departures),
        extent_min_px: fitted.iter().map(|c| c.extent_px).fold(f64::INFINITY, f64::min),
    })
}

/// Epipolar curves from corners only: a board seen at several depths, in the order of the depths.
///
/// No corner stays at one pixel of the left half when the board moves, so the map left px -> right px of each depth is
/// interpolated (see [`PixelMap`]) and evaluated at every left corner of the first depth that all depths cover. The
/// curves' accuracy is that of the interpolation: a polynomial of total degree `degree` through noisy corners.
///
/// # Errors
/// [`Unmeasurable::TooFew`] below [`POINTS_PER_CURVE`] depths, or when no corner is covered by all; what
/// [`PixelMap::fit`] refuses.
pub(crate) fn curves_from_depths(depths: &[Vec<Pair>], degree: usize) -> Result<Vec<Vec<DVec2>>, Unmeasurable> {
    at_least("depths", depths.len(), POINTS_PER_CURVE)?;
    let map = |pairs: &Vec<Pair>| {
        let samples: Vec<_> = pairs.iter().map(|p| Correspondence { image_px: p.left_px, value: p.right_px }).collect();
        PixelMap::fit(&samples, degree)
    };
    let maps = depths.iter().map(map).collect::<Result<Vec<_>, _>>()?;
    let curve = |p: &Pair| maps.iter().map(|m| m.at(p.left_px)).collect::<Option<Vec<DVec2>>>();
    let curves: Vec<_> = depths[0].iter().filter_map(curve).collect();
    at_least("corners covered at every depth", curves.len(), 1)?;
    Ok(curves)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::noise::Noise;

    fn parabola(slope: f64, bend: f64, n: usize) -> Vec<DVec2> {
        let x = |i: usize| 100.0 * (2.0 * i as f64 / (n - 1) as f64 - 1.0);
        (0..n).map(|i| DVec2::new(300.0 + x(i), 200.0 + slope * x(i) + bend * x(i) * x(i))).collect()
    }

    #[test]
    fn a_straight_line_has_its_slope_and_no_departure() {
        let s = summary(&[parabola(0.01, 0.0, 9), parabola(-0.02, 0.0, 5)], 960.0).unwrap();
        assert_eq!((s.curves, s.samples), (2, 14));
        assert!((s.slope_max_rad - libm::atan(0.02)).abs() < 1e-14);
        assert!((s.slope_mean_rad - 0.5 * (libm::atan(0.01) - libm::atan(0.02))).abs() < 1e-14);
        assert!((s.rise_max_px - 19.2).abs() < 1e-10);
        assert!(s.departure_max_px < 1e-12);
        assert!((s.extent_min_px - 200.0 * (1.0f64 + 0.0001).sqrt()).abs() < 1e-10);
    }

    #[test]
    fn departure_of_a_parabola_has_its_closed_form() {
        // y = b x^2 sampled evenly about 0: the best line is y = b mean(x^2), horizontal by symmetry.
        let (n, bend) = (101, 1e-4);
        let c = curve(&parabola(0.0, bend, n)).unwrap();
        let x2: Vec<f64> = parabola(0.0, 1.0, n).iter().map(|p| p.y - 200.0).collect();
        let mean_x2 = mean(&x2);
        let variance = mean(&x2.iter().map(|v| (v - mean_x2) * (v - mean_x2)).collect::<Vec<_>>());
        assert!(c.line.slope_rad().abs() < 1e-15);
        assert!((crate::num::stats::rms(&c.departures_px) - bend * variance.sqrt()).abs() < 1e-12);
        assert!((max_abs(&c.departures_px) - bend * (1e4 - mean_x2)).abs() < 1e-12);
    }

    #[test]
    fn bad_curves_are_counted_with_their_reason() {
        let s = summary(&[vec![DVec2::ONE; 4], parabola(0.0, 0.0, 3), vec![], vec![DVec2::NAN; 3]], 960.0).unwrap();
        assert_eq!(s.curves, 1);
        let places: Vec<usize> = s.rejected.iter().map(|(place, _)| *place).collect();
        assert_eq!(places, [0, 2, 3]);
        assert!(matches!(s.rejected[0].1, Unmeasurable::Degenerate(_)));
        assert!(matches!(summary(&[], 960.0), Err(Unmeasurable::TooFew { found: 0, .. })));
        assert!(matches!(summary(&[vec![DVec2::ZERO, DVec2::X]], 960.0), Err(Unmeasurable::TooFew { found: 2, .. })));
    }

    #[test]
    fn curves_from_corners_show_the_roll_of_the_right_camera() {
        // Right image = left image shifted by 7000/depth and turned by 0.003 rad about (480, 540), plus noise.
        let (sin, cos) = libm::sincos(0.003);
        let centre = DVec2::new(480.0, 540.0);
        let mut noise = Noise(1);
        let mut board = |depth: f64| -> Vec<Pair> {
            let step = 6e4 / depth;
            let grid = (-20..=20).flat_map(|j| (-20..=20).map(move |i| [i, j]));
            grid.filter_map(|index| {
                let left_px = centre + DVec2::new(f64::from(index[0]), f64::from(index[1])) * step;
                let seen = left_px.x > 0.0 && left_px.x < 960.0 && left_px.y > 0.0 && left_px.y < 1080.0;
                let offset = left_px - centre - DVec2::new(7000.0 / depth, 0.0);
                let right_px = centre + DVec2::new(cos, sin).rotate(offset) + 0.01 * noise.normal();
                seen.then_some(Pair { index, left_px, right_px })
            })
            .collect()
        };
        let depths = [board(500.0), board(1000.0), board(2000.0)];
        let curves = curves_from_depths(&depths, 3).unwrap();
        let s = summary(&curves, 960.0).unwrap();
        assert!(s.rejected.is_empty() && s.curves > 20, "{s:?}");
        // Extent 10.5 px and noise of 0.01 px a corner, averaged by the fit: some 1e-3 rad a curve.
        assert!((s.slope_mean_rad - 0.003).abs() < 1e-3, "{s:?}");
        assert!(matches!(curves_from_depths(&depths[..2], 3), Err(Unmeasurable::TooFew { .. })));
        let starved = [depths[0].clone(), depths[1].clone(), depths[2][..5].to_vec()];
        assert!(matches!(curves_from_depths(&starved, 3), Err(Unmeasurable::TooFew { .. })));
    }
}
