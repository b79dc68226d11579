//! Pixels whose borders are no straight line, or are several: divided in four, and so is each part again, until what
//! borders are left in a part are one straight line.

use super::cut::{BEND_SHARE, are_adjacent, changes, pieces};
use super::passage::Passage;
use super::piece::{ARC_HEIGHT, Piece, constant_radiance, convex_light, middle, piece_radiance, share};
use super::pixel::{INSET_PX, square};
use super::plan::Plan;
use super::work::Work;
use glam::DVec2;

/// Rays of a pixel at most, after which its parts are no longer divided: enough for the corner of a border, of which each
/// halving takes some 300, and few enough for a whole border at which the map bends without end, as at the critical angle.
const MOST_RAYS: u64 = 1 << 14;
/// A part's side is not divided below this, in px.
const SMALLEST_PX: f64 = 1.0 / 4096.0;
/// What a border may stray from what is taken for it, as a share of the bend allowed, which is for the lines of the pattern.
const BORDER_BEND: f64 = 0.25;
/// Around a part its passage is asked for at places at this distance, in px: a border that bulges into it between two of them,
/// with a radius of R px, takes less than 2e-5 / R of a pixel.
const ALONG_PX: f64 = 1.0 / 16.0;
/// The same along a side of the pixel itself, where all beyond it is of another passage.
const CLOSE_PX: f64 = 1.0 / 256.0;
/// Places along a side of a smaller part, at least.
const FEWEST_ALONG: u32 = 4;
/// Where along a border, as shares of its chord, it is compared with it.
const COMPARED: [f64; 3] = [0.25, 0.5, 0.75];

/// The mean radiance of the pixel at `px`, whose parts with a side above `largest_px` are divided in any case. Where the
/// parts at which the division ended are more of it than the bend allowed, the pixel is counted as one without promise.
pub(super) fn along_borders(plan: &Plan, px: DVec2, largest_px: f64, work: &mut Work) -> f64 {
    let capped_before = work.counts.capped_pixels;
    // Parts that are divided in any case have their own share.
    let shares = (plan.active / largest_px) as u64;
    let last_ray = work.counts.rays + shares * MOST_RAYS;
    let mut division = Division { plan, px, largest_px, last_ray, unresolved: 0.0 };
    let sum = division.square(DVec2::ZERO, 0.5 * plan.active, work);
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
    largest_px: f64,
    /// Where the count of rays stands when it has had its share.
    last_ray: u64,
    /// The share of the pixel's active square at which the division ended.
    unresolved: f64,
}

impl Division<'_> {
    /// The radiance over the four quarters of the square about `centre` of side 2 `half`.
    fn quarters(&mut self, centre: DVec2, half: f64, work: &mut Work) -> f64 {
        if 2.0 * half <= SMALLEST_PX || work.counts.rays >= self.last_ray {
            let outline = square(half).map(|corner| centre + corner);
            return self.unresolved(&outline, work);
        }
        let mut quarter = |x: f64, y: f64| self.square(centre + DVec2::new(x, y) * (0.5 * half), 0.5 * half, work);
        (quarter(-1.0, -1.0) + quarter(1.0, -1.0)) + (quarter(-1.0, 1.0) + quarter(1.0, 1.0))
    }

    /// The radiance over the square about `centre` of side 2 `half`: whole, cut along a border, or of its quarters.
    fn square(&mut self, centre: DVec2, half: f64, work: &mut Work) -> f64 {
        if 2.0 * half > self.largest_px {
            return self.quarters(centre, half, work);
        }
        let own = DVec2::splat(inset(self.plan));
        let corners = square(half).map(|corner| (centre + corner).clamp(-own, own));
        let passages = corners.map(|corner| self.passage(corner, work));
        let own = self.passage(centre, work);
        match changes(&passages)[..] {
            _ if !outline_is_simple(self.plan, self.px, &corners, &passages, work) => self.quarters(centre, half, work),
            [] if passages[0] == own => {
                let whole = Piece { outline: corners.to_vec(), passage: own };
                self.piece(&whole, work)
            }
            [first, second] if passages.contains(&own) => {
                let pieces = pieces(self.plan, self.px, &corners, &passages, [first, second], work);
                let is_whole =
                    |piece: &Piece, work: &mut Work| self.passage(middle(&piece.outline), work) == piece.passage;
                if !pieces.iter().all(|piece| is_whole(piece, work)) {
                    return self.quarters(centre, half, work);
                }
                if pieces.iter().all(|piece| self.ends_straight(piece, work)) {
                    return self.piece(&pieces[0], work) + self.piece(&pieces[1], work);
                }
                self.arc(&pieces, work).unwrap_or_else(|| self.quarters(centre, half, work))
            }
            _ => self.quarters(centre, half, work),
        }
    }

    /// What a border may stray from what is taken for it, in px.
    fn border_bend_px(&self) -> f64 {
        BORDER_BEND * self.plan.system.accuracy().bend_px
    }

    fn passage(&self, at: DVec2, work: &mut Work) -> Passage {
        Passage::at(self.plan, self.px + at, work)
    }

    /// Whether the border of a piece strays from its chord by less than the bend allowed.
    fn ends_straight(&self, piece: &Piece, work: &mut Work) -> bool {
        let bend_px = self.border_bend_px();
        let [from, to] = piece.border();
        let length = from.distance(to);
        // The corner that a shorter border cuts off is less than the bend times the pixel's side.
        if length * length <= bend_px {
            return true;
        }
        let inward = (to - from).perp() * (bend_px / length);
        COMPARED.iter().all(|share| {
            let at = from.lerp(to, *share);
            self.passage(at + inward, work) == piece.passage && self.passage(at - inward, work) != piece.passage
        })
    }

    /// The radiance over two pieces whose border is a parabola, to within the bend allowed; `None` where it is not known to be
    /// that, or too high for the lines of the pattern that may cross it.
    fn arc(&mut self, pieces: &[Piece; 2], work: &mut Work) -> Option<f64> {
        if !are_adjacent(pieces) {
            return None;
        }
        let [from, to] = pieces[0].border();
        let height = self.parabola_height(&pieces[0], work)?;

        // Take two sides of the same area for the arc (Archimedes): 4/3 as high. Up to a place along the chord they differ from
        // it by at most 2/81 of the chord times the height.
        let off = 2.0 / 81.0 * from.distance(to) * height.abs();
        let constant = |piece: &Piece, work: &mut Work| constant_radiance(self.plan, self.px, piece, work).is_some();
        if off > self.border_bend_px() && !pieces.iter().all(|piece| constant(piece, work)) {
            return None;
        }
        let apex = from.lerp(to, 0.5) + (to - from).perp().normalize_or_zero() * (4.0 / 3.0 * height);
        let mut bent = |piece: &Piece| {
            let outline = piece.outline.iter().copied().chain([apex]).collect();
            self.piece(&Piece { outline, passage: piece.passage }, work)
        };
        Some(bent(&pieces[0]) + bent(&pieces[1]))
    }

    /// The height of the border of a piece over the middle of its chord, inward, where it is a parabola.
    fn parabola_height(&self, piece: &Piece, work: &mut Work) -> Option<f64> {
        // Find the height.
        let [from, to] = piece.border();
        let length = from.distance(to);
        let inward = (to - from).perp() / length;
        let bend_px = self.border_bend_px();
        let mut is_within =
            |share: f64, off_px: f64| self.passage(from.lerp(to, share) + inward * off_px, work) == piece.passage;
        let (mut low, mut high) = (-ARC_HEIGHT * length, ARC_HEIGHT * length);
        if is_within(0.5, low) || !is_within(0.5, high) {
            return None;
        }
        while high - low > bend_px * BEND_SHARE {
            let middle = 0.5 * (low + high);
            if is_within(0.5, middle) { high = middle } else { low = middle }
        }

        // Compare the border with the parabola on both sides of the middle.
        let height = 0.5 * (low + high);
        [0.25, 0.75]
            .iter()
            .all(|share| is_within(*share, 0.75 * height + bend_px) && !is_within(*share, 0.75 * height - bend_px))
            .then_some(height)
    }

    /// The radiance over a part at which the division ends, by its middle.
    fn unresolved(&mut self, outline: &[DVec2], work: &mut Work) -> f64 {
        self.unresolved += share(self.plan, outline);
        convex_light(self.plan, self.px, outline, work)
    }

    /// The radiance over a piece of the passage that it is said to have.
    fn piece(&mut self, piece: &Piece, work: &mut Work) -> f64 {
        if work.counts.rays >= self.last_ray {
            return self.unresolved(&piece.outline, work);
        }
        let rays = work.counts.rays;
        let radiance = piece_radiance(self.plan, self.px, piece, work);
        if self.plan.steep {
            // Rays for the throughput are no sign of a border that never ends.
            self.last_ray += work.counts.rays - rays;
        }
        radiance
    }
}

/// Whether as many borders as the corners of a square (about `px`) tell pass through its outline, by places along a slightly
/// larger one: a right-angled corner of a border that reaches into the square between two places is wider there.
pub(super) fn outline_is_simple(
    plan: &Plan,
    px: DVec2,
    corners: &[DVec2; 4],
    passages: &[Passage; 4],
    work: &mut Work,
) -> bool {
    let steps = ((corners[0].distance(corners[1]) / ALONG_PX) as u32).max(FEWEST_ALONG);
    let middle = 0.5 * (corners[0] + corners[2]);
    let outer = corners.map(|corner| middle + (corner - middle) * (1.0 + 1.0 / f64::from(steps)));
    let places = (0..4).flat_map(|side| {
        (0..steps).map(move |k| outer[side].lerp(outer[(side + 1) % 4], f64::from(k) / f64::from(steps)))
    });

    // Walk once around it. Beyond the pixel's own side all may be of another passage, whose border is that side.
    let (mut first, mut last, mut borders, mut beyond) = (None, None, 0, false);
    for place in places {
        let passage = Passage::at(plan, px + place, work);
        if !passages.contains(&passage) {
            if place.abs().max_element() <= 0.5 * plan.active {
                return false;
            }
            beyond = true;
            continue;
        }
        borders += usize::from(last.is_some_and(|last| last != passage));
        if borders > 2 {
            return false;
        }
        first = first.or(Some(passage));
        last = Some(passage);
    }
    borders += usize::from(first != last);
    borders == changes(passages).len() && (!beyond || sides_are_simple(plan, px, corners, passages, work))
}

/// Whether along those sides of a square (about `px`) that are the pixel's own the passage changes as its corners tell, by
/// close places.
fn sides_are_simple(plan: &Plan, px: DVec2, corners: &[DVec2; 4], passages: &[Passage; 4], work: &mut Work) -> bool {
    let own = inset(plan);
    (0..4).all(|side| {
        let next = (side + 1) % 4;
        let (from, to) = (corners[side], corners[next]);
        let is_own = [0, 1].iter().any(|&axis| from[axis] == to[axis] && from[axis].abs() == own);
        let steps = if is_own { (from.distance(to) / CLOSE_PX).ceil().max(2.0) as u32 } else { 1 };
        let (mut last, mut borders) = (passages[side], 0);
        for k in 1..steps {
            let passage = Passage::at(plan, px + from.lerp(to, f64::from(k) / f64::from(steps)), work);
            borders += usize::from(passage != last);
            last = passage;
        }
        borders += usize::from(passages[next] != last);
        borders == usize::from(passages[side] != passages[next])
    })
}

/// Half the side of a pixel's active square, less than what keeps a border along its side out of it.
fn inset(plan: &Plan) -> f64 {
    0.5 * plan.active * (1.0 - 2.0 * INSET_PX)
}
