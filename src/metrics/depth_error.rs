//! Depth by a pair as it was designed, against the true one: what a perfect matcher on the raw halves would be wrong by.

use super::deviation::{Unmeasurable, all_finite, at_least};
use super::observation::Pair;
use super::pinhole::Pinhole;
use crate::num::stats::{max_abs, rms};
use glam::DVec3;

/// Depths by the columns of matched points less the true ones, over N pairs. Depths are those from the centre of the left camera along
/// its axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthError {
    /// N, the count of pairs.
    pub n: usize,
    /// sqrt(sum e^2 / N), in mm.
    pub rms_mm: f64,
    /// Largest |e|, in mm.
    pub max_mm: f64,
    /// sqrt(sum (e / Z)^2 / N), Z the true depth, in %.
    pub rms_percent: f64,
    /// Largest |e / Z|, in %.
    pub max_percent: f64,
}

/// The depth error of matched points, each with its true place in the world in mm, through the pinholes of the left and the right half.
///
/// The left image gives the ray, and the column of the right image the depth on it; rows are not compared. Of two parallel cameras
/// beside one another that is Z = f b / (pitch d), d the disparity less that of infinity (R. Hartley, A. Zisserman, Multiple View
/// Geometry in Computer Vision, 2nd ed., 9.2 and 12).
///
/// # Errors
/// [`Unmeasurable::TooFew`] of none, [`Unmeasurable::NotFinite`], [`Unmeasurable::BehindCamera`] for a point that is there, or whose
/// columns meet there or nowhere.
pub fn depth_error([left, right]: [&Pinhole; 2], seen: &[(Pair, DVec3)]) -> Result<DepthError, Unmeasurable> {
    at_least("matched corners", seen.len(), 1)?;
    all_finite("pair", seen, |(p, mm)| p.left_px.is_finite() && p.right_px.is_finite() && mm.is_finite())?;
    let right_from_left = right.camera_from_world.after(&left.camera_from_world.inverse());
    let t = right_from_left.translation_mm;
    let errors = seen.iter().enumerate().map(|(index, (pair, point_mm))| {
        // A point at the depth z is at z q in the left camera's frame, and at z R q + t in that of the right one.
        let q = left.at_depth(pair.left_px, 1.0);
        let turned = right_from_left.vector(q);
        let column = (pair.right_px.x - right.principal_px.x) / right.focal_px.x;
        let z_mm = (t.x - column * t.z) / (column * turned.z - turned.x);
        let true_mm = left.camera_from_world.point(*point_mm).z;
        let before = |z: f64| z > 0.0 && z.is_finite();
        if before(z_mm) && before(true_mm) {
            Ok([z_mm - true_mm, 100.0 * (z_mm - true_mm) / true_mm])
        } else {
            Err(Unmeasurable::BehindCamera { index })
        }
    });
    let errors: Vec<[f64; 2]> = errors.collect::<Result<_, _>>()?;
    let [mm, percent] = [0, 1].map(|k| errors.iter().map(|e| e[k]).collect::<Vec<f64>>());
    Ok(DepthError {
        n: errors.len(),
        rms_mm: rms(&mm),
        max_mm: max_abs(&mm),
        rms_percent: rms(&percent),
        max_percent: max_abs(&percent),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose;
    use glam::DVec2;

    fn pair(left_px: DVec2, right_px: DVec2) -> Pair {
        Pair { index: [0, 0], left_px, right_px }
    }

    /// f = 1000 px, b = 20 mm: at 1 m a disparity of 20 px; one of 20.2 is 1/1.01 m, and one of 19.8 1/0.99 m.
    #[test]
    fn parallel_cameras_by_hand() {
        let camera = |x: f64| Pinhole::parallel(DVec3::new(x, 0.0, 5.0), 1.0, 1e-3, DVec2::new(100.0 - x, 50.0));
        let [left, right] = [camera(-10.0), camera(10.0)];
        let at = |z: f64, off: f64| {
            let point = DVec3::new(30.0, -20.0, z + 5.0);
            let [l, r] = [left.project(point).unwrap(), right.project(point).unwrap()];
            // Rows are of no account.
            (pair(l, r - DVec2::new(off, 7.0)), point)
        };
        let exact = depth_error([&left, &right], &[at(1000.0, 0.0), at(400.0, 0.0)]).unwrap();
        assert!(exact.max_mm < 1e-9 && exact.n == 2, "{exact:?}");
        let off = depth_error([&left, &right], &[at(1000.0, 0.2), at(1000.0, -0.2)]).unwrap();
        let [near, far] = [1000.0 / 1.01 - 1000.0, 1000.0 / 0.99 - 1000.0];
        assert!((off.max_mm - far).abs() < 1e-9 && (off.max_percent - 0.1 * far).abs() < 1e-10, "{off:?}");
        let rms = ((near * near + far * far) / 2.0).sqrt();
        assert!((off.rms_mm - rms).abs() < 1e-9 && (off.rms_percent - 0.1 * rms).abs() < 1e-10, "{off:?}");
    }

    /// Cameras that are turned to each other and of other focal lengths: what they see themselves is at its depth.
    #[test]
    fn turned_cameras_see_right() {
        let camera = |x: f64, turn: f64, f: f64| Pinhole {
            camera_from_world: Pose::new(DVec3::new(-x, 1.0, 3.0), DVec3::new(0.01, turn, -0.02)),
            focal_px: DVec2::new(f, 1.1 * f),
            principal_px: DVec2::new(40.0, 60.0),
        };
        let [left, right] = [camera(-12.0, 0.03, 900.0), camera(12.0, -0.05, 1100.0)];
        for point in [DVec3::new(10.0, -30.0, 600.0), DVec3::new(-80.0, 50.0, 2500.0)] {
            let seen = pair(left.project(point).unwrap(), right.project(point).unwrap());
            let error = depth_error([&left, &right], &[(seen, point)]).unwrap();
            // Rounding of columns of 1e3 px, over a disparity of 10 px at least.
            assert!(error.max_percent < 1e-9, "{error:?}");
        }
    }

    #[test]
    fn what_lies_behind_is_refused() {
        let camera = |x: f64| Pinhole::parallel(DVec3::new(x, 0.0, 0.0), 1.0, 1e-3, DVec2::ZERO);
        let [left, right] = [camera(-10.0), camera(10.0)];
        let point = DVec3::new(0.0, 0.0, 1000.0);
        let swapped = pair(right.project(point).unwrap(), left.project(point).unwrap());
        let error = |seen: &[(Pair, DVec3)]| depth_error([&left, &right], seen);
        assert_eq!(error(&[(swapped, point)]), Err(Unmeasurable::BehindCamera { index: 0 }));
        assert!(matches!(error(&[]), Err(Unmeasurable::TooFew { .. })));
        let nan = pair(DVec2::NAN, DVec2::ZERO);
        assert!(matches!(error(&[(nan, point)]), Err(Unmeasurable::NotFinite { .. })));
    }
}
