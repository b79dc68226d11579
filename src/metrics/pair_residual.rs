//! What is left of points that both images of a rectified pair see: against the pair's pinholes, and in the depth that a perfect
//! matcher finds.

use super::rectified_pair::RectifiedPair;
use crate::num::stats::{max_abs, quantile, rms};
use glam::{DVec2, DVec3};

/// A point, and where both images show it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenPoint {
    /// Where the left and the right image show it, in px.
    pub image_px: [DVec2; 2],
    /// The point in the world, in mm.
    pub point_mm: DVec3,
}

/// What is left of points that both images show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairResidual {
    /// N, the count of points.
    pub n: usize,
    /// Both images from their pinholes along x and along y, sqrt(sum e^2 / 2N), in px.
    pub pinhole_rms_px: DVec2,
    /// Largest |e| of these vectors, in px.
    pub pinhole_max_px: f64,
    /// sqrt(sum (y_L - y_R)^2 / N), in px.
    pub vertical_rms_px: f64,
    /// Largest |y_L - y_R|, in px.
    pub vertical_max_px: f64,
    /// Largest error of x_L - x_R against f b/Z and its constant, in px.
    pub disparity_max_px: f64,
    /// The depth that the disparity says less the true one.
    pub depth_error: PairDepthError,
}

/// Errors of depth from the line between the pair's centres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairDepthError {
    /// Root mean square, in mm.
    pub rms_mm: f64,
    /// The largest, in mm.
    pub max_mm: f64,
    /// Half of all, and 95 % of all, are at most this in % of the true depth.
    pub quantiles_percent: [f64; 2],
    /// The largest in % of the true depth.
    pub max_percent: f64,
}

impl PairResidual {
    /// The figures of `seen`; `None` of no points, and where one lies behind the pair.
    pub fn of(pair: &RectifiedPair, seen: &[SeenPoint]) -> Option<Self> {
        // Compare each image with its pinhole.
        let [left, right] = pair.cameras();
        let ideal = |point: &SeenPoint| Some([left.project(point.point_mm)?, right.project(point.point_mm)?]);
        let ideal: Vec<[DVec2; 2]> = seen.iter().map(ideal).collect::<Option<_>>()?;
        let off: Vec<DVec2> =
            seen.iter().zip(&ideal).flat_map(|(point, ideal)| [0, 1].map(|k| point.image_px[k] - ideal[k])).collect();
        let along = |axis: usize| rms(&off.iter().map(|off| off[axis]).collect::<Vec<_>>());

        // Compare rows and disparities.
        let vertical: Vec<f64> = seen.iter().map(|point| point.image_px[0].y - point.image_px[1].y).collect();
        let disparity = |px: &[DVec2; 2]| px[0].x - px[1].x;
        let beside: Vec<f64> =
            seen.iter().zip(&ideal).map(|(point, ideal)| disparity(&point.image_px) - disparity(ideal)).collect();

        Some(Self {
            n: seen.len(),
            pinhole_rms_px: DVec2::new(along(0), along(1)),
            pinhole_max_px: off.iter().fold(0.0, |most: f64, off| most.max(off.length())),
            vertical_rms_px: rms(&vertical),
            vertical_max_px: max_abs(&vertical),
            disparity_max_px: max_abs(&beside),
            depth_error: PairDepthError::of(pair, seen)?,
        })
    }
}

impl PairDepthError {
    fn of(pair: &RectifiedPair, seen: &[SeenPoint]) -> Option<Self> {
        let left = &pair.cameras()[0];
        let error = |point: &SeenPoint| {
            let depth_mm = left.camera_from_world.point(point.point_mm).z;
            let error_mm = pair.depth_mm(point.image_px[0].x - point.image_px[1].x) - depth_mm;
            (error_mm, 100.0 * (error_mm / depth_mm).abs())
        };
        let (mm, percent): (Vec<f64>, Vec<f64>) = seen.iter().map(error).unzip();
        Some(Self {
            rms_mm: rms(&mm),
            max_mm: max_abs(&mm),
            quantiles_percent: [quantile(&percent, 0.5)?, quantile(&percent, 0.95)?],
            max_percent: max_abs(&percent),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::rectified_pair::CentreAndLook;

    fn pair() -> RectifiedPair {
        let of = [-8.0, 8.0].map(|x| CentreAndLook {
            centre_mm: DVec3::new(x, 0.0, 2.0),
            direction: DVec3::Z,
            image_px: DVec2::new(480.0, 540.0),
        });
        RectifiedPair::new(of, DVec2::splat(6000.0)).unwrap()
    }

    fn seen(off: [DVec2; 2]) -> Vec<SeenPoint> {
        let points = [(0.0, 0.0, 802.0), (40.0, -30.0, 1202.0), (-9.0, 60.0, 1602.0)];
        let one = |(x, y, z): (f64, f64, f64)| {
            let point_mm = DVec3::new(x, y, z);
            let image_px = [0, 1].map(|k| pair().cameras()[k].project(point_mm).unwrap() + off[k]);
            SeenPoint { image_px, point_mm }
        };
        points.into_iter().map(one).collect()
    }

    #[test]
    fn nothing_is_left_of_pinholes() {
        let found = PairResidual::of(&pair(), &seen([DVec2::ZERO; 2])).unwrap();
        assert!(found.pinhole_max_px < 1e-9 && found.vertical_max_px < 1e-9 && found.disparity_max_px < 1e-9);
        assert!(found.n == 3 && found.depth_error.max_percent < 1e-9, "{found:?}");
    }

    /// Disparities of 120, 80 and 60 px, each too large by 0.3, say f b/(d + 0.3); rows are 0.4 px apart.
    #[test]
    fn what_is_left_is_told() {
        let found = PairResidual::of(&pair(), &seen([DVec2::new(0.3, 0.1), DVec2::new(0.0, -0.3)])).unwrap();
        assert!((found.pinhole_rms_px - DVec2::new(0.3, 0.1f64.sqrt()) * 0.5f64.sqrt()).length() < 1e-9, "{found:?}");
        assert!((found.pinhole_max_px - 0.1f64.sqrt()).abs() < 1e-9 && (found.vertical_rms_px - 0.4).abs() < 1e-9);
        assert!((found.disparity_max_px - 0.3).abs() < 1e-9 && (found.vertical_max_px - 0.4).abs() < 1e-9);
        let percent = [120.0, 80.0, 60.0].map(|d: f64| 100.0 * (1.0 - d / (d + 0.3)));
        assert!((found.depth_error.max_percent - percent[2]).abs() < 1e-9, "{found:?}");
        assert!((found.depth_error.quantiles_percent[0] - percent[1]).abs() < 1e-9, "{found:?}");
        assert!((found.depth_error.max_mm - 1600.0 * 0.01 * percent[2]).abs() < 1e-9, "{found:?}");
        assert!(PairResidual::of(&pair(), &[]).is_none());
    }
}
