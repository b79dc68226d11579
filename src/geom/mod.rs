//! Points, rays and frames, in f64 and mm. Transforms are named `a_from_b`.

mod ray;
mod pose;
mod rect;
mod grid_point;
mod distortion;
mod calibrated_pinhole;

pub use calibrated_pinhole::CalibratedPinhole;
pub use distortion::Distortion;
pub use grid_point::GridPoint;
pub use pose::Pose;
pub use ray::Ray;
pub use rect::Rect;

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn pose_inverse_undoes_the_pose() {
        let pose = Pose::new(DVec3::new(1.0, -2.0, 3.0), DVec3::new(0.3, -0.8, 2.0));
        let p = DVec3::new(5.0, 7.0, -11.0);
        assert!((pose.inverse().point(pose.point(p)) - p).length() < 1e-14);
    }

    #[test]
    fn rotation_is_about_fixed_axes_in_the_order_x_y_z() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let pose = Pose::new(DVec3::ZERO, DVec3::new(quarter, 0.0, quarter));
        // y goes to z by the turn about x, and the turn about z leaves it there.
        assert!((pose.vector(DVec3::Y) - DVec3::Z).length() < 1e-15);
    }
}
