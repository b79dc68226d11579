//! A first pose of a plane of corners, without a guess: the homography of a pinhole at the common point of the rays (Z. Zhang,
//! "A flexible new technique for camera calibration", 2000, section 3.1, its camera known).

use super::pose_fit::SeenPoint;
use crate::geom::{Pose, Ray};
use crate::metrics::ray_bundle::common_point;
use glam::{DMat3, DVec2, DVec3};
use nalgebra::{SMatrix, SVector, SymmetricEigen};

/// The pose of a plane whose points are seen by rays from nearly one place; `None` where they are parallel, or their points do
/// not span a plane.
pub(super) fn start(points: &[SeenPoint<'_>]) -> Option<Pose> {
    let rays: Vec<Ray> = points.iter().map(|(_, sighting)| sighting.ray).collect();
    let centre_mm = common_point(&rays).ok()?.point_mm;
    let slopes: Vec<DVec2> = rays.iter().map(|ray| ray.direction.truncate() / ray.direction.z).collect();
    let places: Vec<DVec2> = points.iter().map(|(at_mm, _)| *at_mm).collect();
    let homography = homography(&places, &slopes)?;

    // Its columns are those of the rotation and the translation, to one factor.
    let [first, second, third] = [homography.x_axis, homography.y_axis, homography.z_axis];
    let scale = (first.length() * second.length()).sqrt();
    let middle = places.iter().sum::<DVec2>() / places.len() as f64;
    let sign = (first.z * middle.x + second.z * middle.y + third.z).signum();
    let (x, y) = ((first * sign).normalize(), (second * sign).normalize());
    let y = (y - x * x.dot(y)).try_normalize()?;
    let pose =
        Pose { rotation: DMat3::from_cols(x, y, x.cross(y)), translation_mm: centre_mm + third * (sign / scale) };
    (pose.rotation.is_finite() && pose.translation_mm.is_finite()).then_some(pose)
}

/// The homography from places to images of least algebraic error, both moved and scaled to a mean distance of 1 (R. Hartley,
/// "In defense of the eight-point algorithm", 1997).
fn homography(places: &[DVec2], images: &[DVec2]) -> Option<DMat3> {
    let normal = |points: &[DVec2]| {
        let n = points.len() as f64;
        let middle = points.iter().sum::<DVec2>() / n;
        let reach = points.iter().map(|p| p.distance(middle)).sum::<f64>() / n;
        let scale = DMat3::from_diagonal(DVec3::new(1.0 / reach, 1.0 / reach, 1.0));
        (reach > 0.0).then(|| scale * DMat3::from_translation(-middle))
    };
    let (of_places, of_images) = (normal(places)?, normal(images)?);
    let mut sums = SMatrix::<f64, 9, 9>::zeros();
    for (place, image) in places.iter().zip(images) {
        let [u, v] = of_places.transform_point2(*place).to_array();
        let [x, y] = of_images.transform_point2(*image).to_array();
        for row in [[u, v, 1.0, 0.0, 0.0, 0.0, -x * u, -x * v, -x], [0.0, 0.0, 0.0, u, v, 1.0, -y * u, -y * v, -y]] {
            let row = SVector::<f64, 9>::from(row);
            sums += row * row.transpose();
        }
    }
    let eigen = SymmetricEigen::new(sums);
    let least = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    let rows: Vec<f64> = least.iter().copied().collect();
    let scaled = DMat3::from_cols_slice(&rows).transpose();
    Some(of_images.inverse() * scaled * of_places)
}
