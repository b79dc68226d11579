//! One homography of a whole image: what it leaves of the deviation from a pinhole whose centre is given.
//!
//! A camera that is turned, or has other focal lengths, another principal point or slanted pixels, is made parallel by one
//! homography, the same at every depth, as long as its centre stays where it is.

use super::deviation::{Deviation, Unmeasurable, at_least};
use super::observation::Observation;
use super::pinhole::Pinhole;
use crate::num::lsq;
use glam::DVec2;
use nalgebra::{DMatrix, DVector, SVector};

/// What is free: all that a homography has but its scale.
pub(crate) const FREE: [&str; 8] = ["h11", "h12", "h13", "h21", "h22", "h23", "h31", "h32"];

/// The eight numbers, of the tangents that `camera` sees: (h11 x + h12 y + h13) / (h31 x + h32 y + 1), and alike for y.
type Numbers8 = SVector<f64, 8>;

/// The deviation of observed positions from those that `camera` would see, after the one homography, between what it sees and the
/// image, that fits best, in px of the image.
///
/// # Errors
/// [`Unmeasurable::TooFew`] below 5 points, [`Unmeasurable::NotFinite`], [`Unmeasurable::BehindCamera`],
/// [`Unmeasurable::Fit`] where points lie on too few lines.
pub fn deviation(camera: &Pinhole, observations: &[Observation]) -> Result<Deviation, Unmeasurable> {
    at_least("observed points", observations.len(), FREE.len() / 2 + 1)?;
    let residuals_px = camera.residuals_px(observations)?;

    // Take tangents, in which all eight numbers are of the order of 1.
    let pairs: Vec<[DVec2; 2]> = observations
        .iter()
        .zip(&residuals_px)
        .map(|(o, residual)| {
            [o.image_px - *residual, o.image_px].map(|px| (px - camera.principal_px) / camera.focal_px)
        })
        .collect();
    let start = Numbers8::from([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    // A tangent of 1e-13 is 1e-9 px at 1e4 px.
    let settings = lsq::SearchSettings { tolerance: 1e-13, ..lsq::SearchSettings::default() };
    let minimum = lsq::levenberg_marquardt(
        start,
        settings,
        |h| derivatives(h, &pairs),
        |h, step| h + Numbers8::from_column_slice(step.as_slice()),
    )?;
    let left: Vec<DVec2> =
        minimum.residuals.as_slice().chunks_exact(2).map(|e| DVec2::new(e[0], e[1]) * camera.focal_px).collect();
    Deviation::of(&left)
}

/// Seen minus mapped, x and y in turn, and their derivatives; `None` where a point is mapped behind the image.
fn derivatives(h: &Numbers8, pairs: &[[DVec2; 2]]) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let mut residuals = DVector::zeros(2 * pairs.len());
    let mut jacobian = DMatrix::zeros(2 * pairs.len(), 8);
    for (i, [from, to]) in pairs.iter().enumerate() {
        let row = [from.x, from.y, 1.0];
        let scale = h[6] * from.x + h[7] * from.y + 1.0;
        if scale <= 0.0 {
            return None;
        }
        for axis in 0..2 {
            let mapped = (0..3).map(|k| h[3 * axis + k] * row[k]).sum::<f64>() / scale;
            residuals[2 * i + axis] = to[axis] - mapped;
            (0..3).for_each(|k| jacobian[(2 * i + axis, 3 * axis + k)] = -row[k] / scale);
            (0..2).for_each(|k| jacobian[(2 * i + axis, 6 + k)] = mapped * row[k] / scale);
        }
    }
    Some((residuals, jacobian))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose;
    use glam::DVec3;

    fn parallel() -> Pinhole {
        Pinhole::parallel(DVec3::new(6.0, 0.0, -2.0), 35.0, 0.0055, DVec2::new(480.0, 540.0))
    }

    /// What a camera turned about y and z, with other focal lengths and principal point, sees at three depths; moved by
    /// `shift_mm`.
    fn observations(shift_mm: f64) -> Vec<Observation> {
        let turn = Pose::new(DVec3::new(shift_mm, 0.0, 0.0), DVec3::new(0.0, 0.05, 0.01));
        let camera = Pinhole {
            camera_from_world: turn.after(&parallel().camera_from_world),
            focal_px: DVec2::new(6200.0, 6450.0),
            principal_px: DVec2::new(400.0, 550.0),
        };
        let depths = [400.0, 1000.0, 3000.0];
        let grid = |z: f64| {
            (-3..=3).flat_map(move |i| (-3..=3).map(move |j| (0.02 * f64::from(i) * z, 0.02 * f64::from(j) * z, z)))
        };
        let seen = |(x, y, z): (f64, f64, f64)| {
            let point_mm = DVec3::new(x, y, z);
            Observation { point_mm, image_px: camera.project(point_mm).unwrap() }
        };
        depths.into_iter().flat_map(grid).map(seen).collect()
    }

    #[test]
    fn a_camera_that_is_turned_about_its_centre_is_made_straight() {
        let seen = observations(0.0);
        let raw = parallel().deviation_px(&seen).unwrap();
        let left = deviation(&parallel(), &seen).unwrap();
        assert!(raw.rms > 100.0 && left.max < 1e-7 && left.n == seen.len(), "{raw:?} {left:?}");
    }

    #[test]
    fn another_centre_is_not_made_up_for() {
        // 1 mm off moves points by 16 px at 0.4 m and 2 px at 3 m; one homography takes only what the depths have in common.
        let left = deviation(&parallel(), &observations(1.0)).unwrap();
        assert!(left.rms > 1.0, "{left:?}");
        assert!(matches!(deviation(&parallel(), &observations(0.0)[..4]), Err(Unmeasurable::TooFew { .. })));
        assert!(matches!(deviation(&parallel(), &observations(0.0)[..7]), Err(Unmeasurable::Fit(_))));
    }
}
