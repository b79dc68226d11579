//! What the values of a camera come to: its rays.

use super::model::{CalibrationSpec, CameraSpec};
use crate::geom::{CalibratedPinhole, Distortion};
use glam::{DMat3, DVec2, DVec3};

impl Default for CalibrationSpec {
    fn default() -> Self {
        Self { principal_px: None, rotation: DMat3::IDENTITY, distortion: Distortion::default(), focal_ratio: 1.0 }
    }
}

impl CameraSpec {
    /// The angle to the axis, in rad, at which the plain pinhole sees the middle of a half image.
    pub fn half_centre_rad(&self) -> f64 {
        libm::atan(self.width_px as f64 * self.pitch_mm / (4.0 * self.focal_length_mm))
    }

    /// The middle of the sensor, in px.
    pub fn middle_px(&self) -> DVec2 {
        DVec2::new(self.width_px as f64, self.height_px as f64) * 0.5
    }

    /// The principal point, in px.
    pub fn principal_px(&self) -> DVec2 {
        self.calibration.principal_px.unwrap_or(self.middle_px())
    }

    /// The plain pinhole of the same place, focal length and sensor.
    #[must_use]
    pub fn plain(&self) -> Self {
        Self { calibration: CalibrationSpec::default(), ..*self }
    }

    /// How it sees from its principal point, where it differs from the plain pinhole.
    pub fn calibrated(&self) -> Option<CalibratedPinhole> {
        let CalibrationSpec { rotation, distortion, focal_ratio, .. } = self.calibration;
        let own = CalibrationSpec { principal_px: Some(self.principal_px()), ..self.calibration };
        let plain = CalibrationSpec { principal_px: Some(self.middle_px()), ..CalibrationSpec::default() };
        let tangent_per_px = self.pitch_mm / self.focal_length_mm;
        (own != plain).then(|| CalibratedPinhole {
            tangent_per_px: DVec2::new(tangent_per_px, tangent_per_px / focal_ratio),
            distortion,
            rotation,
            lean: DVec2::ZERO,
        })
    }

    /// The unit direction, in the world, that is seen at `px`.
    pub fn direction(&self, px: DVec2) -> DVec3 {
        match self.calibrated() {
            Some(pinhole) => pinhole.direction(px - self.principal_px()),
            None => ((px - self.middle_px()) * self.pitch_mm / self.focal_length_mm).extend(1.0).normalize(),
        }
    }

    /// The direction of its axis in the world.
    pub fn axis(&self) -> DVec3 {
        self.calibration.rotation.z_axis
    }
}
