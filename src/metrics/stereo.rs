//! Stereo alignment of the raw halves: whether they may go into a stereo matcher without rectification.

use super::deviation::{Unmeasurable, all_finite, at_least};
use super::observation::Pair;
use crate::num::stats::{max_abs, mean, rms};

/// Differences of matched corners, in px, raw halves, N pairs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disparity {
    /// N, the count of pairs.
    pub n: usize,
    /// sqrt(sum (y_L - y_R)^2 / N): photogrammetry's y-parallax, ROS's "epipolar error" (`camera_calibration`,
    /// `epipolar_error`), which ROS takes *after* rectification and calls good below 0.25 px, excellent below 0.1 px.
    pub vertical_rms_px: f64,
    /// Largest |y_L - y_R|: NI Vision's "maximum rectification error" for horizontal epipolar lines.
    pub vertical_max_px: f64,
    /// Mean of y_L - y_R: what a plain vertical shift of one half would remove.
    pub vertical_mean_px: f64,
    /// The "average epipolar err" that OpenCV's `stereo_calib` would print if it were given horizontal epipolar lines:
    /// (1/N) sum (|l_R x_L| + |l_L x_R|) with unit line normals, which is 2 (1/N) sum |y_L - y_R|. Mind that it is the
    /// sum of two distances, and linear.
    pub opencv_average_px: f64,
    /// Smallest and largest x_L - x_R: the range that a matcher must search.
    pub horizontal_range_px: [f64; 2],
}

/// The differences of matched corners.
///
/// # Errors
/// [`Unmeasurable::TooFew`] of none, [`Unmeasurable::NotFinite`].
pub fn disparity(pairs: &[Pair]) -> Result<Disparity, Unmeasurable> {
    at_least("matched corners", pairs.len(), 1)?;
    all_finite("pair", pairs, |p| p.left_px.is_finite() && p.right_px.is_finite())?;
    let vertical: Vec<f64> = pairs.iter().map(|p| p.left_px.y - p.right_px.y).collect();
    let magnitude: Vec<f64> = vertical.iter().map(|d| d.abs()).collect();
    let horizontal = pairs.iter().map(|p| p.left_px.x - p.right_px.x);
    let range = horizontal.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], d| [low.min(d), high.max(d)]);
    Ok(Disparity {
        n: pairs.len(),
        vertical_rms_px: rms(&vertical),
        vertical_max_px: max_abs(&vertical),
        vertical_mean_px: mean(&vertical),
        opencv_average_px: 2.0 * mean(&magnitude),
        horizontal_range_px: range,
    })
}

/// The law of an ideal pair, x_L - x_R = offset + gain / depth, fitted to measured disparities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthLaw {
    /// N, the count of samples.
    pub n: usize,
    /// Disparity of a point at infinity, in px.
    pub offset_px: f64,
    /// Baseline times focal length in px, in px mm.
    pub gain_px_mm: f64,
    /// sqrt(sum e^2 / N) of the disparities about the law, in px.
    pub rms_px: f64,
    /// Largest |e|, in px.
    pub max_px: f64,
}

/// Fits the law to samples of (depth in mm, x_L - x_R in px) by least squares over the disparities.
///
/// # Errors
/// [`Unmeasurable::TooFew`] below 3 samples (two always fit), [`Unmeasurable::NotFinite`] also for a depth of 0,
/// [`Unmeasurable::Degenerate`] when all depths are the same.
pub fn depth_law(samples: &[(f64, f64)]) -> Result<DepthLaw, Unmeasurable> {
    at_least("disparities with a depth", samples.len(), 3)?;
    all_finite("disparity sample", samples, |(z, d)| (1.0 / z).is_finite() && z.is_finite() && d.is_finite())?;
    let inverse: Vec<f64> = samples.iter().map(|(z, _)| 1.0 / z).collect();
    let disparities: Vec<f64> = samples.iter().map(|(_, d)| *d).collect();
    let (mean_x, mean_d) = (mean(&inverse), mean(&disparities));
    let sxx: f64 = inverse.iter().map(|x| (x - mean_x) * (x - mean_x)).sum();
    let sxd: f64 = inverse.iter().zip(&disparities).map(|(x, d)| (x - mean_x) * (d - mean_d)).sum();
    // Depths that agree to 12 digits differ by rounding only.
    if sxx.sqrt() <= 1e-12 * mean_x.abs() {
        return Err(Unmeasurable::Degenerate("all disparities are at one depth"));
    }
    let gain_px_mm = sxd / sxx;
    let offset_px = mean_d - gain_px_mm * mean_x;
    let residuals: Vec<f64> = inverse.iter().zip(&disparities).map(|(x, d)| d - offset_px - gain_px_mm * x).collect();
    Ok(DepthLaw { n: samples.len(), offset_px, gain_px_mm, rms_px: rms(&residuals), max_px: max_abs(&residuals) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn pair(left: [f64; 2], right: [f64; 2]) -> Pair {
        Pair { index: [0, 0], left_px: left.into(), right_px: right.into() }
    }

    #[test]
    fn two_pairs_by_hand() {
        let d = disparity(&[pair([10.0, 5.0], [4.0, 2.0]), pair([20.0, 1.0], [22.0, 5.0])]).unwrap();
        assert_eq!((d.n, d.vertical_max_px, d.vertical_mean_px), (2, 4.0, -0.5));
        assert!((d.vertical_rms_px - 12.5f64.sqrt()).abs() < 1e-15);
        assert_eq!(d.opencv_average_px, 7.0);
        assert_eq!(d.horizontal_range_px, [-2.0, 6.0]);
    }

    #[test]
    fn opencv_variant_is_its_formula_with_horizontal_lines() {
        // F of a rectified pair: the line of x in the other image is (0, -1, y), already of unit normal.
        let pairs = [pair([3.0, 7.0], [1.0, 7.5]), pair([4.0, 2.0], [9.0, 1.0]), pair([0.0, 0.0], [5.0, 0.25])];
        let line = |p: DVec2| [0.0, -1.0, p.y];
        let on = |l: [f64; 3], p: DVec2| (l[0] * p.x + l[1] * p.y + l[2]).abs();
        let sum: f64 = pairs.iter().map(|p| on(line(p.right_px), p.left_px) + on(line(p.left_px), p.right_px)).sum();
        assert!((disparity(&pairs).unwrap().opencv_average_px - sum / 3.0).abs() < 1e-15);
    }

    #[test]
    fn bad_pairs_are_named() {
        assert!(matches!(disparity(&[]), Err(Unmeasurable::TooFew { found: 0, .. })));
        let bad = [pair([0.0, 0.0], [0.0, 0.0]), pair([0.0, f64::INFINITY], [0.0, 0.0])];
        assert_eq!(disparity(&bad), Err(Unmeasurable::NotFinite { what: "pair", index: 1 }));
    }

    #[test]
    fn an_ideal_pair_obeys_the_depth_law() {
        // Baseline 12 mm, f = 35 / 0.0055 px.
        let gain = 12.0 * 35.0 / 0.0055;
        let samples: Vec<_> = [300.0, 500.0, 1000.0, 2000.0, 1e5].map(|z| (z, 3.0 + gain / z)).into();
        let law = depth_law(&samples).unwrap();
        assert!((law.gain_px_mm / gain - 1.0).abs() < 1e-12 && (law.offset_px - 3.0).abs() < 1e-10);
        assert!(law.max_px < 1e-10);
    }

    #[test]
    fn depth_law_refuses_what_it_cannot_fit() {
        assert!(matches!(depth_law(&[(1.0, 1.0), (2.0, 1.0)]), Err(Unmeasurable::TooFew { found: 2, .. })));
        assert!(matches!(depth_law(&[(5.0, 1.0); 4]), Err(Unmeasurable::Degenerate(_))));
        let zero = depth_law(&[(1.0, 1.0), (0.0, 1.0), (2.0, 1.0)]);
        assert_eq!(zero, Err(Unmeasurable::NotFinite { what: "disparity sample", index: 1 }));
    }
}
