//! The shape of a pupil, and points that fill it evenly as seen from every side.
//!
//! What crosses the light of a pixel on its way to the pupil is mostly an edge: the share of the pupil on one side of a line. Points tell
//! that share as well as their shadows on the line's normal are spaced, each as far from the next as the pupil has equal shares of its
//! area. So each point is moved, again and again, to where its shadows in many directions should be: a descent of the sliced
//! Wasserstein distance (Paulin et al., "Sliced Optimal Transport Sampling", ACM Trans. Graph. 39, 2020). Shadows along the rows and the
//! columns of the picture count more, since the lines of a board run along them mostly.

use super::quadrature::turned;
use super::thin_lens::Aperture;
use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// Directions of the shadows, in half a turn: a multiple of two.
const DIRECTIONS: usize = 24;
/// The weight of those along rows and columns, of which others have 1.
const WEIGHT_OF_AXES: f64 = 8.0;
/// Times that all points are moved.
const MOVES: usize = 24;
/// Of more points than these the pupil's own parts are small, and they stay where they are.
const MOST_POINTS: usize = 1024;
/// Steps across the pupil by which the shares of its area are told.
const STEPS: usize = 512;

/// The shape of a pupil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pupil {
    /// Its radius: that of its corners where it has some.
    pub radius: f64,
    /// A disk or a polygon.
    pub aperture: Aperture,
}

impl Pupil {
    /// Its area, in units of its radius squared times that.
    pub fn area(&self) -> f64 {
        let unit = match self.aperture {
            Aperture::Circle => PI,
            Aperture::Polygon { blades, .. } => 0.5 * blades as f64 * libm::sin(TAU / blades as f64),
        };
        unit * self.radius * self.radius
    }

    /// The mean of x^2 over it, which is that of y^2: r^2 / 4 of a disk, r^2 (2 + cos(2 pi / n)) / 12 of a regular polygon of n sides.
    pub fn mean_square(&self) -> f64 {
        let unit = match self.aperture {
            Aperture::Circle => 0.25,
            Aperture::Polygon { blades, .. } => (2.0 + libm::cos(TAU / blades as f64)) / 12.0,
        };
        unit * self.radius * self.radius
    }

    /// Points in place of these, of which `turns` in a row are one, turned by equal parts of a full turn: as even as can be seen by
    /// their shadows.
    #[must_use]
    pub fn evened_out(&self, mut points: Vec<DVec2>, turns: usize) -> Vec<DVec2> {
        let count = points.len();
        if count > MOST_POINTS {
            return points;
        }
        let directions: Vec<(DVec2, f64, Vec<f64>)> = (0..DIRECTIONS)
            .map(|k| {
                let way = direction(PI * k as f64 / DIRECTIONS as f64);
                let weight = if (2 * k).is_multiple_of(DIRECTIONS) { WEIGHT_OF_AXES } else { 1.0 };
                (way, weight, self.shadows(way, count))
            })
            .collect();
        let weights: f64 = directions.iter().map(|(_, weight, _)| weight).sum();
        for _ in 0..MOVES {
            // Sum up how far each point's shadows are from their places.
            let mut moves = vec![DVec2::ZERO; count];
            let mut order: Vec<usize> = (0..count).collect();
            for (way, weight, places) in &directions {
                order.sort_by(|a, b| points[*a].dot(*way).total_cmp(&points[*b].dot(*way)).then(a.cmp(b)));
                for (&point, place) in order.iter().zip(places) {
                    moves[point] += *way * (weight * (place - points[point].dot(*way)));
                }
            }

            // Move the copies of a point alike. The mean of the squared cosines of all directions is a half.
            for (copies, moves) in points.chunks_mut(turns).zip(moves.chunks(turns)) {
                let back = |(turn, by): (usize, &DVec2)| turned(*by, (turns - turn) % turns, turns);
                let by: DVec2 = moves.iter().enumerate().map(back).sum();
                let moved = copies[0] + by * (2.0 / (weights * turns as f64));
                copies.iter_mut().enumerate().for_each(|(turn, copy)| *copy = turned(moved, turn, turns));
            }
        }
        points
    }

    /// The places along `way` of the shadows of `count` points, in order: the middles of as many equal shares of the area.
    fn shadows(&self, way: DVec2, count: usize) -> Vec<f64> {
        // Sum up the pupil's chords.
        let step = 2.0 * self.radius / STEPS as f64;
        let at = |k: usize| -self.radius + step * k as f64;
        let mut sums = vec![0.0; STEPS + 1];
        let mut before = self.chord(way, at(0));
        for k in 1..=STEPS {
            let chord = self.chord(way, at(k));
            sums[k] = sums[k - 1] + (before + chord);
            before = chord;
        }

        // Find each share between two of the sums.
        let mut k = 1;
        let place = |share: usize| {
            let wanted = sums[STEPS] * ((share as f64 + 0.5) / count as f64);
            while k < STEPS && sums[k] < wanted {
                k += 1;
            }
            at(k - 1) + step * ((wanted - sums[k - 1]) / (sums[k] - sums[k - 1]))
        };
        (0..count).map(place).collect()
    }

    /// The length of the pupil across `way` at a distance along it.
    fn chord(&self, way: DVec2, at: f64) -> f64 {
        let Aperture::Polygon { blades, rotation_rad } = self.aperture else {
            return 2.0 * (self.radius * self.radius - at * at).max(0.0).sqrt();
        };
        let corner = |k: usize| self.radius * direction(rotation_rad + TAU * k as f64 / blades as f64);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for (a, b) in (0..blades).map(|k| (corner(k), corner((k + 1) % blades))) {
            let share = (at - a.dot(way)) / (b - a).dot(way);
            if (0.0..=1.0).contains(&share) {
                let across = way.perp_dot(a.lerp(b, share));
                (least, most) = (least.min(across), most.max(across));
            }
        }
        (most - least).max(0.0)
    }
}

fn direction(angle_rad: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(angle_rad);
    DVec2::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::{Effects, Lens, Quadrature, ThinLens};

    fn points(aperture: Aperture, count: usize, fill: bool) -> Vec<DVec2> {
        let lens = Lens::Thin(ThinLens { focus_mm: 900.0, focal_mm: 35.0, radius_mm: 2.0, aperture });
        let quadrature = Quadrature { points: count, fill, ..Quadrature::default() };
        let effects = Effects { lens, quadrature, ..Effects::default() };
        effects.variants(0).iter().map(|variant| variant.pupil).collect()
    }

    /// How far the share of points on one side of a line is from that of the pupil, which many points tell, at most and by its root
    /// mean square.
    fn off(points: &[DVec2], all: &[DVec2], way: DVec2) -> f64 {
        let share = |of: &[DVec2], at: f64| of.iter().filter(|p| p.dot(way) < at).count() as f64 / of.len() as f64;
        let places = (0..200).map(|k| 4.0 * (f64::from(k) + 0.5) / 200.0 - 2.0);
        let off = places.map(|at| share(points, at) - share(all, at));
        (off.map(|off| off * off).sum::<f64>() / 200.0).sqrt()
    }

    /// Steps of 1/n that lie in the middle of their shares are off by 1/n over the root of 12; pairs of points share one line at worst.
    #[test]
    fn the_share_on_one_side_of_a_line_is_told_by_few_points() {
        let blades = |blades| Aperture::Polygon { blades, rotation_rad: 0.4 };
        for aperture in [Aperture::Circle, blades(5), blades(6)] {
            let all = points(aperture, 8192, false);
            for count in [8, 20, 64] {
                let [plain, even] = [false, true].map(|fill| points(aperture, count, fill));
                let least = 1.0 / (even.len() as f64 * libm::sqrt(12.0));
                // Of whole turns by a fifth each, several have one shadow.
                let twofold = aperture != blades(5);
                for axis in [DVec2::X, DVec2::Y].into_iter().filter(|_| twofold) {
                    let [plain, even] = [&plain, &even].map(|points| off(points, &all, axis));
                    assert!(even < 1.5 * least, "{aperture:?} {count}: {even} {least}, plain {plain}");
                }
                let over = |of: &[DVec2]| (0..40).map(|k| off(of, &all, direction(0.08 * f64::from(k)))).sum::<f64>();
                assert!(over(&even) < over(&plain), "{aperture:?} {count}: {} {}", over(&even), over(&plain));
                assert!(even.iter().all(|p| p.length() <= 2.0));
                let middle: DVec2 = even.iter().sum();
                assert!(middle.length() < 1e-12, "{middle}");
            }
        }
    }

    /// Closed forms against many points of the pupil.
    #[test]
    fn areas_and_squares_are_those_of_the_shape() {
        for aperture in [Aperture::Circle, Aperture::Polygon { blades: 3, rotation_rad: 0.2 }] {
            let pupil = Pupil { radius: 2.0, aperture };
            let chords = (0..4000).map(|k| pupil.chord(DVec2::X, 4.0 * (f64::from(k) + 0.5) / 4000.0 - 2.0));
            assert!((chords.sum::<f64>() * 4.0 / 4000.0 / pupil.area() - 1.0).abs() < 1e-3, "{aperture:?}");
            let all = points(aperture, 4096, false);
            let square = all.iter().map(|p| p.x * p.x).sum::<f64>() / all.len() as f64;
            assert!((square / pupil.mean_square() - 1.0).abs() < 5e-3, "{aperture:?} {square}");
        }
    }
}
