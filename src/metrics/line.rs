//! The best line through points of an image.

use super::deviation::{Unmeasurable, all_finite, at_least};
use glam::DVec2;

/// A line by a point on it and a unit direction with x >= 0 (y > 0 where x = 0), in px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// A point on the line.
    pub point_px: DVec2,
    /// Unit direction.
    pub direction: DVec2,
}

impl Line {
    /// The line of total least squares: least sum of squared perpendicular distances over the points given, each with
    /// the same weight.
    ///
    /// # Errors
    /// [`Unmeasurable::TooFew`] below 2 points, [`Unmeasurable::NotFinite`], and [`Unmeasurable::Degenerate`] when the
    /// points spread equally in all directions (or not at all), so that every line is as good.
    pub fn through(points: &[DVec2]) -> Result<Self, Unmeasurable> {
        at_least("points on a line", points.len(), 2)?;
        all_finite("point", points, |p| p.is_finite())?;
        let centroid = points[0] + points.iter().map(|p| *p - points[0]).sum::<DVec2>() / points.len() as f64;
        let (mut sxx, mut sxy, mut syy) = (0.0, 0.0, 0.0);
        for p in points {
            let d = *p - centroid;
            sxx += d.x * d.x;
            sxy += d.x * d.y;
            syy += d.y * d.y;
        }
        // The scatter matrix is a multiple of the unit matrix plus a part of size `spread` along the line.
        let spread = libm::hypot(sxx - syy, 2.0 * sxy);
        // Points that differ by the rounding of their own coordinates have no direction.
        let largest = points.iter().fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
        let rounding = 64.0 * f64::EPSILON * largest;
        let floor = rounding * rounding * points.len() as f64;
        if !spread.is_finite() || spread <= floor.max(1e-12 * (sxx + syy)) {
            return Err(Unmeasurable::Degenerate("the points single out no direction"));
        }
        let angle = 0.5 * libm::atan2(2.0 * sxy, sxx - syy);
        let (sin, cos) = libm::sincos(angle);
        Ok(Self { point_px: centroid, direction: DVec2::new(cos, sin) })
    }

    /// The line through two points (the chord of a row's end corners).
    ///
    /// # Errors
    /// [`Unmeasurable::Degenerate`] when the two are one, or not finite.
    pub fn chord(a: DVec2, b: DVec2) -> Result<Self, Unmeasurable> {
        let direction = if b.x < a.x { a - b } else { b - a }.try_normalize();
        let direction = direction.ok_or(Unmeasurable::Degenerate("the two ends of a chord coincide"))?;
        Ok(Self { point_px: a, direction })
    }

    /// Signed perpendicular distance of `p`, in px: above zero on the +y side of a horizontal line.
    pub fn distance(&self, p: DVec2) -> f64 {
        self.direction.perp_dot(p - self.point_px)
    }

    /// Angle from +x towards +y, in rad, within [-pi/2, pi/2].
    pub fn slope_rad(&self) -> f64 {
        libm::atan2(self.direction.y, self.direction.x)
    }

    /// Length of the points' projection onto the line, in px.
    pub fn extent(&self, points: &[DVec2]) -> f64 {
        let along = points.iter().map(|p| self.direction.dot(*p - self.point_px));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
        (high - low).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn total_least_squares_is_not_regression() {
        // A cross of points: (+-2, 0) and (0, +-1). The best line is the x axis, at distances 0, 0, 1, 1.
        let points = [DVec2::new(2.0, 0.0), DVec2::new(-2.0, 0.0), DVec2::new(0.0, 1.0), DVec2::new(0.0, -1.0)];
        let line = Line::through(&points).unwrap();
        assert_eq!((line.slope_rad(), line.distance(points[2]), line.distance(points[3])), (0.0, 1.0, -1.0));
        assert_eq!(line.extent(&points), 4.0);
        // Turned by a right angle it is the y axis, where a regression of y on x would fail.
        let turned: Vec<_> = points.iter().map(|p| p.perp()).collect();
        assert!((Line::through(&turned).unwrap().slope_rad().abs() - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    }

    #[test]
    fn one_point_coincident_points_and_a_square_have_no_line() {
        let square = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
        assert!(matches!(Line::through(&square), Err(Unmeasurable::Degenerate(_))));
        assert!(matches!(Line::through(&[DVec2::ONE; 5]), Err(Unmeasurable::Degenerate(_))));
        assert!(matches!(Line::through(&[DVec2::ONE]), Err(Unmeasurable::TooFew { found: 1, .. })));
        assert!(matches!(Line::through(&[DVec2::ONE, DVec2::NAN]), Err(Unmeasurable::NotFinite { index: 1, .. })));
        assert!(Line::chord(DVec2::ONE, DVec2::ONE).is_err());
    }

    proptest! {
        #[test]
        fn distances_do_not_change_when_points_and_line_move_together(
            points in prop::collection::vec((-1e3..1e3, -1e3..1e3), 3..20),
            angle in -3.2..3.2, shift in (-1e4..1e4, -1e4..1e4),
        ) {
            let points: Vec<DVec2> = points.into_iter().map(DVec2::from).collect();
            let line = Line::through(&points);
            prop_assume!(line.is_ok());
            let (sin, cos) = libm::sincos(angle);
            let turn = DVec2::new(cos, sin);
            let moved: Vec<DVec2> = points.iter().map(|p| turn.rotate(*p) + DVec2::from(shift)).collect();
            let rms = |line: Line, points: &[DVec2]| {
                crate::num::stats::rms(&points.iter().map(|p| line.distance(*p)).collect::<Vec<_>>())
            };
            // Positions of up to 1e4 px carry 2e-12 px of rounding.
            let (a, b) = (rms(line.unwrap(), &points), rms(Line::through(&moved).unwrap(), &moved));
            prop_assert!((a - b).abs() < 1e-9, "{a} {b}");
        }

        #[test]
        fn no_turned_line_through_the_centroid_fits_better(
            points in prop::collection::vec((-1e3..1e3, -1e3..1e3), 3..20), angle in 0.01..3.1,
        ) {
            let points: Vec<DVec2> = points.into_iter().map(DVec2::from).collect();
            let line = Line::through(&points);
            prop_assume!(line.is_ok());
            let line = line.unwrap();
            let (sin, cos) = libm::sincos(angle);
            let other = Line { direction: DVec2::new(cos, sin).rotate(line.direction), ..line };
            let sum = |l: Line| points.iter().map(|p| l.distance(*p) * l.distance(*p)).sum::<f64>();
            prop_assert!(sum(line) <= sum(other) * (1.0 + 1e-12));
        }
    }
}
