//! Reprojection error: the pinhole that fits the corners best, and its residuals.

use super::deviation::{Deviation, Unmeasurable, at_least};
use super::observation::Observation;
use super::pinhole::Pinhole;
use crate::geom::Pose;
use crate::num::lsq::{self, Failure};
use Parameter::{
    Focal, FocalX, FocalY, PrincipalX, PrincipalY, RotationX, RotationY, RotationZ, ShiftX, ShiftY, ShiftZ,
};
use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector};

/// One way in which a pinhole may be moved to fit. Axes are those of the camera's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// Turn of the seen world about the camera's x axis through its centre, in rad.
    RotationX,
    /// Turn about y, in rad.
    RotationY,
    /// Turn about z, in rad.
    RotationZ,
    /// Shift of the seen world along the camera's x axis, in mm (the centre moves the other way).
    ShiftX,
    /// Shift along y, in mm.
    ShiftY,
    /// Shift along z, in mm.
    ShiftZ,
    /// The same change of both focal lengths, in px.
    Focal,
    /// Focal length along x, in px. With [`Parameter::FocalY`], instead of [`Parameter::Focal`]: an anamorphic pinhole.
    FocalX,
    /// Focal length along y, in px.
    FocalY,
    /// x of the principal point, in px.
    PrincipalX,
    /// y of the principal point, in px.
    PrincipalY,
}

impl Parameter {
    /// Its name in a report, with the unit.
    pub fn name(self) -> &'static str {
        match self {
            RotationX => "rotation_x_rad",
            RotationY => "rotation_y_rad",
            RotationZ => "rotation_z_rad",
            ShiftX => "shift_x_mm",
            ShiftY => "shift_y_mm",
            ShiftZ => "shift_z_mm",
            Focal => "focal_px",
            FocalX => "focal_x_px",
            FocalY => "focal_y_px",
            PrincipalX => "principal_x_px",
            PrincipalY => "principal_y_px",
        }
    }
}

/// The default: where the camera stands and looks, its inside as designed. This is the transform that any calibration
/// implies, so only what it leaves is a deviation from a pinhole; it is determined even by one board facing the camera.
pub const POSE: [Parameter; 6] = [RotationX, RotationY, RotationZ, ShiftX, ShiftY, ShiftZ];

/// [`POSE`] and one focal length. On one board that faces the camera, focal length and distance are nearly one
/// parameter: the residual is sound, the parameters are not (their covariance says so). Give several depths.
pub const POSE_AND_FOCAL: [Parameter; 7] = [RotationX, RotationY, RotationZ, ShiftX, ShiftY, ShiftZ, Focal];

/// [`POSE`] and a focal length for each axis. On one board the warning of [`POSE_AND_FOCAL`] holds.
pub const POSE_AND_ANAMORPHIC: [Parameter; 8] =
    [RotationX, RotationY, RotationZ, ShiftX, ShiftY, ShiftZ, FocalX, FocalY];

/// Everything that a pinhole has: [`POSE_AND_ANAMORPHIC`] and the principal point. Needs several depths: one plane
/// determines 8 parameters at most.
pub const ALL: [Parameter; 10] =
    [RotationX, RotationY, RotationZ, ShiftX, ShiftY, ShiftZ, FocalX, FocalY, PrincipalX, PrincipalY];

/// A fitted pinhole.
#[derive(Debug, Clone, PartialEq)]
pub struct PinholeFit {
    /// The pinhole of least sum |e|^2.
    pub pinhole: Pinhole,
    /// Observed minus projected, for each observation, in px.
    pub residuals_px: Vec<DVec2>,
    /// Their sizes: `deviation.rms` is the reprojection RMS over N vectors.
    pub deviation: Deviation,
    /// Covariance of the free parameters in the order they were given, in their units, from the residuals themselves:
    /// right if these were independent and equal in x and y. Residuals of optics are not; then it is a lower bound.
    pub covariance: DMatrix<f64>,
    /// Steps that the search took.
    pub iterations: usize,
}

/// Fits a pinhole to observations, starting at `start` (the designed virtual camera), moving only the `free`
/// parameters.
///
/// Levenberg-Marquardt on the pixel residuals with their exact derivatives; rotations are taken about the present
/// camera, so none is singular.
///
/// # Errors
/// [`Unmeasurable::TooFew`] unless 2N > the count of free parameters, [`Unmeasurable::NotFinite`],
/// [`Unmeasurable::BehindCamera`] at the start, [`Unmeasurable::Degenerate`] where one facing board leads nowhere, and
/// [`Unmeasurable::Fit`]: `Singular` when the points leave a parameter
/// free (all on one line, or focal length and distance for a board exactly parallel to the image).
pub fn fit(start: &Pinhole, free: &[Parameter], observations: &[Observation]) -> Result<PinholeFit, Unmeasurable> {
    at_least("observed points", observations.len(), free.len() / 2 + 1)?;
    start.residuals_px(observations)?;
    let evaluate = |camera: &Pinhole| derivatives(camera, free, observations);
    let minimum = lsq::levenberg_marquardt(*start, lsq::SearchSettings::default(), evaluate, |camera, step| {
        free.iter().zip(step.iter()).fold(*camera, |camera, (parameter, &by)| moved(camera, *parameter, by))
    });
    let minimum = minimum.map_err(|failure| match failure {
        Failure::NotConverged { .. } if faces(start, observations) => Unmeasurable::Degenerate(FACING),
        other => other.into(),
    })?;
    let residuals_px = minimum.state.residuals_px(observations)?;
    let deviation = Deviation::of(&residuals_px)?;
    let covariance = minimum.covariance.expect("2N > p was checked, so there is a variance");
    Ok(PinholeFit { pinhole: minimum.state, residuals_px, deviation, covariance, iterations: minimum.iterations })
}

/// What a fit over one board that faces the camera may end in: distance, focal length and turns trade places without end.
const FACING: &str = "one board that faces the camera, at one depth, does not fix this fit";

/// Whether all points are at one depth of the camera, to a millionth.
fn faces(camera: &Pinhole, observations: &[Observation]) -> bool {
    let depths = observations.iter().map(|o| camera.camera_from_world.point(o.point_mm).z);
    let (near, far) = depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
    far - near <= 1e-6 * far.abs()
}

/// Residuals (observed minus projected, x and y in turn) and their derivatives by the free parameters.
fn derivatives(
    camera: &Pinhole,
    free: &[Parameter],
    observations: &[Observation],
) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let mut residuals = DVector::zeros(2 * observations.len());
    let mut jacobian = DMatrix::zeros(2 * observations.len(), free.len());
    for (i, o) in observations.iter().enumerate() {
        let residual = o.image_px - camera.project(o.point_mm)?;
        let p = camera.camera_from_world.point(o.point_mm);
        let (a, f) = (p.truncate() / p.z, camera.focal_px);
        // The image moves by f (dx/z - a dz/z) when the point moves by (dx, dz).
        let by_point = |d: DVec3| f * (d.truncate() - a * d.z) / p.z;
        for (k, parameter) in free.iter().enumerate() {
            let change = match parameter {
                RotationX => by_point(DVec3::X.cross(p)),
                RotationY => by_point(DVec3::Y.cross(p)),
                RotationZ => by_point(DVec3::Z.cross(p)),
                ShiftX => by_point(DVec3::X),
                ShiftY => by_point(DVec3::Y),
                ShiftZ => by_point(DVec3::Z),
                Focal => a,
                FocalX => a.with_y(0.0),
                FocalY => a.with_x(0.0),
                PrincipalX => DVec2::X,
                PrincipalY => DVec2::Y,
            };
            (jacobian[(2 * i, k)], jacobian[(2 * i + 1, k)]) = (-change.x, -change.y);
        }
        (residuals[2 * i], residuals[2 * i + 1]) = (residual.x, residual.y);
    }
    Some((residuals, jacobian))
}

/// The camera after a change of one parameter. To first order the order of changes does not matter.
fn moved(camera: Pinhole, parameter: Parameter, by: f64) -> Pinhole {
    let turned = |axis: DVec3| {
        let (turn, seen) = (Pose::new(DVec3::ZERO, axis * by), camera.camera_from_world);
        let rotation = turn.rotation * seen.rotation;
        Pinhole { camera_from_world: Pose { rotation, translation_mm: turn.vector(seen.translation_mm) }, ..camera }
    };
    let mut next = camera;
    match parameter {
        RotationX => next = turned(DVec3::X),
        RotationY => next = turned(DVec3::Y),
        RotationZ => next = turned(DVec3::Z),
        ShiftX => next.camera_from_world.translation_mm.x += by,
        ShiftY => next.camera_from_world.translation_mm.y += by,
        ShiftZ => next.camera_from_world.translation_mm.z += by,
        Focal => next.focal_px += by,
        FocalX => next.focal_px.x += by,
        FocalY => next.focal_px.y += by,
        PrincipalX => next.principal_px.x += by,
        PrincipalY => next.principal_px.y += by,
    }
    next
}

#[cfg(test)]
#[path = "reprojection_tests.rs"]
mod tests;
