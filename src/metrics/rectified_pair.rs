//! A rectified pair: two pinholes, alike and parallel, whose x axis is the line between their centres, so that both see a point in
//! one row, and its disparity is f b/Z and a constant.

use super::deviation::Unmeasurable;
use super::pinhole::Pinhole;
use super::rectification::common_frame;
use crate::geom::Pose;
use glam::{DMat3, DVec2, DVec3};

/// What a camera of the pair is made from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CentreAndLook {
    /// Its centre, in the world, in mm.
    pub centre_mm: DVec3,
    /// A direction in the world, of any length.
    pub direction: DVec3,
    /// The image position that is to look along it, in px; the row is the mean of both cameras'.
    pub image_px: DVec2,
}

/// The left and the right camera of a rectified pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectifiedPair {
    common_from_world: DMat3,
    cameras: [Pinhole; 2],
}

impl RectifiedPair {
    /// The pair of one focal length along x and one along y, in px, at two centres: both the same where pixels are square.
    ///
    /// # Errors
    /// [`Unmeasurable::Degenerate`] where both have one centre, or look along the line between the two or away from each other.
    pub fn new(of: [CentreAndLook; 2], focal_px: DVec2) -> Result<Self, Unmeasurable> {
        // Turn both into the common frame.
        let axes: DVec3 = of.iter().map(|c| c.direction.normalize_or_zero()).sum();
        let common_from_world = common_frame(of[1].centre_mm - of[0].centre_mm, axes)?;
        let looks = of.map(|c| common_from_world * c.direction);
        if looks.iter().any(|look| look.z <= 0.0) {
            return Err(Unmeasurable::Degenerate("the cameras look along the line between them"));
        }

        // Lay the images so that each keeps its column there, and both together the row.
        let principal = [0, 1].map(|k| of[k].image_px - looks[k].truncate() / looks[k].z * focal_px);
        let row = 0.5 * (principal[0].y + principal[1].y);
        let camera = |k: usize| Pinhole {
            camera_from_world: Pose {
                rotation: common_from_world,
                translation_mm: -(common_from_world * of[k].centre_mm),
            },
            focal_px,
            principal_px: DVec2::new(principal[k].x, row),
        };
        Ok(Self { common_from_world, cameras: [camera(0), camera(1)] })
    }

    /// The left and the right camera.
    pub fn cameras(&self) -> &[Pinhole; 2] {
        &self.cameras
    }

    /// The turn from the world to the frame of both cameras.
    pub fn common_from_world(&self) -> DMat3 {
        self.common_from_world
    }

    /// The focal lengths of both along x and y, in px.
    pub fn focal_px(&self) -> DVec2 {
        self.cameras[0].focal_px
    }

    /// How far right of the left centre the right one is, in mm; below 0 where it is left of it.
    pub fn baseline_mm(&self) -> f64 {
        self.cameras[0].camera_from_world.translation_mm.x - self.cameras[1].camera_from_world.translation_mm.x
    }

    /// x_L - x_R of a point at infinity, in px.
    pub fn offset_px(&self) -> f64 {
        self.cameras[0].principal_px.x - self.cameras[1].principal_px.x
    }

    /// How far the centres lie before the point at `point_mm` of the world, along the axis of the pair, in mm.
    pub fn ahead_of_mm(&self, point_mm: DVec3) -> f64 {
        -self.cameras[0].camera_from_world.point(point_mm).z
    }

    /// The depth from the line between the centres, in mm, of a point with the disparity x_L - x_R in px.
    pub fn depth_mm(&self, disparity_px: f64) -> f64 {
        self.focal_px().x * self.baseline_mm() / (disparity_px - self.offset_px())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two centres at different heights, which look askew.
    fn pair(flip: bool) -> RectifiedPair {
        let of = [(-8.0, 0.3, -0.02), (9.0, -0.2, 0.05)].map(|(x, y, turn)| CentreAndLook {
            centre_mm: DVec3::new(if flip { -x } else { x }, y, 4.0 + y),
            direction: DVec3::new(turn, 0.01, 1.0) * 700.0,
            image_px: DVec2::new(480.0, 540.0),
        });
        RectifiedPair::new(of, DVec2::new(6300.0, 6400.0)).unwrap()
    }

    #[test]
    fn a_point_is_in_one_row_and_its_disparity_is_its_depth() {
        for pair in [pair(false), pair(true)] {
            let [left, right] = pair.cameras();
            for (x, y, z) in [(30.0, -20.0, 500.0), (-90.0, 40.0, 1000.0), (0.0, 300.0, 9000.0)] {
                let point = DVec3::new(x, y, z);
                let seen = [left, right].map(|camera| camera.project(point).unwrap());
                let depth = left.camera_from_world.point(point).z;
                assert!((seen[0].y - seen[1].y).abs() < 1e-9, "{seen:?}");
                assert!((pair.depth_mm(seen[0].x - seen[1].x) / depth - 1.0).abs() < 1e-9, "{seen:?}");
            }
            let apart = right.centre_mm() - left.centre_mm();
            assert!((pair.baseline_mm().abs() - apart.length()).abs() < 1e-12);
            assert_eq!(pair.baseline_mm() > 0.0, apart.x > 0.0);
        }
    }

    #[test]
    fn images_keep_the_columns_of_what_they_look_at() {
        let pair = pair(false);
        for (k, turn) in [(0, -0.02), (1, 0.05)] {
            let camera = pair.cameras()[k];
            let seen = camera.project(camera.centre_mm() + DVec3::new(turn, 0.01, 1.0)).unwrap();
            assert!((seen.x - 480.0).abs() < 1e-9, "{seen}");
        }
    }

    #[test]
    fn one_centre_and_a_look_along_the_line_are_no_pair() {
        let at = |x: f64, direction: DVec3| CentreAndLook {
            centre_mm: DVec3::new(x, 0.0, 0.0),
            direction,
            image_px: DVec2::ZERO,
        };
        let refused = |of| matches!(RectifiedPair::new(of, DVec2::splat(6400.0)), Err(Unmeasurable::Degenerate(_)));
        assert!(refused([at(1.0, DVec3::Z), at(1.0, DVec3::Z)]));
        assert!(refused([at(0.0, DVec3::X), at(1.0, DVec3::X)]));
        assert!(refused([at(0.0, DVec3::Z * 3.0), at(1.0, -DVec3::Z + DVec3::X)]));
        assert!(!refused([at(0.0, DVec3::Z), at(1.0, DVec3::Z)]));
    }
}
