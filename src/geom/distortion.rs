//! The distortion of a lens: the model of Brown (1966) and Conrady (1919) in OpenCV's form, and its exact inverse.

use glam::{DMat2, DVec2};

/// Newton's method gives up after so many steps: from a start on the same branch it takes four or five.
const MOST_STEPS: usize = 32;
/// A step of Newton's method below this share of the place is the last: it leaves less than its square.
const LAST_STEP: f64 = 1e-9;
/// The steps in which a place is followed from the centre where Newton's method does not find it at once, as shares of the way:
/// the longest, and the shortest, at which a fold is taken to be reached.
const LONGEST_STEP: f64 = 1.0 / 64.0;
const SHORTEST_STEP: f64 = 1e-9;
/// Steps in all: a way that takes more is as good as folded.
const MOST_FOLLOWED: usize = 1024;
/// Places between two of those steps, and between the centre and a direction that is found at once, at which the map must keep
/// its orientation.
const BETWEEN: usize = 8;

/// How a lens bends the picture of a pinhole.
///
/// It maps undistorted to distorted normalised coordinates, tangents x and y of the direction of a ray and of the place
/// where it meets the sensor:
///
/// ```text
/// x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
/// y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
/// ```
///
/// with r^2 = x^2 + y^2. The default distorts nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Distortion {
    /// k1, k2, k3.
    radial: [f64; 3],
    /// p1, p2.
    tangential: [f64; 2],
}

impl Distortion {
    /// The distortion of the coefficients k1, k2, p1, p2, k3, in OpenCV's order.
    pub const fn new([k1, k2, p1, p2, k3]: [f64; 5]) -> Self {
        Self { radial: [k1, k2, k3], tangential: [p1, p2] }
    }

    /// k1, k2, p1, p2, k3.
    pub const fn coefficients(&self) -> [f64; 5] {
        let ([k1, k2, k3], [p1, p2]) = (self.radial, self.tangential);
        [k1, k2, p1, p2, k3]
    }

    /// Whether it changes nothing.
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }

    /// Where the direction `u` is seen.
    pub fn distort(&self, u: DVec2) -> DVec2 {
        let ([k1, k2, k3], [p1, p2]) = (self.radial, self.tangential);
        let DVec2 { x, y } = u;
        let square = u.length_squared();
        let radial = 1.0 + square * (k1 + square * (k2 + square * k3));
        DVec2::new(
            x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
            y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
        )
    }

    /// d distort / d u; it is symmetric.
    pub fn jacobian(&self, u: DVec2) -> DMat2 {
        let ([k1, k2, k3], [p1, p2]) = (self.radial, self.tangential);
        let DVec2 { x, y } = u;
        let square = u.length_squared();
        let radial = 1.0 + square * (k1 + square * (k2 + square * k3));
        // Of the radial factor, by r^2.
        let slope = k1 + square * (2.0 * k2 + square * (3.0 * k3));
        let mixed = 2.0 * (x * y * slope + p1 * x + p2 * y);
        DMat2::from_cols(
            DVec2::new(radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, mixed),
            DVec2::new(mixed, radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x),
        )
    }

    /// The direction that is seen at `d`: of several the one that joins on to the centre. Beyond the places at which the lens
    /// shows anything, the picture goes on evenly, so that every place has a direction.
    pub fn undistort(&self, d: DVec2) -> DVec2 {
        let joins_on =
            |u: &DVec2| (1..BETWEEN).all(|part| self.keeps(DVec2::ZERO.lerp(*u, part as f64 / BETWEEN as f64)));
        self.newton(d, d).filter(joins_on).unwrap_or_else(|| {
            let Followed { seen, direction } = self.follow(d);
            // The same factor as at the last place there is.
            if seen == d { direction } else { direction * (d.length() / seen.length().max(f64::MIN_POSITIVE)) }
        })
    }

    /// How much of the way from the centre to `d` the map goes without a fold: 1 for all of it.
    pub(super) fn unfolded(&self, d: DVec2) -> f64 {
        let seen = self.follow(d).seen;
        if seen == d { 1.0 } else { seen.length() / d.length() }
    }

    /// Whether the map keeps its orientation at `u`.
    fn keeps(&self, u: DVec2) -> bool {
        self.jacobian(u).determinant() > 0.0
    }

    /// The direction that is seen at `d`, from one nearby; `None` where the steps leave the branch on which the map keeps its
    /// orientation, or do not end.
    fn newton(&self, start: DVec2, d: DVec2) -> Option<DVec2> {
        let mut u = start;
        for _ in 0..MOST_STEPS {
            let slope = self.jacobian(u);
            // NaN must not pass.
            if slope.determinant().is_nan() || slope.determinant() <= 0.0 {
                return None;
            }
            let step = slope.inverse() * (d - self.distort(u));
            u += step;
            if step.length_squared() <= LAST_STEP * LAST_STEP * d.length_squared() {
                return self.keeps(u).then_some(u);
            }
        }
        None
    }

    /// Follows the directions that are seen along the way from the centre to `d`, as far as they go without a fold.
    fn follow(&self, d: DVec2) -> Followed {
        let mut last = Followed { seen: DVec2::ZERO, direction: DVec2::ZERO };
        let (mut share, mut step) = (0.0, LONGEST_STEP);
        for _ in 0..MOST_FOLLOWED {
            if share == 1.0 || step < SHORTEST_STEP {
                break;
            }
            let next = f64::min(share + step, 1.0);
            match self.next(&last, if next == 1.0 { d } else { d * next }) {
                Some(there) => {
                    (last, share) = (there, next);
                    step = f64::min(2.0 * step, LONGEST_STEP);
                }
                // It may be the step that is too long.
                None => step *= 0.25,
            }
        }
        last
    }

    /// What follows on `last` at `seen`; `None` where there may be a fold between the two.
    fn next(&self, last: &Followed, seen: DVec2) -> Option<Followed> {
        let ahead = self.jacobian(last.direction).inverse() * (seen - last.seen);
        let direction = self.newton(last.direction + ahead, seen)?;
        let keeps = |part: usize| self.keeps(last.direction.lerp(direction, part as f64 / BETWEEN as f64));
        (1..BETWEEN).all(keeps).then_some(Followed { seen, direction })
    }
}

/// A direction, and where it is seen.
#[derive(Debug, Clone, Copy)]
struct Followed {
    seen: DVec2,
    direction: DVec2,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Barrels and pincushions up to where they fold, with tangential terms.
    const LENSES: [[f64; 5]; 6] = [
        [-0.3, 0.1, 0.0, 0.0, 0.0],
        [0.5, -0.2, 0.003, -0.002, 0.1],
        [-0.9, 1.1, -0.01, 0.02, -0.6],
        [-0.33, 0.0, 0.0, 0.0, 0.0],
        [2.0, 3.0, 0.05, -0.04, 5.0],
        [0.0, 0.0, 0.1, 0.1, 0.0],
    ];

    /// Newton's method alone steps over a fold to a direction on the other side of the centre.
    #[test]
    fn a_direction_beyond_a_fold_is_not_taken() {
        let lens = Distortion::new([
            -0.689_039_725_215_688_2,
            1.392_605_927_790_574_5,
            0.027_502_008_919_956_175,
            0.023_677_819_193_959_46,
            -0.252_892_978_303_241_1,
        ]);
        let u = DVec2::new(1.420_707_541_033_666, 0.754_995_851_605_519_5);
        assert!((lens.undistort(lens.distort(u)) - u).length() < 1e-12);
    }

    #[test]
    fn the_jacobian_is_the_slope() {
        let step = 1e-6;
        for distortion in LENSES.map(Distortion::new) {
            for u in [DVec2::new(0.3, -0.2), DVec2::new(-0.5, 0.4), DVec2::ZERO] {
                let slope = |way: DVec2| (distortion.distort(u + way) - distortion.distort(u - way)) / (2.0 * step);
                let found = DMat2::from_cols(slope(DVec2::X * step), slope(DVec2::Y * step));
                // A third derivative below 1e3 over 6, and roundings of 1 over the step.
                let off = found - distortion.jacobian(u);
                assert!(off.x_axis.abs().max(off.y_axis.abs()).max_element() < 1e3 / 6.0 * 1e-12 + 1e-9, "{off:?}");
            }
        }
    }

    /// r' = r + k r^3 with k = -1/3 folds at r = 1, where r' = 2/3.
    #[test]
    fn a_fold_is_where_the_closed_form_has_it() {
        let lens = Distortion::new([-1.0 / 3.0, 0.0, 0.0, 0.0, 0.0]);
        for (reach, part) in [(0.6, 1.0), (0.66, 1.0), (0.7, 2.0 / 2.1), (2.0, 1.0 / 3.0)] {
            let found = lens.unfolded(DVec2::new(0.6, 0.8) * reach);
            // Within the steps at which it ends, and roundings.
            assert!((found - part).abs() < 8.0 * SHORTEST_STEP, "{reach}: {found}");
        }
        // The place at which r = 0.95 is seen has another direction too, beyond the fold.
        let seen = 0.95 - 0.95 * 0.95 * 0.95 / 3.0;
        assert!((lens.undistort(DVec2::new(0.0, seen)) - DVec2::new(0.0, 0.95)).length() < 1e-14);
    }

    #[test]
    fn what_lies_beyond_a_fold_has_directions_that_join_on() {
        let lens = Distortion::new([-1.0 / 3.0, 0.0, 0.0, 0.0, 0.0]);
        let mut last = 0.0;
        for k in 0..200 {
            let u = lens.undistort(DVec2::new(0.01 * f64::from(k), 0.0));
            // At the fold a place moves by the square of its direction's step.
            assert!(u.is_finite() && u.y == 0.0 && u.x >= last && u.x - last < 0.2, "{k}: {u}");
            last = u.x;
        }
    }

    #[test]
    fn no_distortion_changes_no_bit() {
        let u = DVec2::new(0.123_456_789, -1.987_654_321);
        let none = Distortion::default();
        assert!(none.distort(u) == u && none.undistort(u) == u && none.unfolded(u) == 1.0);
    }
}
