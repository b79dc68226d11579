//! Pixels whose borders are no straight line, or are several: divided in four, and so is each part again, until what
//! borders are left in a part are one straight line.

use super::cut::{changes, pieces};
use super::centre_rays::trace_scalar;
use super::piece::{Piece, convex, piece_radiance};
use super::plan::Plan;
use super::pixel::{ended_ray_radiance, square};
use super::film::Class;
use super::work::Work;
use glam::DVec2;

/// Parts of a pixel at most.
const MOST_PARTS: u32 = 1 << 13;
/// A part's side is not divided below this, in px.
const SMALLEST_PX: f64 = 1.0 / 4096.0;
/// A part whose corners and middle are of one class is asked along its sides at this distance, in px: a border that bulges into
/// it between two of those places, with a radius of R px, takes less than 2e-5 / R of a pixel.
const ALONG_PX: f64 = 1.0 / 16.0;
/// Where along a border, as shares of its chord, it is compared with it.
const COMPARED: [f64; 3] = [0.25, 0.5, 0.75];

/// The mean radiance of the pixel at `px`. Where the parts at which the division ended are more of it than the bend
/// allowed, the pixel is counted as one without promise.
pub(super) fn along_borders(plan: &Plan, px: DVec2, work: &mut Work) -> f64 {
    let capped_before = work.counts.capped_pixels;
    let mut division = Division { plan, px, parts: 0, unresolved: 0.0 };
    let sum = division.quarters(DVec2::ZERO, 0.5 * plan.active, work);
    // Its pieces count as one pixel.
    let capped = work.counts.capped_pixels > capped_before;
    work.counts.capped_pixels = capped_before;
    work.counts.unpromised_pixels += u64::from(capped || division.unresolved > plan.system.accuracy().bend_px);
    sum
}

/// A pixel on its way to parts.
struct Division<'a> {
    plan: &'a Plan<'a>,
    px: DVec2,
    parts: u32,
    /// The share of the pixel's active square at which the division ended.
    unresolved: f64,
}

impl Division<'_> {
    /// The radiance over the four quarters of the square about `centre` of side 2 `half`.
    fn quarters(&mut self, centre: DVec2, half: f64, work: &mut Work) -> f64 {
        if 2.0 * half <= SMALLEST_PX || self.parts >= MOST_PARTS {
            let side = 2.0 * half / self.plan.active;
            self.unresolved += side * side;
            let outline = square(half).map(|corner| centre + corner);
            return convex(self.plan, self.px, &outline, work) * self.plan.throughput(self.px + centre);
        }
        let mut quarter = |x: f64, y: f64| self.square(centre + DVec2::new(x, y) * (0.5 * half), 0.5 * half, work);
        (quarter(-1.0, -1.0) + quarter(1.0, -1.0)) + (quarter(-1.0, 1.0) + quarter(1.0, 1.0))
    }

    /// The radiance over the square about `centre` of side 2 `half`: whole, cut along a border, or of its quarters.
    fn square(&mut self, centre: DVec2, half: f64, work: &mut Work) -> f64 {
        self.parts += 1;
        let corners = square(half).map(|corner| centre + corner);
        let classes = corners.map(|corner| self.class(corner, work));
        let own = self.class(centre, work);
        match changes(&classes)[..] {
            [] if classes[0] == own && self.is_whole(&corners, own, work) => {
                let whole = Piece { outline: corners.to_vec(), class: own };
                self.piece(&whole, work)
            }
            [first, second] if classes.contains(&own) => {
                let pieces = pieces(self.plan, self.px, &corners, &classes, [first, second], work);
                if pieces.iter().all(|piece| self.ends_straight(piece, work)) {
                    self.piece(&pieces[0], work) + self.piece(&pieces[1], work)
                } else {
                    self.quarters(centre, half, work)
                }
            }
            _ => self.quarters(centre, half, work),
        }
    }

    fn class(&self, at: DVec2, work: &mut Work) -> Class {
        work.counts.rays += 1;
        trace_scalar(self.plan.system, self.px + at).1
    }

    /// Whether places along the sides of a square are of the class that its corners have.
    fn is_whole(&self, corners: &[DVec2; 4], own: Class, work: &mut Work) -> bool {
        let steps = (corners[0].distance(corners[1]) / ALONG_PX) as u32;
        let mut is_own = |side: usize, k: u32| {
            let share = f64::from(k) / f64::from(steps);
            self.class(corners[side].lerp(corners[(side + 1) % 4], share), work) == own
        };
        (1..steps).all(|k| (0..4).all(|side| is_own(side, k)))
    }

    /// Whether the border of a piece strays from its chord by less than the bend allowed.
    fn ends_straight(&self, Piece { outline, class }: &Piece, work: &mut Work) -> bool {
        let bend_px = self.plan.system.accuracy().bend_px;
        let (from, to) = (outline[outline.len() - 1], outline[0]);
        let length = from.distance(to);
        // The corner that a shorter border cuts off is less than the bend times the pixel's side.
        if length * length <= bend_px {
            return true;
        }
        let inward = (to - from).perp() * (bend_px / length);
        COMPARED.iter().all(|share| {
            let at = from.lerp(to, *share);
            self.class(at + inward, work) == *class && self.class(at - inward, work) != *class
        })
    }

    /// The radiance over a piece of the class that it is said to be.
    fn piece(&self, piece: &Piece, work: &mut Work) -> f64 {
        if piece.class.side().is_some() {
            return piece_radiance(self.plan, self.px, piece, work);
        }
        let at = self.px + super::piece::middle(&piece.outline);
        ended_ray_radiance(self.plan, piece.class) * super::piece::share(self.plan, &piece.outline) * self.plan.throughput(at)
    }
}
