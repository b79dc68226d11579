//! The numbers of a judgement that are asked for most, each from detected corners and exactly.

use super::judgement::Judgement;
use crate::metrics::{Deviation, Numbers};
use glam::DVec2;

impl Judgement {
    /// Vertical disparity y_L - y_R of corners on the raw halves, root mean square, in px.
    pub fn vertical_disparity_rms_px(&self) -> Numbers {
        self.stereo.disparity.numbers(|disparity| disparity.vertical_rms_px)
    }

    /// Largest slope of an epipolar line against the rows, in rad.
    pub fn epipolar_slope_max_rad(&self) -> Numbers {
        self.stereo.epipolar.numbers(|epipolar| epipolar.slope_max_rad)
    }

    /// Corners of both halves against the designed virtual cameras at the depth of the scene's own board, root mean square,
    /// in px.
    pub fn designed_corners_rms_px(&self) -> Numbers {
        self.pooled
            .at(self.view.depth_mm)
            .map_or(Numbers { measured: None, exact: None }, |own| own.designed.numbers(|deviation| deviation.rms))
    }

    /// Table 1 of the design paper: mean of the horizontal and of the vertical deviation from the designed virtual cameras,
    /// on their image planes, in mm.
    pub fn designed_mean_abs_mm(&self) -> [Numbers; 2] {
        [0, 1].map(|axis| self.pooled.designed.numbers(|deviation| deviation.mm.mean_abs[axis]))
    }

    /// Corners of both halves against the pinholes that fit best over all depths, root mean square, in px.
    pub fn fitted_rms_px(&self) -> Numbers {
        self.pooled.fitted.numbers(|deviation| deviation.rms)
    }

    /// Rows and columns of both halves against straight lines, root mean square, in px.
    pub fn straightness_rms_px(&self) -> Numbers {
        self.pooled.straightness.numbers(|straightness| straightness.both.rms_px)
    }

    /// The detector's own error: measured minus true positions of corners, root mean square, in px.
    pub fn detector_rms_px(&self) -> Option<f64> {
        let errors: Vec<DVec2> = self.detected.iter().flat_map(|half| half.errors_px.iter().copied()).collect();
        Deviation::of(&errors).ok().map(|deviation| deviation.rms)
    }
}
