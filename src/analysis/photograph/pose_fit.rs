//! The pose of a plane of corners by least squares: six numbers, for the rays as they leave the glass.

use super::sighting::Sighting;
use crate::geom::Pose;
use crate::metrics::Deviation;
use crate::num::lsq::{Failure, SearchSettings, levenberg_marquardt};
use crate::scene::BoardSpec;
use crate::system::Board;
use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector};

/// More corners than this are thinned out evenly: six numbers are known far better than is needed.
const MOST_CORNERS: usize = 20_000;
/// Steps of the central differences: in rad, and in parts of the distance to the plane. Their error is the square of it,
/// and rounding, of some 1e-13 of a position, adds 1e-8 of a derivative.
const STEP: f64 = 1e-5;
/// A plane and its mirror image about the line of sight differ by more than this angle, in rad, or are one.
const TWO_PLANES_RAD: f64 = 1e-3;
/// Six numbers of which some change does less than this, as a share of what the strongest does, are not determined: the
/// derivatives are known to 1e-8.
const SMALLEST_RECIPROCAL_CONDITION: f64 = 1e-6;
/// What a corner of a good photograph is off by at least, in px.
const LEAST_NOISE_PX: f64 = 0.01;
/// Two minima are told apart when the worse one has a sum of squares larger by this many times the variance of a residual:
/// four standard deviations.
const TOLD_APART: f64 = 16.0;

/// A corner of the plane, in mm in its frame, and what saw it.
pub(super) type SeenPoint<'a> = (DVec2, &'a Sighting);

/// The plane that explains corners best.
#[derive(Debug, Clone)]
pub(super) struct FittedPlane {
    /// The plane's frame in the world.
    pub(super) pose: Pose,
    /// Sizes of the residuals, found minus explained, in px.
    pub(super) deviation: Deviation,
    /// Another pose, tilted the other way, that the corners do not tell from this one.
    pub(super) other: Option<Pose>,
}

/// Residuals of `points` on a board like `board` at `pose`, in px; `None` where a ray does not meet it.
pub(super) fn residuals_px(board: &BoardSpec, pose: &Pose, points: &[SeenPoint<'_>]) -> Option<Vec<DVec2>> {
    let board = Board::new(&BoardSpec { world_from_board: *pose, ..*board });
    points.iter().map(|(point_mm, sighting)| sighting.residual_px(&board, *point_mm)).collect()
}

/// The pose of least sum of squares over `points`, from `start`, whose plane may be tilted the other way: seen from afar, a
/// plane and its mirror image about the line of sight look alike, and each has a minimum.
///
/// # Errors
/// Of the search, when it ends without a pose from either start.
pub(super) fn fit(board: &BoardSpec, start: Pose, points: &[SeenPoint<'_>]) -> Result<FittedPlane, Failure> {
    let thinned: Vec<SeenPoint<'_>> =
        points.iter().copied().step_by(points.len().div_ceil(MOST_CORNERS).max(1)).collect();
    let found = search(board, start, &thinned)?;
    let mirrored = mirrored(&found.0, &thinned).and_then(|start| search(board, start, &thinned).ok());
    let sum = |deviation: &Deviation| deviation.rms * deviation.rms * deviation.n as f64;
    let (best, other) = match mirrored {
        Some(other) if sum(&other.1) < sum(&found.1) => (other, Some(found)),
        other => (found, other),
    };
    // Two residuals a corner, less the six numbers.
    let variance = sum(&best.1) / (2.0 * best.1.n as f64 - 6.0).max(1.0);
    let alike = |(pose, deviation): &(Pose, Deviation)| {
        pose.rotation.z_axis.angle_between(best.0.rotation.z_axis) > TWO_PLANES_RAD
            && sum(deviation) - sum(&best.1) < TOLD_APART * variance
    };
    let other = other.filter(alike).map(|(pose, _)| pose);
    Ok(FittedPlane { pose: best.0, deviation: best.1, other })
}

fn search(board: &BoardSpec, start: Pose, points: &[SeenPoint<'_>]) -> Result<(Pose, Deviation), Failure> {
    let minimum = levenberg_marquardt(
        start,
        SearchSettings::default(),
        |pose| derivatives(board, pose, points),
        |pose, step| moved(pose, step.as_slice()),
    )?;
    // A product of many rotations is one only to rounding; its three angles make it one.
    let pose = Pose::new(minimum.state.translation_mm, minimum.state.angles_rad());
    let (_, mut jacobian) = derivatives(board, &pose, points).ok_or(Failure::NoStart)?;
    jacobian.column_iter_mut().for_each(|mut column| {
        let length = column.norm();
        column /= if length > 0.0 { length } else { 1.0 };
    });
    let strengths = jacobian.singular_values();
    let reciprocal_condition = strengths.min() / strengths.max();
    if reciprocal_condition < SMALLEST_RECIPROCAL_CONDITION {
        return Err(Failure::Singular { reciprocal_condition });
    }
    let residuals = residuals_px(board, &pose, points).ok_or(Failure::NoStart)?;
    let deviation = Deviation::of(&residuals).map_err(|_| Failure::NoStart)?;
    Ok((pose, deviation))
}

/// How far the plane of `points` leaves open where on it the rays of `others` meet it on average, in mm: the standard deviation
/// along the worse axis, for corners as noisy as what the fit leaves of them, and at least as those of a good photograph.
pub(super) fn open_mm(
    board: &BoardSpec,
    plane: &FittedPlane,
    points: &[SeenPoint<'_>],
    others: &[&Sighting],
) -> Option<f64> {
    let (_, jacobian) = derivatives(board, &plane.pose, points)?;
    let mean = |pose: &Pose| {
        let board = Board::new(&BoardSpec { world_from_board: *pose, ..*board });
        let met = others.iter().map(|s| s.met_mm(&board)).collect::<Option<Vec<DVec2>>>()?;
        Some(met.iter().sum::<DVec2>() / met.len() as f64)
    };
    let steps = steps(&plane.pose, points);
    let mut slopes = DMatrix::zeros(6, 2);
    for (k, step) in steps.into_iter().enumerate() {
        let beside = |by: f64| {
            let mut numbers = [0.0; 6];
            numbers[k] = by;
            mean(&moved(&plane.pose, &numbers))
        };
        let slope = (beside(step)? - beside(-step)?) / (2.0 * step);
        slopes.set_row(k, &nalgebra::RowVector2::new(slope.x, slope.y));
    }
    // Of J^T J = R^T R: g^T (J^T J)^-1 g = |R^-T g|^2.
    let mut open = slopes;
    if !jacobian.qr().r().tr_solve_upper_triangular_mut(&mut open) {
        return None;
    }
    // The RMS is of vectors of two coordinates.
    let noise_px = (plane.deviation.rms / std::f64::consts::SQRT_2).max(LEAST_NOISE_PX);
    Some(noise_px * open.column(0).norm().max(open.column(1).norm()))
}

/// Steps of the six numbers for differences.
fn steps(pose: &Pose, points: &[SeenPoint<'_>]) -> [f64; 6] {
    let distance_mm = points.first().map_or(1.0, |(_, s)| s.ray.origin.distance(pose.translation_mm)).max(1e-9);
    [1.0, 1.0, 1.0, distance_mm, distance_mm, distance_mm].map(|unit| STEP * unit)
}

/// Residuals, x and y in turn, and their central differences by the six numbers.
fn derivatives(board: &BoardSpec, pose: &Pose, points: &[SeenPoint<'_>]) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let flat = |pose: &Pose| {
        let residuals = residuals_px(board, pose, points)?;
        Some(DVector::from_iterator(2 * points.len(), residuals.into_iter().flat_map(|r| r.to_array())))
    };
    let mut jacobian = DMatrix::zeros(2 * points.len(), 6);
    for (k, step) in steps(pose, points).into_iter().enumerate() {
        let beside = |by: f64| {
            let mut numbers = [0.0; 6];
            numbers[k] = by;
            flat(&moved(pose, &numbers))
        };
        jacobian.set_column(k, &((beside(step)? - beside(-step)?) / (2.0 * step)));
    }
    Some((flat(pose)?, jacobian))
}

/// The pose turned about its own place by three angles, in rad, and shifted by three lengths, in mm.
fn moved(pose: &Pose, numbers: &[f64]) -> Pose {
    let turn = Pose::new(DVec3::ZERO, DVec3::new(numbers[0], numbers[1], numbers[2])).rotation;
    let shift = DVec3::new(numbers[3], numbers[4], numbers[5]);
    Pose { rotation: turn * pose.rotation, translation_mm: pose.translation_mm + shift }
}

/// The pose with its normal mirrored about the line of sight to the middle of the points, which stays.
fn mirrored(pose: &Pose, points: &[SeenPoint<'_>]) -> Option<Pose> {
    let n = points.len() as f64;
    let middle_mm = points.iter().map(|(at, _)| *at).sum::<DVec2>() / n;
    let sight = points.iter().map(|(_, sighting)| sighting.ray.direction).sum::<DVec3>().normalize();
    let normal = pose.rotation.z_axis;
    let other = sight * (2.0 * normal.dot(sight)) - normal;
    let (axis, angle) = (normal.cross(other), normal.angle_between(other));
    let turn = glam::DMat3::from_quat(glam::DQuat::from_axis_angle(axis.try_normalize()?, angle));
    let fixed = pose.point(middle_mm.extend(0.0));
    let rotation = turn * pose.rotation;
    Some(Pose { rotation, translation_mm: fixed - rotation * middle_mm.extend(0.0) })
}
