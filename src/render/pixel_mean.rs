//! The box-filtered radiance of pixels: the mean of the checkerboard over a pixel whose map to the board is known to
//! second order.

use super::checkerboard::Checkerboard;
use crate::accuracy::Accuracy;
use crate::num::simd::{LANES, Lanes, Mask};
use glam::DVec2;

/// The map pixel -> board about the centre of a pixel, in squares of the pattern, by steps of one px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Taylor2 {
    /// What the centre sees.
    pub(super) seen: DVec2,
    /// First derivatives, to the right and down.
    pub(super) dx: DVec2,
    pub(super) dy: DVec2,
    /// Second derivatives.
    pub(super) dxx: DVec2,
    pub(super) dxy: DVec2,
    pub(super) dyy: DVec2,
}

impl Taylor2 {
    /// How far the map may stray from its tangent inside the pixel, in steps.
    #[inline(always)]
    pub(super) fn stray_px(&self) -> f64 {
        let stray = 0.125 * (self.dxx.abs() + 2.0 * self.dxy.abs() + self.dyy.abs());
        // |J^-1| on what it strays along each axis.
        let right = self.dy.y.abs() * stray.x + self.dy.x.abs() * stray.y;
        let down = self.dx.y.abs() * stray.x + self.dx.x.abs() * stray.y;
        right.max(down) / self.dx.perp_dot(self.dy).abs()
    }

    /// The same map by steps of `side` px.
    #[inline(always)]
    pub(super) fn by_steps_of(self, side: f64) -> Self {
        let square = side * side;
        Self {
            seen: self.seen,
            dx: self.dx * side,
            dy: self.dy * side,
            dxx: self.dxx * square,
            dxy: self.dxy * square,
            dyy: self.dyy * square,
        }
    }
}

/// [`LANES`] Taylor expansions; each field holds its first and its second component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PackedTaylor2 {
    pub(super) seen: [Lanes; 2],
    pub(super) dx: [Lanes; 2],
    pub(super) dy: [Lanes; 2],
    pub(super) dxx: [Lanes; 2],
    pub(super) dxy: [Lanes; 2],
    pub(super) dyy: [Lanes; 2],
}

/// The mean radiance of a pixel, by what crosses it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PixelMean {
    /// No line of the pattern passes through it.
    Constant(f64),
    /// Some line does. How far the lines may be from their places, in px, is an estimate: the bend of the map that was
    /// left out.
    Edge { value: f64, parts: u32, off_px: f64 },
    /// The map bends so much that its second order does not tell the value.
    TooBent,
}

/// Above this bend of the map within a pixel, in px, its second derivatives do not describe it: they change as well.
const MOST_BEND_PX: f64 = 1e-2;

/// The means of `pattern` over [`LANES`] pixels.
#[inline(always)]
pub(super) fn pixel_means(pattern: &Checkerboard, pixels: &PackedTaylor2, accuracy: &Accuracy) -> [PixelMean; LANES] {
    let (value, constant, line, off_px) = at_most_one_line(pattern, pixels, accuracy.bend_px);
    let one_line = |k: usize| PixelMean::Edge { value: value.0[k], parts: 1, off_px: off_px.0[k] };
    let mut means: [PixelMean; LANES] = std::array::from_fn(one_line);
    for (k, mean) in means.iter_mut().enumerate() {
        if constant.0[k] != 0 {
            *mean = PixelMean::Constant(value.0[k]);
        } else if line.0[k] == 0 {
            *mean = several_lines(pattern, &pixels.lane(k), accuracy);
        }
    }
    means
}

impl PackedTaylor2 {
    /// One Taylor expansion in every lane.
    #[inline(always)]
    pub(super) fn splat(taylor: &Taylor2) -> Self {
        let splat = |v: DVec2| [Lanes::splat(v.x), Lanes::splat(v.y)];
        Self {
            seen: splat(taylor.seen),
            dx: splat(taylor.dx),
            dy: splat(taylor.dy),
            dxx: splat(taylor.dxx),
            dxy: splat(taylor.dxy),
            dyy: splat(taylor.dyy),
        }
    }

    /// Changes one of the Taylor expansions.
    #[inline(always)]
    pub(super) fn set_lane(&mut self, k: usize, taylor: &Taylor2) {
        (self.seen[0].0[k], self.seen[1].0[k]) = (taylor.seen.x, taylor.seen.y);
        (self.dx[0].0[k], self.dx[1].0[k]) = (taylor.dx.x, taylor.dx.y);
        (self.dy[0].0[k], self.dy[1].0[k]) = (taylor.dy.x, taylor.dy.y);
        (self.dxx[0].0[k], self.dxx[1].0[k]) = (taylor.dxx.x, taylor.dxx.y);
        (self.dxy[0].0[k], self.dxy[1].0[k]) = (taylor.dxy.x, taylor.dxy.y);
        (self.dyy[0].0[k], self.dyy[1].0[k]) = (taylor.dyy.x, taylor.dyy.y);
    }

    #[inline(always)]
    pub(super) fn lane(&self, k: usize) -> Taylor2 {
        let lane = |v: &[Lanes; 2]| DVec2::new(v[0].0[k], v[1].0[k]);
        Taylor2 {
            seen: lane(&self.seen),
            dx: lane(&self.dx),
            dy: lane(&self.dy),
            dxx: lane(&self.dxx),
            dxy: lane(&self.dxy),
            dyy: lane(&self.dyy),
        }
    }

    /// How far from the centre what the pixels see may be along one axis, but for the bend of the maps.
    #[inline(always)]
    fn reach(&self, axis: usize) -> Lanes {
        Lanes::splat(0.5) * (self.dx[axis].abs() + self.dy[axis].abs())
    }

    /// How far the maps may stray from their tangents inside the pixels, along one axis.
    #[inline(always)]
    fn stray(&self, axis: usize) -> Lanes {
        Lanes::splat(0.125) * (self.dxx[axis].abs() + (self.dxy[axis] + self.dxy[axis]).abs() + self.dyy[axis].abs())
    }
}

impl PackedTaylor2 {
    /// How far the maps may stray from their tangents inside the pixels, in px: |J^-1| on what they stray along each axis.
    #[inline(always)]
    fn stray_px(&self, stray: [Lanes; 2]) -> Lanes {
        let det = (self.dx[0] * self.dy[1] - self.dx[1] * self.dy[0]).abs();
        let right = self.dy[1].abs() * stray[0] + self.dy[0].abs() * stray[1];
        let down = self.dx[1].abs() * stray[0] + self.dx[0].abs() * stray[1];
        right.max(down) / det
    }
}

/// The first component where `first`, else the second.
#[inline(always)]
fn pick(first: Mask, v: [Lanes; 2]) -> Lanes {
    first.select(v[0], v[1])
}

/// The means over pixels that no line or one line of the pattern crosses, that between a square and its neighbour; which
/// have no line; which have one; and for these an estimate of the error, in px.
///
/// A line that is straight in the pixel leaves a share of it that is the distribution of a sum of two uniform variables.
/// The bend of the map enters to first order, as the integral of its component across the line along the part of the line
/// inside the pixel; what is left is of the order of its square.
#[inline(always)]
fn at_most_one_line(pattern: &Checkerboard, pixels: &PackedTaylor2, bend_px: f64) -> (Lanes, Mask, Mask, Lanes) {
    let (zero, half, one) = (Lanes::splat(0.0), Lanes::splat(0.5), Lanes::splat(1.0));

    // Find which lines of the pattern the pixels may touch.
    let stray = [pixels.stray(0), pixels.stray(1)];
    let reach = [pixels.reach(0) + stray[0], pixels.reach(1) + stray[1]];
    let squares = pattern.squares(pixels.seen, reach);
    let touched_x = half.le(squares.offset[0].abs() + reach[0]);
    let touched_y = half.le(squares.offset[1].abs() + reach[1]);
    let constant = squares.inside & !touched_x & !touched_y;

    // Find the axis across the line, and the line's signed distance from the centre along it.
    let upright = touched_x;
    let (a, b) = (pick(upright, pixels.dx), pick(upright, pixels.dy));
    let offset = pick(upright, squares.offset);
    let single = pick(upright, reach).lt(half + offset.abs());
    let backward = offset.lt(zero);
    let distance = half.negated_where(backward) - offset;

    // Split the axes of the pixel into the steeper and the flatter one across the line.
    let steep_x = b.abs().le(a.abs());
    let (steep, flat) = (steep_x.select(a, b), steep_x.select(b, a));
    let (long, short) = (steep.abs(), flat.abs());
    let e = distance.abs();

    // Estimate the error: the bend moves the line by `within_px` at most, of which the first order is known. Its square
    // is left; and where the line passes a corner of the pixel, the share changes its slope, from one to the other over
    // the short side.
    let within_px = pixels.stray_px(stray);
    let across = pick(upright, stray);
    let at_corner = (across * across / (Lanes::splat(2.0) * long * short)).min(within_px);
    let passes_corner = (half * (long - short)).le(e + across);
    let off_px = within_px * within_px + passes_corner.select(at_corner, zero);
    let line = squares.inside & !constant & !(touched_x & touched_y) & single & off_px.le(Lanes::splat(bend_px));

    // Find the share of the pixel beyond the straight line.
    let inverse = one / steep;
    let rest = half * (long + short) - e;
    let corner = zero.lt(rest).select(rest * rest / (Lanes::splat(2.0) * long * short), zero);
    let share = e.le(half * (long - short)).select(half - e * inverse.abs(), corner);

    // Integrate the bend along the line, by Simpson's rule: the steep coordinate of the pixel is (distance - flat
    // s)/steep where the flat one is s.
    let (centre, reach) = (distance / flat, half * long / short);
    let from = (centre - reach).max(-half);
    let to = (centre + reach).min(half);
    let (xx, yy) = (pick(upright, pixels.dxx), pick(upright, pixels.dyy));
    let along = LineBend {
        slope: flat * inverse,
        start: distance * inverse,
        steep2: half * steep_x.select(xx, yy),
        flat2: half * steep_x.select(yy, xx),
        mixed: pick(upright, pixels.dxy),
    };
    let simpson = (along.bend(from) + along.bend(to)) + Lanes::splat(4.0) * along.bend(half * (from + to));
    let bent = (to - from) * simpson * inverse.abs() * Lanes::splat(1.0 / 6.0);

    // Put both together and weigh the two squares by their shares.
    let crossed = from.lt(to) & zero.lt(rest);
    let beyond = share + crossed.select(bent, zero).negated_where(backward);
    let beyond = constant.select(zero, beyond.max(zero).min(one));
    (squares.mean + squares.contrast * (one - (beyond + beyond)), constant, line, off_px)
}

/// The second order of a map along a line through a pixel.
#[derive(Clone, Copy)]
struct LineBend {
    start: Lanes,
    slope: Lanes,
    steep2: Lanes,
    flat2: Lanes,
    mixed: Lanes,
}

impl LineBend {
    /// At the flat coordinate s.
    #[inline(always)]
    fn bend(&self, s: Lanes) -> Lanes {
        let t = self.start - self.slope * s;
        (self.steep2 * (t * t) + self.flat2 * (s * s)) + self.mixed * (t * s)
    }
}

/// The mean over a pixel of any kind.
fn several_lines(pattern: &Checkerboard, taylor: &Taylor2, accuracy: &Accuracy) -> PixelMean {
    let stray = 0.125 * (taylor.dxx.abs() + 2.0 * taylor.dxy.abs() + taylor.dyy.abs());
    let reach = 0.5 * (taylor.dx.abs() + taylor.dy.abs()) + stray;
    if let Some(value) = pattern.constant(taylor.seen, reach) {
        return PixelMean::Constant(value);
    }
    divided_mean(taylor, accuracy, &of_squares(pattern))
}

/// The mean of the checkerboard over a parallelogram.
fn of_squares(pattern: &Checkerboard) -> impl Fn(&[DVec2; 4]) -> f64 {
    |polygon| pattern.mean_over(polygon).unwrap_or_else(|| mean_of_points(&|c| pattern.radiance(c), polygon, &SQUARE))
}

/// The mean over a pixel, given that over a parallelogram on the board, from as many parts as are flat to the error allowed.
#[inline]
pub(super) fn divided_mean(taylor: &Taylor2, accuracy: &Accuracy, mean: &impl Fn(&[DVec2; 4]) -> f64) -> PixelMean {
    let stray_px = taylor.stray_px();
    // NaN must not pass.
    if stray_px.is_nan() || stray_px > MOST_BEND_PX || accuracy.bend_px <= 0.0 {
        return PixelMean::TooBent;
    }
    // Parts that are flat to the error allowed: in each of n x n the map strays n^-2 as far.
    let wanted = (stray_px / accuracy.bend_px).sqrt().ceil().max(1.0);
    let parts = (wanted as u32).min(accuracy.max_division);
    let off_px = stray_px / f64::from(parts * parts);
    PixelMean::Edge { value: mean_of_parts(mean, taylor, parts), parts, off_px }
}

/// The corners of a pixel, in the order of its polygon.
const SQUARE: [DVec2; 4] = [DVec2::new(-0.5, -0.5), DVec2::new(0.5, -0.5), DVec2::new(0.5, 0.5), DVec2::new(-0.5, 0.5)];

/// The mean over n x n parts of the pixel, each by the tangent of the map at its centre, which is moved to where the mean
/// of its second order lies. Mirror images are summed in pairs, so that their sums have the same bits.
fn mean_of_parts(mean: &impl Fn(&[DVec2; 4]) -> f64, taylor: &Taylor2, n: u32) -> f64 {
    let side = 1.0 / f64::from(n);
    let shift = (taylor.dxx + taylor.dyy) * (side * side / 24.0);
    let place = |k: u32| (f64::from(2 * k + 1) - f64::from(n)) * (0.5 * side);
    let part = |i: u32, j: u32| {
        let p = DVec2::new(place(i), place(j));
        let bend = 0.5 * ((taylor.dxx * (p.x * p.x) + taylor.dyy * (p.y * p.y)) + taylor.dxy * (2.0 * p.x * p.y));
        let seen = taylor.seen + (taylor.dx * p.x + taylor.dy * p.y) + bend + shift;
        let right = (taylor.dx + (taylor.dxx * p.x + taylor.dxy * p.y)) * (0.5 * side);
        let down = (taylor.dy + (taylor.dxy * p.x + taylor.dyy * p.y)) * (0.5 * side);
        mean(&[seen - right - down, seen + right - down, seen + right + down, seen - right + down])
    };
    let row = |j: u32| {
        let pairs: f64 = (0..n / 2).map(|i| part(i, j) + part(n - 1 - i, j)).sum();
        if n % 2 == 1 { pairs + part(n / 2, j) } else { pairs }
    };
    (0..n).map(row).sum::<f64>() * (side * side)
}

/// The mean over a polygon that has shrunk to a line, the image of the convex `outline` in the picture, vertex by vertex:
/// points spread evenly over the outline.
pub(super) fn mean_of_points(radiance: &dyn Fn(DVec2) -> f64, polygon: &[DVec2], outline: &[DVec2]) -> f64 {
    const N: usize = 32;
    let place = |k: usize| (k as f64 + 0.5) / N as f64;
    let (mut sum, mut weights) = (0.0, 0.0);
    for k in 1..outline.len() - 1 {
        let weight = (outline[k] - outline[0]).perp_dot(outline[k + 1] - outline[0]).abs();
        let (a, b) = (polygon[k] - polygon[0], polygon[k + 1] - polygon[0]);
        // The far half of a parallelogram, folded back over its triangle.
        let point = |s: f64, t: f64| if s + t <= 1.0 { a * s + b * t } else { a * (1.0 - s) + b * (1.0 - t) };
        let points = (0..N * N).map(|k| radiance(polygon[0] + point(place(k % N), place(k / N))));
        sum += weight * points.sum::<f64>() / (N * N) as f64;
        weights += weight;
    }
    sum / weights
}

#[cfg(test)]
#[path = "pixel_mean_tests.rs"]
mod tests;
