//! The checkerboard's radiance, and its exact mean over a polygon (analytic anti-aliasing).
//!
//! The radiance is a sum of products g(u) h(v) of piecewise constant functions, so by Green's theorem its integral over
//! a polygon is the contour integral of G(u) h(v) dv with G' = g, where G is piecewise linear: a short sum over the
//! pieces of the polygon's edges between the lines of the pattern. Exact for any polygon, however many squares it holds.

use crate::num::simd::{Lanes, Mask};
use crate::scene::BoardSpec;
use glam::DVec2;

/// Beyond this many squares across, the squares are replaced by their mean: in each row of squares the two colours differ by
/// at most one square, and in each column, so the mean is wrong by at most half the contrast over the polygon's width.
const MAX_SQUARES: f64 = 4096.0;
/// A polygon beyond [`MAX_SQUARES`] that is narrower than this is left to points: of its mean nothing is known. In wider
/// ones the mean is wrong by at most 1/512 of the contrast.
const WIDE_SQUARES: f64 = 256.0;

/// 1.5 * 2^52: numbers near it are 1 apart.
const UNITS: f64 = 6_755_399_441_055_744.0;

/// The nearest whole number, of two the even one, for |u| below 2^51: one addition and one subtraction, where
/// `f64::round` is a function call. Odd in u.
#[inline(always)]
fn whole(u: f64) -> f64 {
    (u + UNITS) - UNITS
}

/// 1 for even whole numbers, -1 for odd ones.
#[inline(always)]
fn sign(whole: f64) -> f64 {
    if whole as i64 & 1 == 0 { 1.0 } else { -1.0 }
}

/// The squares that hold the places of a packet.
#[derive(Debug, Clone, Copy)]
pub struct Squares {
    /// From the centre of the square, in squares: within +-0.5.
    pub offset: [Lanes; 2],
    /// Mean of the square's radiance and its neighbours'.
    pub mean: Lanes,
    /// The square's radiance less the mean.
    pub contrast: Lanes,
    /// Where nothing but squares lies within the reach, on either axis.
    pub inside: Mask,
}

/// Where the places of a packet lie along one axis.
#[derive(Debug, Clone, Copy)]
pub struct Along {
    /// From the middle of the square, in squares: within +-0.5.
    pub offset: Lanes,
    /// The highest bit of each is set in squares whose number is odd.
    pub odd: Mask,
    /// Where nothing but squares lies within the reach.
    pub inside: Mask,
}

impl Along {
    /// Where no line of the pattern lies within `r`.
    #[inline(always)]
    pub fn off_lines(&self, r: Lanes) -> Mask {
        self.inside & (self.offset.abs() + r).lt(Lanes::splat(0.5))
    }
}

/// The square that holds a place.
#[derive(Debug, Clone, Copy)]
pub struct Square {
    /// From the centre of the square, in squares: within +-0.5.
    pub offset: DVec2,
    /// Mean of the square's radiance and its neighbours'.
    pub mean: f64,
    /// The square's radiance less the mean.
    pub contrast: f64,
}

impl Squares {
    /// The radiance, and where no line of the pattern lies within `r` on either axis.
    #[inline(always)]
    pub fn constant_off_lines(&self, r: [Lanes; 2]) -> (Lanes, Mask) {
        let half = Lanes::splat(0.5);
        let off_lines = (self.offset[0].abs() + r[0]).lt(half) & (self.offset[1].abs() + r[1]).lt(half);
        (self.mean + self.contrast, self.inside & off_lines)
    }
}

/// The radiance of a checkerboard. Positions are in squares from its centre, where nothing else is said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checkerboard {
    squares_per_mm: f64,
    /// Moves the origin to the centre of a square: half a square for even counts.
    shift: DVec2,
    /// The squares cover |u - shift| <= half, in squares.
    half: DVec2,
    /// The plate covers |u - shift| <= plate, in squares.
    plate: DVec2,
    /// Radiance of the square at the origin and of its neighbours: mean + amplitude, mean - amplitude.
    mean: f64,
    amplitude: f64,
    white: f64,
    background: f64,
}

impl Checkerboard {
    /// The radiance of `board`.
    pub fn new(board: &BoardSpec) -> Self {
        let count = DVec2::new(board.columns as f64, board.rows as f64);
        let even = |n: usize| if n.is_multiple_of(2) { 0.5 } else { 0.0 };
        // The square at the origin is column (columns - 1)/2 rounded down, row likewise; the top left one is black.
        let origin = (board.columns - 1) / 2 + (board.rows - 1) / 2;
        let sign = if origin.is_multiple_of(2) { -1.0 } else { 1.0 };
        Self {
            squares_per_mm: 1.0 / board.square_mm,
            shift: DVec2::new(even(board.columns), even(board.rows)),
            half: 0.5 * count,
            plate: 0.5 * count + board.margin_mm / board.square_mm,
            mean: 0.5 * (board.black + board.white),
            amplitude: sign * 0.5 * (board.white - board.black),
            white: board.white,
            background: board.background,
        }
    }

    /// Radiance around the plate, and of everything else that is not board.
    pub fn background(&self) -> f64 {
        self.background
    }

    /// Squares per mm.
    pub fn squares_per_mm(&self) -> f64 {
        self.squares_per_mm
    }

    /// The radiance if it is the same within `r` of `c` on either axis; `None` if it may not be.
    #[inline(always)]
    pub fn constant(&self, c: DVec2, r: DVec2) -> Option<f64> {
        let (low, high) = (c - r, c + r);
        // Inside the squares: one square holds it all.
        if low.x >= -self.half.x && high.x <= self.half.x && low.y >= -self.half.y && high.y <= self.half.y {
            let (column, row) = (whole(c.x + self.shift.x), whole(c.y + self.shift.y));
            let room = DVec2::splat(0.5) - (c - (DVec2::new(column, row) - self.shift)).abs();
            let one = room.x > r.x && room.y > r.y;
            return one.then(|| self.mean + self.amplitude * sign(column) * sign(row));
        }
        let beyond = |edge: DVec2| low.x >= edge.x || low.y >= edge.y || high.x <= -edge.x || high.y <= -edge.y;
        if beyond(self.plate) {
            return Some(self.background);
        }
        let within = |edge: DVec2| low.x > -edge.x && low.y > -edge.y && high.x < edge.x && high.y < edge.y;
        (beyond(self.half) && within(self.plate)).then_some(self.white)
    }

    /// The square that holds `c`, where nothing but squares lies within `r` of it on either axis.
    #[inline(always)]
    pub fn square(&self, c: DVec2, r: DVec2) -> Option<Square> {
        let inside = (c.abs() + r).cmple(self.half).all();
        let (column, row) = (whole(c.x + self.shift.x), whole(c.y + self.shift.y));
        inside.then(|| Square {
            offset: c - (DVec2::new(column, row) - self.shift),
            mean: self.mean,
            contrast: self.amplitude * sign(column) * sign(row),
        })
    }

    /// Where the places `c` lie along an axis, within `r` of which only squares are to lie.
    #[inline(always)]
    pub fn along(&self, axis: usize, c: Lanes, r: Lanes) -> Along {
        let (shift, units) = (Lanes::splat(self.shift[axis]), Lanes::splat(UNITS));
        let marked = (c + shift) + units;
        Along {
            offset: c - (marked - units - shift),
            odd: Mask(marked.0.map(|m| m.to_bits() << 63)),
            inside: (c.abs() + r).le(Lanes::splat(self.half[axis])),
        }
    }

    /// The radiance of squares, given where their numbers along either axis are odd.
    #[inline(always)]
    pub fn of_squares(&self, [column, row]: [Mask; 2]) -> Lanes {
        Lanes::splat(self.mean) + Lanes::splat(self.amplitude).negated_where(column).negated_where(row)
    }

    /// The squares that hold the places `c`.
    #[inline(always)]
    pub fn squares(&self, c: [Lanes; 2], r: [Lanes; 2]) -> Squares {
        let [x, y] = [0, 1].map(|axis| self.along(axis, c[axis], r[axis]));
        Squares {
            offset: [x.offset, y.offset],
            mean: Lanes::splat(self.mean),
            contrast: Lanes::splat(self.amplitude).negated_where(x.odd).negated_where(y.odd),
            inside: x.inside & y.inside,
        }
    }

    /// The radiance at a point of the board, in mm in the board's frame.
    pub fn at(&self, board_mm: DVec2) -> f64 {
        self.radiance(board_mm * self.squares_per_mm)
    }

    /// The radiance at `c`.
    pub fn radiance(&self, c: DVec2) -> f64 {
        let outside = |edge: DVec2| c.x.abs() > edge.x || c.y.abs() > edge.y;
        if outside(self.plate) {
            self.background
        } else if outside(self.half) {
            self.white
        } else {
            self.mean + self.amplitude * self.sign(c.x, self.shift.x) * self.sign(c.y, self.shift.y)
        }
    }

    /// The integral of the radiance over the polygon (of either orientation), divided by the polygon's area. `None` where
    /// the area vanishes against the polygon's length and the quotient means nothing, and of a narrow polygon over
    /// thousands of squares.
    pub fn mean_over(&self, polygon: &[DVec2]) -> Option<f64> {
        let n = polygon.len();
        let scaled = |k: usize| polygon[k % n];
        let origin = scaled(0);

        // Sum over the edges of the polygon, opposite edges first: the mirror image of a polygon of four then has the
        // same sum, bit for bit.
        let sum = |f: &dyn Fn(DVec2, DVec2) -> f64| {
            if n == 4 {
                let edge = |k: usize| f(scaled(k), scaled(k + 1));
                (edge(0) + edge(2)) + (edge(1) + edge(3))
            } else {
                (0..n).map(|k| f(scaled(k), scaled(k + 1))).sum()
            }
        };

        // Find the bounding box, and the area as the contour integral of x dy.
        let (mut low, mut high) = (origin, origin);
        for k in 1..n {
            (low, high) = (low.min(scaled(k)), high.max(scaled(k)));
        }
        let extent = high - low;
        let middle = 0.5 * (low + high);
        let area = sum(&|a, b| (0.5 * (a.x + b.x) - middle.x) * (b.y - a.y));

        // Turn down an area of mere rounding: vertices that differ by little more than that span none.
        let rounding = 64.0 * f64::EPSILON * low.abs().max(high.abs()).max_element();
        let lost = extent.max_element() < 1e4 * rounding;
        if lost || area.abs() < 1e-9 * extent.length_squared() || !area.is_finite() {
            return None;
        }

        // Turn down a narrow polygon over thousands of squares.
        let many = extent.max_element() > MAX_SQUARES;
        if many && area.abs() < WIDE_SQUARES * extent.max_element() {
            return None;
        }

        // Integrate the squares' alternating part by Green's theorem.
        let squares = if many {
            0.0
        } else {
            let region = RuledRect { half: self.half, count: 2.0 * self.half };
            let (g, h) = (|u| self.wave(u) - self.wave(middle.x), |v| self.sign(v, self.shift.y));
            sum(&|a, b| Self::edge(a, b, &region, g, h))
        };

        // Find the shares of the polygon that lie on the squares and on the plate.
        let share = |half: DVec2| {
            if low.x >= -half.x && low.y >= -half.y && high.x <= half.x && high.y <= half.y {
                return 1.0;
            }
            let region = RuledRect { half, count: DVec2::ONE };
            sum(&|a, b| Self::edge(a, b, &region, |u| u - middle.x.clamp(-half.x, half.x), |_| 1.0)) / area
        };
        let (board, plate) = (share(self.half), share(self.plate));

        // Add up background, plate, mean of the squares and their alternating part.
        let ground = self.background + (self.white - self.background) * plate + (self.mean - self.white) * board;
        // A mean lies between the darkest and the brightest; a polygon hardly larger than the rounding of its own vertices
        // may say otherwise.
        let [darkest, brightest] = self.range();
        Some((ground + self.amplitude * (squares / area)).clamp(darkest, brightest))
    }

    /// The largest difference of radiances of the board and its surroundings.
    pub fn contrast(&self) -> f64 {
        let [darkest, brightest] = self.range();
        brightest - darkest
    }

    /// The smallest and the largest radiance of the board and its surroundings.
    fn range(&self) -> [f64; 2] {
        let squares = [self.mean - self.amplitude, self.mean + self.amplitude];
        let all = [squares[0], squares[1], self.white, self.background];
        [all.iter().copied().fold(f64::INFINITY, f64::min), all.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// The sign of the square's colour along one axis at `u` squares from the centre.
    #[inline(always)]
    fn sign(&self, u: f64, shift: f64) -> f64 {
        sign(whole(u + shift))
    }

    /// The antiderivative of [`Checkerboard::sign`] along x: a triangular wave.
    #[inline(always)]
    fn wave(&self, u: f64) -> f64 {
        let k = whole(u + self.shift.x);
        sign(k) * (u + self.shift.x - k)
    }

    /// The integral of G(clamp(u)) h(v) dv along a -> b over |v| <= region.half.y, with G linear and h constant between
    /// the lines of `region`. Changing the direction changes the sign and no other bit.
    #[inline]
    fn edge(a: DVec2, b: DVec2, region: &RuledRect, g: impl Fn(f64) -> f64, h: impl Fn(f64) -> f64) -> f64 {
        // Turn the edge to rise in y, and skip a level one: it adds nothing.
        let (low, high, sign) = if a.y <= b.y { (a, b, 1.0) } else { (b, a, -1.0) };
        let step = high - low;
        if step.y == 0.0 {
            return 0.0;
        }

        // Walk along the edge from line to line of the region.
        let g = |u: f64| g(u.clamp(-region.half.x, region.half.x));
        let mut across = LineCrossings::new(low.x, high.x, region.half.x, region.count.x);
        let mut along = LineCrossings::new(low.y, high.y, region.half.y, region.count.y);
        let (mut sum, mut p, mut g_p) = (0.0, low, g(low.x));
        let mut t = 0.0;
        loop {
            // Of a path along a line rounding may put their meeting anywhere, also before its start; the pieces go on in order.
            t = across.t().min(along.t()).max(t).min(1.0);
            let q = if t < 1.0 { low + step * t } else { high };
            let (middle, g_q) = (0.5 * (p.y + q.y), g(q.x));

            // Add the piece by the trapezoidal rule, exact for linear G, where it lies within the region.
            if middle.abs() <= region.half.y {
                sum += 0.5 * (g_p + g_q) * h(middle) * (q.y - p.y);
            }
            if t >= 1.0 {
                return sign * sum;
            }

            // Go on to the next line in either direction.
            (p, g_p) = (q, g_q);
            if across.t() <= t {
                across.next += 1.0;
            }
            if along.t() <= t {
                along.next += 1.0;
            }
        }
    }
}

/// A rectangle about the origin, cut by equidistant lines.
#[derive(Debug, Clone, Copy)]
struct RuledRect {
    half: DVec2,
    /// Intervals between lines on each axis.
    count: DVec2,
}

/// The lines of a region that a path crosses along one axis, in order. The axis is turned so that the path rises, which
/// makes mirrored paths meet their lines at the same parameters, bit for bit.
struct LineCrossings {
    from: f64,
    rise: f64,
    first: f64,
    pitch: f64,
    next: f64,
    last: f64,
}

impl LineCrossings {
    #[inline]
    fn new(from: f64, to: f64, half: f64, count: f64) -> Self {
        let (from, to) = if from <= to { (from, to) } else { (-from, -to) };
        let pitch = 2.0 * half / count;
        let next = ((from + half) / pitch).ceil().max(0.0);
        let last = ((to + half) / pitch).floor().min(count);
        Self { from, rise: to - from, first: -half, pitch, next, last }
    }

    /// Where the path meets its next line, as a share of the path; infinite when there is none.
    #[inline(always)]
    fn t(&self) -> f64 {
        if self.next > self.last || self.rise == 0.0 {
            return f64::INFINITY;
        }
        (self.first + self.pitch * self.next - self.from) / self.rise
    }
}

#[cfg(test)]
#[path = "checkerboard_tests.rs"]
mod tests;
