//! A pinhole camera as a calibration describes it: turned, with a scale along x and y, seen through a lens that distorts.

use super::distortion::Distortion;
use glam::{DMat3, DVec2, DVec3};

/// The sensor is grown by this share of its width and height on every side where its distortion is judged.
const MARGIN: f64 = 0.05;
/// Places along each side of the sensor at which its distortion is judged.
const PLACES: usize = 33;

/// A pinhole with distortion. Places on the sensor are counted in px from its principal point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibratedPinhole {
    /// Tangents of the field angles per pixel, right and down, near the principal point: 1 / fx and 1 / fy.
    pub tangent_per_px: DVec2,
    /// What its lens does to the tangents.
    pub distortion: Distortion,
    /// The camera's frame in the world.
    pub rotation: DMat3,
    /// Taken from the undistorted tangents: how far the rays of this point of an aperture lean from those of its middle.
    pub lean: DVec2,
}

impl CalibratedPinhole {
    /// The unit direction, in the world, that is seen at `place_px`.
    pub fn direction(&self, place_px: DVec2) -> DVec3 {
        (self.rotation * self.tangents(place_px).extend(1.0)).normalize()
    }

    fn tangents(&self, place_px: DVec2) -> DVec2 {
        self.distortion.undistort(place_px * self.tangent_per_px) - self.lean
    }

    /// Where a direction of the world is seen; `None` where it points backwards.
    pub fn project(&self, direction: DVec3) -> Option<DVec2> {
        let own = self.rotation.transpose() * direction;
        let seen = || self.distortion.distort(own.truncate() / own.z + self.lean) / self.tangent_per_px;
        (own.z > 0.0).then(seen)
    }

    /// How [`CalibratedPinhole::direction`] changes by a px to the right and by one down.
    pub fn differentials(&self, place_px: DVec2) -> [DVec3; 2] {
        let undistorted = self.distortion.undistort(place_px * self.tangent_per_px);
        let slope = self.distortion.jacobian(undistorted).inverse();
        let along = (undistorted - self.lean).extend(1.0);
        let length = along.length();
        let own = along / length;
        let turn = |step: DVec2| {
            let step = step.extend(0.0);
            self.rotation * ((step - own * own.dot(step)) / length)
        };
        [turn(slope.x_axis * self.tangent_per_px.x), turn(slope.y_axis * self.tangent_per_px.y)]
    }

    /// The same with `n` x `n` pixels in place of each.
    #[must_use]
    pub fn sampled(&self, n: f64) -> Self {
        Self { tangent_per_px: self.tangent_per_px / n, ..*self }
    }

    /// Whether straight lines are seen as straight lines.
    pub fn keeps_lines(&self) -> bool {
        self.distortion.is_nothing()
    }

    /// A place, in px from the principal point, beyond which the distortion folds the picture over inside a sensor from `low`
    /// to `high`, or within a twentieth of its size around: two directions would be seen in one place. `None` where none is.
    pub fn fold_px(&self, low: DVec2, high: DVec2) -> Option<DVec2> {
        let margin = MARGIN * (high - low);
        let (low, high) = (low - margin, high + margin);
        let share = |k: usize| k as f64 / (PLACES - 1) as f64;
        let around = |k: usize| {
            let (x, y) = (low.x + (high.x - low.x) * share(k), low.y + (high.y - low.y) * share(k));
            [DVec2::new(x, low.y), DVec2::new(x, high.y), DVec2::new(low.x, y), DVec2::new(high.x, y)]
        };
        // The ways from the principal point to the border pass through every pixel.
        let ways = (0..PLACES).flat_map(around).map(|end| {
            let unfolded = self.distortion.unfolded(end * self.tangent_per_px);
            (unfolded, end * unfolded)
        });
        let nearest = ways.filter(|(unfolded, _)| *unfolded < 1.0);
        nearest.min_by(|a, b| a.1.length().total_cmp(&b.1.length())).map(|(_, place)| place)
    }
}
