//! The pinhole that explains the corners best, and what it leaves unexplained.

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
mod tests {
    use super::*;
    use crate::metrics::tests::Noise;

    /// What a facing board leaves open is told as that, and not as steps of a search.
    #[test]
    fn a_facing_board_is_named_where_it_does_not_fix_the_fit() {
        let camera = designed();
        let mut unfixed = 0;
        for seed in 0..60 {
            let points = boards(&[600.0]);
            // A bend that no pinhole has, besides noise.
            let bent = |o: Observation| {
                let r = (o.image_px - camera.principal_px) / 500.0;
                let bend = 30.0 * f64::from(seed as u32 % 6) * r.length_squared() * r;
                Observation { image_px: o.image_px + bend, ..o }
            };
            let observations: Vec<_> = seen(&real(), &points, 0.5, seed).into_iter().map(bent).collect();
            for free in [&POSE[..], &POSE_AND_FOCAL, &POSE_AND_ANAMORPHIC, &ALL] {
                match fit(&camera, free, &observations) {
                    Err(Unmeasurable::Fit(Failure::NotConverged { .. })) => panic!("steps were counted"),
                    Err(Unmeasurable::Degenerate(told)) => {
                        assert_eq!(told, FACING);
                        unfixed += 1;
                    }
                    _ => {}
                }
            }
        }
        println!("{unfixed} fits were left open");
    }

    fn designed() -> Pinhole {
        Pinhole::parallel(DVec3::new(6.0, 0.0, 0.0), 35.0, 0.0055, DVec2::new(480.0, 540.0))
    }

    /// A camera near the designed one, every parameter changed.
    fn real() -> Pinhole {
        let camera_from_world = Pose::new(DVec3::new(-6.3, 0.2, -6.4), DVec3::new(0.01, -0.004, 0.006));
        Pinhole { camera_from_world, focal_px: DVec2::new(5782.0, 6360.0), principal_px: DVec2::new(471.0, 548.0) }
    }

    /// Boards of 8 x 9 points that face the designed camera, at the given depths.
    fn boards(depths: &[f64]) -> Vec<DVec3> {
        let board =
            |z: f64| (0..72).map(move |k| DVec3::new(f64::from(k % 8) - 3.5, f64::from(k / 8) - 4.0, 0.0) * z / 100.0);
        depths.iter().flat_map(|&z| board(z).map(move |p| p + DVec3::new(6.0, 0.0, z))).collect()
    }

    fn seen(camera: &Pinhole, points: &[DVec3], sigma: f64, seed: u64) -> Vec<Observation> {
        let mut noise = Noise(seed);
        let see = |&point_mm: &DVec3| Observation {
            point_mm,
            image_px: camera.project(point_mm).unwrap() + sigma * noise.normal(),
        };
        points.iter().map(see).collect()
    }

    #[test]
    fn derivatives_agree_with_central_differences() {
        let observations = seen(&real(), &boards(&[500.0, 2000.0]), 3.0, 1);
        let free = [ALL.as_slice(), &[Focal]].concat();
        let (_, jacobian) = derivatives(&real(), &free, &observations).unwrap();
        for (k, &parameter) in free.iter().enumerate() {
            let h = 1e-4;
            let at = |by| derivatives(&moved(real(), parameter, by), &free, &observations).unwrap().0;
            let slope = (at(h) - at(-h)) / (2.0 * h);
            let column = jacobian.column(k);
            // The difference errs by h^2 / 6 of a third derivative, here of the size of the first, and by rounding of
            // 1e-12 px / h.
            assert!((slope - column).norm() < 1e-7 * (1.0 + column.norm()), "{parameter:?}");
        }
    }

    #[test]
    fn exact_images_give_back_every_parameter() {
        let observations = seen(&real(), &boards(&[500.0, 1000.0, 2000.0]), 0.0, 0);
        let found = fit(&designed(), &ALL, &observations).unwrap();
        assert!(found.deviation.max < 1e-9, "{:?}", found.deviation);
        let (a, b) = (found.pinhole, real());
        assert!((a.focal_px - b.focal_px).length() < 1e-6 && (a.principal_px - b.principal_px).length() < 1e-6);
        assert!((a.centre_mm() - b.centre_mm()).length() < 1e-6);
        let turn = (a.camera_from_world.rotation - b.camera_from_world.rotation).to_cols_array();
        assert!(turn.iter().all(|t| t.abs() < 1e-9));
    }

    #[test]
    fn an_implied_transform_is_no_deviation() {
        // A camera that only stands and looks elsewhere: large against the design, nothing after the fit of the pose.
        let turned = Pinhole { camera_from_world: real().camera_from_world, ..designed() };
        for depths in [[500.0, 500.0], [500.0, 2000.0]] {
            let observations = seen(&turned, &boards(&depths), 0.0, 0);
            assert!(designed().deviation_px(&observations).unwrap().rms > 10.0);
            assert!(fit(&designed(), &POSE, &observations).unwrap().deviation.max < 1e-9);
        }
    }

    #[test]
    fn a_poor_start_still_finds_the_pose() {
        // A board photographed from 0.3 m aside, nearer by a fifth and turned by 20 degrees about each axis.
        let pose = Pose::new(DVec3::new(200.0, -220.0, 200.0), DVec3::splat(0.35));
        let far = Pinhole { camera_from_world: pose, ..designed() };
        let found = fit(&designed(), &POSE, &seen(&far, &boards(&[1000.0]), 0.0, 0)).unwrap();
        assert!(found.deviation.max < 1e-8 && (found.pinhole.centre_mm() - far.centre_mm()).length() < 1e-5);
    }

    #[test]
    fn covariance_is_calibrated_on_noise() {
        // Squared Mahalanobis distances of the truth, with the true variance, are chi-squared of p degrees: mean p,
        // variance 2p.
        let (points, sigma, runs) = (boards(&[500.0, 1000.0, 2000.0]), 0.05, 200);
        let free = POSE_AND_ANAMORPHIC;
        let truth = Pinhole { principal_px: designed().principal_px, ..real() };
        let (mut chi, mut variance) = (0.0, 0.0);
        for run in 0..runs {
            let found = fit(&designed(), &free, &seen(&truth, &points, sigma, run)).unwrap();
            let n = 2 * points.len() - free.len();
            let estimate = found.residuals_px.iter().map(|e| e.length_squared()).sum::<f64>() / n as f64;
            variance += estimate / (sigma * sigma) / f64::from(runs as u32);
            let information = found.covariance.clone().try_inverse().unwrap() * (estimate / (sigma * sigma));
            let error = DVector::from_vec(parameters(&found.pinhole, &truth));
            chi += (error.transpose() * information * &error)[0] / f64::from(runs as u32);
        }
        let p = free.len() as f64;
        // Five standard deviations of each mean.
        assert!((chi - p).abs() < 5.0 * (2.0 * p / f64::from(runs as u32)).sqrt(), "{chi}");
        let freedom = (2 * points.len()) as f64 - p;
        assert!((variance - 1.0).abs() < 5.0 * (2.0 / freedom / f64::from(runs as u32)).sqrt(), "{variance}");
    }

    /// The steps of [`POSE_AND_ANAMORPHIC`] that lead from `truth` to `found`, to first order.
    fn parameters(found: &Pinhole, truth: &Pinhole) -> Vec<f64> {
        let turn = found.camera_from_world.rotation * truth.camera_from_world.rotation.transpose();
        let shift = found.camera_from_world.translation_mm - turn * truth.camera_from_world.translation_mm;
        let focal = found.focal_px - truth.focal_px;
        vec![turn.y_axis.z, turn.z_axis.x, turn.x_axis.y, shift.x, shift.y, shift.z, focal.x, focal.y]
    }

    #[test]
    fn moving_world_and_camera_together_changes_no_residual() {
        let observations = seen(&real(), &boards(&[500.0, 2000.0]), 0.1, 5);
        let world = Pose::new(DVec3::new(300.0, -200.0, 100.0), DVec3::new(0.4, 1.0, -2.0));
        let moved: Vec<_> =
            observations.iter().map(|o| Observation { point_mm: world.point(o.point_mm), ..*o }).collect();
        let back = world.inverse();
        let seen_from = designed().camera_from_world;
        let camera_from_world =
            Pose { rotation: seen_from.rotation * back.rotation, translation_mm: seen_from.point(back.translation_mm) };
        let a = fit(&designed(), &POSE_AND_FOCAL, &observations).unwrap();
        let b = fit(&Pinhole { camera_from_world, ..designed() }, &POSE_AND_FOCAL, &moved).unwrap();
        assert!((a.deviation.rms - b.deviation.rms).abs() < 1e-9);
        assert!((world.point(a.pinhole.centre_mm()) - b.pinhole.centre_mm()).length() < 1e-6);
    }

    #[test]
    fn hard_input_is_named() {
        let camera = designed();
        let observations = seen(&camera, &boards(&[1000.0]), 0.0, 0);
        assert!(matches!(fit(&camera, &POSE, &[]), Err(Unmeasurable::TooFew { found: 0, needed: 4, .. })));
        assert!(matches!(fit(&camera, &POSE, &observations[..1]), Err(Unmeasurable::TooFew { found: 1, .. })));
        let row = fit(&camera, &POSE, &observations[..8]);
        assert!(matches!(row, Err(Unmeasurable::Fit(Failure::Singular { .. }))), "{row:?}");
        let facing = fit(&camera, &POSE_AND_FOCAL, &observations);
        assert!(matches!(facing, Err(Unmeasurable::Fit(Failure::Singular { .. }))), "{facing:?}");
        let mut bad = observations.clone();
        bad[2].image_px.y = f64::NAN;
        assert_eq!(fit(&camera, &POSE, &bad), Err(Unmeasurable::NotFinite { what: "observation", index: 2 }));
        bad[2] = Observation { point_mm: -observations[2].point_mm, ..observations[2] };
        assert_eq!(fit(&camera, &POSE, &bad), Err(Unmeasurable::BehindCamera { index: 2 }));
    }
}
