//! Rectification: one homography for each image of a pair, after which the rows are the epipolar lines of its two cameras.
//!
//! Both images are seen by cameras at the same two centres, alike and parallel, whose x axis is the baseline (Fusiello, Trucco &
//! Verri, "A compact algorithm for rectification of stereo pairs", 2000).

use super::deviation::Unmeasurable;
use super::observation::Pair;
use super::pinhole::Pinhole;
use glam::{DMat3, DVec2, DVec3};

/// The turn from the world to the frame of a rectified pair: x along the line `apart_mm` between the centres, towards +x of the
/// world, and z across it, nearest to `axes`, the sum of the directions in which the two cameras look.
///
/// # Errors
/// [`Unmeasurable::Degenerate`] where both have one centre, or look along the line between the two.
pub(crate) fn common_frame(apart_mm: DVec3, axes: DVec3) -> Result<DMat3, Unmeasurable> {
    let x = apart_mm.try_normalize().ok_or(Unmeasurable::Degenerate("both cameras have one centre"))?;
    let x = if x.x < 0.0 { -x } else { x };
    let z = (axes - x * axes.dot(x))
        .try_normalize()
        .ok_or(Unmeasurable::Degenerate("the cameras look along the line between them"))?;
    Ok(DMat3::from_cols(x, z.cross(x), z).transpose())
}

/// The homographies of the left and of the right image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rectification {
    /// From (x, y, 1) in px of the image to what is (x, y, 1) in px of the rectified image, but for a factor.
    maps: [DMat3; 2],
}

impl Rectification {
    /// That of the left and the right camera.
    ///
    /// # Errors
    /// [`Unmeasurable::Degenerate`] where both have one centre, or look along the line between the two.
    pub(crate) fn of(cameras: [&Pinhole; 2]) -> Result<Self, Unmeasurable> {
        let [left, right] = cameras;
        let axes: DVec3 = cameras.iter().map(|c| c.camera_from_world.rotation.transpose() * DVec3::Z).sum();
        let common_from_world = common_frame(right.centre_mm() - left.centre_mm(), axes)?;

        // Give both the mean focal length along y and the left principal point.
        let focal_px = 0.5 * (left.focal_px.y + right.focal_px.y);
        let inside = |focal_px: DVec2, principal_px: DVec2| {
            DMat3::from_cols(DVec3::X * focal_px.x, DVec3::Y * focal_px.y, principal_px.extend(1.0))
        };
        let common = inside(DVec2::splat(focal_px), left.principal_px);
        let map = |camera: &Pinhole| {
            let directions =
                camera.camera_from_world.rotation.transpose() * inside(camera.focal_px, camera.principal_px).inverse();
            common * common_from_world * directions
        };
        Ok(Self { maps: cameras.map(map) })
    }

    /// Matched corners in the rectified images.
    ///
    /// # Errors
    /// [`Unmeasurable::BehindCamera`] where one lies behind a rectified image.
    pub(crate) fn pairs(&self, pairs: &[Pair]) -> Result<Vec<Pair>, Unmeasurable> {
        let seen = |map: &DMat3, px: DVec2, index: usize| {
            let mapped = *map * px.extend(1.0);
            if mapped.z > 0.0 { Ok(mapped.truncate() / mapped.z) } else { Err(Unmeasurable::BehindCamera { index }) }
        };
        let [left, right] = &self.maps;
        let of = |(k, pair): (usize, &Pair)| {
            Ok(Pair { left_px: seen(left, pair.left_px, k)?, right_px: seen(right, pair.right_px, k)?, ..*pair })
        };
        pairs.iter().enumerate().map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose;
    use crate::metrics::stereo;

    /// Two cameras that look askew, at different heights.
    fn cameras() -> [Pinhole; 2] {
        [(-20.0, 0.04, 0.0), (20.0, -0.06, 1.5)].map(|(x, turn, up)| {
            let camera = Pinhole::parallel(DVec3::new(x, up, 0.0), 35.0, 0.0055, DVec2::new(480.0, 540.0));
            let turn = Pose::new(DVec3::ZERO, DVec3::new(0.02 * turn, turn, 0.5 * turn));
            Pinhole { camera_from_world: turn.after(&camera.camera_from_world), ..camera }
        })
    }

    #[test]
    fn rows_are_epipolar_lines_afterwards() {
        let [left, right] = cameras();
        let see = |i: i32, j: i32| {
            let point = DVec3::new(40.0 * f64::from(i), 30.0 * f64::from(j), 700.0 + 37.0 * f64::from(i * j));
            Pair { index: [i, j], left_px: left.project(point).unwrap(), right_px: right.project(point).unwrap() }
        };
        let pairs: Vec<Pair> = (-2..=2).flat_map(|i| (-2..=2).map(move |j| (i, j))).map(|(i, j)| see(i, j)).collect();
        let raw = stereo::disparity(&pairs).unwrap();
        let rectified = Rectification::of([&left, &right]).unwrap().pairs(&pairs).unwrap();
        let straight = stereo::disparity(&rectified).unwrap();
        assert!(raw.vertical_rms_px > 10.0 && straight.vertical_max_px < 1e-9, "{raw:?} {straight:?}");
        // Disparity is f B / Z of the parallel cameras, so nearer points have the larger one.
        assert!(straight.horizontal_range_px[0] > 0.0, "{straight:?}");
    }

    #[test]
    fn what_cannot_be_rectified_is_named() {
        let [left, right] = cameras();
        assert!(matches!(Rectification::of([&left, &left]), Err(Unmeasurable::Degenerate(_))));
        // Of two rays across the axis of a camera one runs backwards in a frame that is turned against it.
        let rectification = Rectification::of([&left, &right]).unwrap();
        let far = |x: f64| {
            rectification.pairs(&[Pair { index: [0, 0], left_px: DVec2::new(x, 540.0), right_px: DVec2::ZERO }])
        };
        let behind = |found: &Result<Vec<Pair>, _>| *found == Err(Unmeasurable::BehindCamera { index: 0 });
        assert_eq!([-1e9, 1e9].map(far).iter().filter(|found| behind(found)).count(), 1);
    }
}
