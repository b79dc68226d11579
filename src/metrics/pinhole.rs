//! The ideal camera: one centre, straight rays, a plane image.

use super::deviation::{Deviation, Unmeasurable, all_finite, at_least};
use super::observation::Observation;
use crate::geom::Pose;
use glam::{DVec2, DVec3};

/// OpenCV's pixels have their centres at whole numbers: its positions are less by half a pixel.
pub const OPENCV_CENTRE_PX: f64 = 0.5;

/// A pinhole camera without distortion that looks along the +z of its own frame, image un-inverted (+u sees +x).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pinhole {
    /// The camera's frame from the world's; the centre of projection is the camera frame's origin.
    pub camera_from_world: Pose,
    /// Focal lengths in units of a pixel, along x and y: equal unless the camera is anamorphic.
    pub focal_px: DVec2,
    /// Where the camera's z axis meets the image, in px (pixel-edge convention) from the half's own origin.
    pub principal_px: DVec2,
}

impl Pinhole {
    /// A camera parallel to the world's axes, centred at `centre_mm`, with focal length and square pixel in mm.
    pub fn parallel(centre_mm: DVec3, focal_mm: f64, pitch_mm: f64, principal_px: DVec2) -> Self {
        let camera_from_world = Pose { translation_mm: -centre_mm, ..Pose::IDENTITY };
        Self { camera_from_world, focal_px: DVec2::splat(focal_mm / pitch_mm), principal_px }
    }

    /// The centre of projection in the world, in mm.
    pub fn centre_mm(&self) -> DVec3 {
        self.camera_from_world.inverse().translation_mm
    }

    /// The image of a world point, in px; `None` at or behind the plane of the centre.
    pub fn project(&self, point_mm: DVec3) -> Option<DVec2> {
        let p = self.camera_from_world.point(point_mm);
        (p.z > 0.0).then(|| self.principal_px + self.focal_px * p.truncate() / p.z)
    }

    /// The point of the camera's frame at depth `z_mm` (mm along its axis, below zero behind the centre) whose line
    /// through the centre belongs to `image_px`.
    pub fn at_depth(&self, image_px: DVec2, z_mm: f64) -> DVec3 {
        ((image_px - self.principal_px) / self.focal_px * z_mm).extend(z_mm)
    }

    /// Observed minus projected, for each observation, in px.
    ///
    /// # Errors
    /// [`Unmeasurable::TooFew`] of none, [`Unmeasurable::NotFinite`], [`Unmeasurable::BehindCamera`].
    pub fn residuals_px(&self, observations: &[Observation]) -> Result<Vec<DVec2>, Unmeasurable> {
        at_least("observed points", observations.len(), 1)?;
        all_finite("observation", observations, |o| o.point_mm.is_finite() && o.image_px.is_finite())?;
        let residual = |(index, o): (usize, &Observation)| {
            self.project(o.point_mm).map(|ideal| o.image_px - ideal).ok_or(Unmeasurable::BehindCamera { index })
        };
        observations.iter().enumerate().map(residual).collect()
    }

    /// The sizes of [`Pinhole::residuals_px`]: with the designed virtual camera, the pinhole deviation without a fit.
    /// In mm on the sensor: times the pixel pitch.
    ///
    /// # Errors
    /// As [`Pinhole::residuals_px`].
    pub fn deviation_px(&self, observations: &[Observation]) -> Result<Deviation, Unmeasurable> {
        Deviation::of(&self.residuals_px(observations)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projection_by_similar_triangles() {
        // f = 35 mm, 5.5 um pixels, centre (6, 0, 10): a point 100 mm to the right at 1 m from the centre.
        let camera = Pinhole::parallel(DVec3::new(6.0, 0.0, 10.0), 35.0, 0.0055, DVec2::new(480.0, 540.0));
        let image = camera.project(DVec3::new(106.0, -20.0, 1010.0)).unwrap();
        assert!((image - DVec2::new(480.0 + 3.5 / 0.0055, 540.0 - 0.7 / 0.0055)).length() < 1e-10);
        assert!((camera.at_depth(image, 1000.0) - DVec3::new(100.0, -20.0, 1000.0)).length() < 1e-10);
        assert_eq!(camera.centre_mm(), DVec3::new(6.0, 0.0, 10.0));
        assert_eq!(camera.project(DVec3::new(0.0, 0.0, 10.0)), None);
    }

    #[test]
    fn unseen_and_bad_points_are_named() {
        let camera = Pinhole::parallel(DVec3::ZERO, 35.0, 0.0055, DVec2::ZERO);
        let seen = |z: f64| Observation { point_mm: DVec3::new(0.0, 0.0, z), image_px: DVec2::ONE };
        assert_eq!(camera.residuals_px(&[seen(5.0)]).unwrap(), [DVec2::ONE]);
        assert_eq!(camera.residuals_px(&[seen(5.0), seen(-5.0)]), Err(Unmeasurable::BehindCamera { index: 1 }));
        let nan = camera.deviation_px(&[seen(f64::NAN)]);
        assert_eq!(nan, Err(Unmeasurable::NotFinite { what: "observation", index: 0 }));
        assert!(matches!(camera.deviation_px(&[]), Err(Unmeasurable::TooFew { .. })));
    }
}
