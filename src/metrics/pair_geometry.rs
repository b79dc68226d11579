//! The geometry of a stereo pair: what its two cameras are to each other.

use super::deviation::Unmeasurable;
use super::pinhole::Pinhole;
use glam::{DVec2, DVec3};

/// What two cameras are to each other. Angles are in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairGeometry {
    /// Distance of the two centres.
    pub baseline_mm: f64,
    /// Angle between the rays of the two image centres, in the plane that holds z and the baseline: positive where they
    /// converge in front of the cameras.
    pub vergence_deg: f64,
    /// Field of view between the middles of the image's opposite sides, horizontal and vertical: the mean of both cameras.
    pub field_deg: DVec2,
    /// How far a point at the given depth moves along z for a disparity less by 1 px.
    pub depth_per_px_mm: f64,
}

/// Step of the difference by which the disparity is derived, as a share of the depth: its error is the square of it.
const STEP: f64 = 1e-4;

impl PairGeometry {
    /// The geometry of the left and the right camera, whose images have `size_px`; the resolution in depth is that at
    /// `point_mm`, in the world.
    ///
    /// # Errors
    /// [`Unmeasurable`] where a camera does not see the point, or both cameras have one centre.
    pub fn of(cameras: [&Pinhole; 2], size_px: DVec2, point_mm: DVec3) -> Result<Self, Unmeasurable> {
        // Measure the baseline, and the angles of the central rays in its plane.
        let [left, right] = cameras;
        let baseline = right.centre_mm() - left.centre_mm();
        let along = baseline.try_normalize().ok_or(Unmeasurable::Degenerate("both cameras have one centre"))?;
        let towards =
            |camera: &Pinhole, px: DVec2| camera.camera_from_world.rotation.transpose() * camera.at_depth(px, 1.0);
        let forward = (DVec3::Z - along * along.z).normalize();
        let turn = |camera: &Pinhole| {
            let ray = towards(camera, 0.5 * size_px);
            libm::atan2(ray.dot(along), ray.dot(forward))
        };

        // Measure the field between the middles of opposite sides.
        let between = |camera: &Pinhole, a: DVec2, b: DVec2| {
            let [a, b] = [a, b].map(|share| towards(camera, share * size_px));
            libm::atan2(a.cross(b).length(), a.dot(b)).to_degrees()
        };
        let field = |camera: &Pinhole| {
            let [x, y] = [DVec2::new(0.0, 0.5), DVec2::new(0.5, 0.0)].map(|from| between(camera, from, 1.0 - from));
            DVec2::new(x, y)
        };

        // Derive the disparity by the depth.
        let disparity = |depth: f64| {
            let at = point_mm * DVec3::new(1.0, 1.0, 0.0) + DVec3::Z * (point_mm.z * depth);
            let see = |k: usize| cameras[k].project(at).ok_or(Unmeasurable::BehindCamera { index: k });
            Ok::<f64, Unmeasurable>(see(0)?.x - see(1)?.x)
        };
        let by_mm = (disparity(1.0 + STEP)? - disparity(1.0 - STEP)?) / (2.0 * STEP * point_mm.z);
        Ok(Self {
            baseline_mm: baseline.length(),
            vergence_deg: (turn(left) - turn(right)).to_degrees(),
            field_deg: 0.5 * (field(left) + field(right)),
            depth_per_px_mm: -1.0 / by_mm,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose;

    /// f = 35 mm, 5.5 um pixels, 40 mm apart, images of 960 x 1080 px.
    fn pair(turn_rad: f64) -> [Pinhole; 2] {
        [-20.0, 20.0].map(|x| {
            let camera = Pinhole::parallel(DVec3::new(x, 0.0, 0.0), 35.0, 0.0055, DVec2::new(480.0, 540.0));
            let turn = Pose::new(DVec3::ZERO, DVec3::new(0.0, turn_rad * f64::signum(x), 0.0));
            Pinhole { camera_from_world: turn.after(&camera.camera_from_world), ..camera }
        })
    }

    #[test]
    fn the_geometry_of_a_pair_is_that_of_triangles() {
        let of = |turn: f64| {
            let [left, right] = pair(turn);
            PairGeometry::of([&left, &right], DVec2::new(960.0, 1080.0), DVec3::new(0.0, 0.0, 1000.0)).unwrap()
        };
        let parallel = of(0.0);
        assert!((parallel.baseline_mm - 40.0).abs() < 1e-12 && parallel.vergence_deg.abs() < 1e-12);
        let half = |mm: f64| 2.0 * libm::atan(mm / 35.0).to_degrees();
        assert!((parallel.field_deg - DVec2::new(half(2.64), half(2.97))).length() < 1e-11);
        // dZ/dd = Z^2 / (f B).
        let expected = 1e6 / (35.0 / 0.0055 * 40.0);
        assert!((parallel.depth_per_px_mm / expected - 1.0).abs() < 1e-7, "{}", parallel.depth_per_px_mm);
        // Each camera turned towards the other by 1 deg: its rays move the other way in its own frame.
        let [out, toed_in] = [1.0f64, -1.0].map(|deg| of(deg.to_radians()).vergence_deg);
        assert!((toed_in.abs() - 2.0).abs() < 1e-9 && (out + toed_in).abs() < 1e-9, "{out} {toed_in}");
        // Turned by a positive angle about y in its own frame, the right camera sees the ray of its centre to the left.
        assert!(out > 0.0, "{out}");
    }

    #[test]
    fn what_has_no_geometry_is_named() {
        let [left, _] = pair(0.0);
        let size = DVec2::new(960.0, 1080.0);
        assert!(matches!(PairGeometry::of([&left, &left], size, DVec3::Z), Err(Unmeasurable::Degenerate(_))));
        let [left, right] = pair(0.0);
        let behind = PairGeometry::of([&left, &right], size, -DVec3::Z);
        assert!(matches!(behind, Err(Unmeasurable::BehindCamera { index: 0 })));
    }
}
