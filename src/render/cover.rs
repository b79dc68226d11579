//! The mean radiance of pixels whose map to the board is known to second order.

use super::coverage::Pattern;
use crate::accuracy::Accuracy;
use crate::num::simd::{LANES, Lanes, Mask};
use glam::DVec2;

/// The map pixel -> board about the centre of a pixel, in squares of the pattern, by steps of one px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Jet {
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

impl Jet {
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

/// [`LANES`] jets; each field holds its first and its second component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Jets {
    pub(super) seen: [Lanes; 2],
    pub(super) dx: [Lanes; 2],
    pub(super) dy: [Lanes; 2],
    pub(super) dxx: [Lanes; 2],
    pub(super) dxy: [Lanes; 2],
    pub(super) dyy: [Lanes; 2],
}

/// How a pixel was covered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cover {
    /// No line of the pattern passes through it.
    Plain(f64),
    /// Some line does. How far the lines may be from their places, in px, is an estimate: the bend of the map that was
    /// left out.
    Edge { value: f64, parts: u32, off_px: f64 },
    /// The map bends so much that its second order does not tell the value.
    TooBent,
}

/// Above this bend of the map within a pixel, in px, its second derivatives do not describe it: they change as well.
const MOST_BEND_PX: f64 = 1e-2;

/// The means of `pattern` over as many pixels.
#[inline(always)]
pub(super) fn cover(pattern: &Pattern, jets: &Jets, accuracy: &Accuracy) -> [Cover; LANES] {
    let (value, plain, line, off_px) = at_most_one_line(pattern, jets, accuracy.bend_px);
    let mut covers = [Cover::TooBent; LANES];
    for (k, cover) in covers.iter_mut().enumerate() {
        *cover = if plain.0[k] != 0 {
            Cover::Plain(value.0[k])
        } else if line.0[k] != 0 {
            Cover::Edge { value: value.0[k], parts: 1, off_px: off_px.0[k] }
        } else {
            several_lines(pattern, &jets.lane(k), accuracy)
        };
    }
    covers
}

impl Jets {
    /// One jet in every lane.
    #[inline(always)]
    pub(super) fn splat(jet: &Jet) -> Self {
        let splat = |v: DVec2| [Lanes::splat(v.x), Lanes::splat(v.y)];
        Self {
            seen: splat(jet.seen),
            dx: splat(jet.dx),
            dy: splat(jet.dy),
            dxx: splat(jet.dxx),
            dxy: splat(jet.dxy),
            dyy: splat(jet.dyy),
        }
    }

    /// Changes one of the jets.
    #[inline(always)]
    pub(super) fn set_lane(&mut self, k: usize, jet: &Jet) {
        (self.seen[0].0[k], self.seen[1].0[k]) = (jet.seen.x, jet.seen.y);
        (self.dx[0].0[k], self.dx[1].0[k]) = (jet.dx.x, jet.dx.y);
        (self.dy[0].0[k], self.dy[1].0[k]) = (jet.dy.x, jet.dy.y);
        (self.dxx[0].0[k], self.dxx[1].0[k]) = (jet.dxx.x, jet.dxx.y);
        (self.dxy[0].0[k], self.dxy[1].0[k]) = (jet.dxy.x, jet.dxy.y);
        (self.dyy[0].0[k], self.dyy[1].0[k]) = (jet.dyy.x, jet.dyy.y);
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> Jet {
        let lane = |v: &[Lanes; 2]| DVec2::new(v[0].0[k], v[1].0[k]);
        Jet {
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
fn at_most_one_line(pattern: &Pattern, jets: &Jets, bend_px: f64) -> (Lanes, Mask, Mask, Lanes) {
    let (zero, half, one) = (Lanes::splat(0.0), Lanes::splat(0.5), Lanes::splat(1.0));
    let stray = [jets.stray(0), jets.stray(1)];
    let reach = [jets.reach(0) + stray[0], jets.reach(1) + stray[1]];
    let squares = pattern.squares(jets.seen, reach);
    let touched_x = half.le(squares.offset[0].abs() + reach[0]);
    let touched_y = half.le(squares.offset[1].abs() + reach[1]);
    let plain = squares.inside & !touched_x & !touched_y;
    // The axis across the line, and the line's distance from the centre along it.
    let upright = touched_x;
    let (a, b) = (pick(upright, jets.dx), pick(upright, jets.dy));
    let offset = pick(upright, squares.offset);
    let single = pick(upright, reach).lt(half + offset.abs());
    let backward = offset.lt(zero);
    let distance = half.negated_where(backward) - offset;
    let scale = (jets.dx[0] * jets.dy[1] - jets.dx[1] * jets.dy[0]).abs();
    let most = stray[0].max(stray[1]);
    let off_px = most * most / scale;
    let line = squares.inside & !plain & !(touched_x & touched_y) & single & off_px.le(Lanes::splat(bend_px));

    let steep_x = b.abs().le(a.abs());
    let (steep, flat) = (steep_x.select(a, b), steep_x.select(b, a));
    let (long, short) = (steep.abs(), flat.abs());
    let e = distance.abs();
    let inverse = one / steep;
    let rest = half * (long + short) - e;
    let corner = zero.lt(rest).select(rest * rest / (Lanes::splat(2.0) * long * short), zero);
    let share = e.le(half * (long - short)).select(half - e * inverse.abs(), corner);

    // Along the line, the steep coordinate of the pixel is (distance - flat s)/steep where the flat one is s.
    let (centre, reach) = (distance / flat, half * long / short);
    let from = (centre - reach).max(-half);
    let to = (centre + reach).min(half);
    let (xx, yy) = (pick(upright, jets.dxx), pick(upright, jets.dyy));
    let along = Along {
        slope: flat * inverse,
        start: distance * inverse,
        steep2: half * steep_x.select(xx, yy),
        flat2: half * steep_x.select(yy, xx),
        mixed: pick(upright, jets.dxy),
    };
    let simpson = (along.bend(from) + along.bend(to)) + Lanes::splat(4.0) * along.bend(half * (from + to));
    let bent = (to - from) * simpson * inverse.abs() * Lanes::splat(1.0 / 6.0);
    let crossed = from.lt(to) & zero.lt(rest);
    let beyond = share + crossed.select(bent, zero).negated_where(backward);
    let beyond = plain.select(zero, beyond.max(zero).min(one));
    (squares.mean + squares.contrast * (one - (beyond + beyond)), plain, line, off_px)
}

/// The second order of a map along a line through a pixel.
#[derive(Clone, Copy)]
struct Along {
    start: Lanes,
    slope: Lanes,
    steep2: Lanes,
    flat2: Lanes,
    mixed: Lanes,
}

impl Along {
    /// At the flat coordinate s.
    #[inline(always)]
    fn bend(&self, s: Lanes) -> Lanes {
        let t = self.start - self.slope * s;
        (self.steep2 * (t * t) + self.flat2 * (s * s)) + self.mixed * (t * s)
    }
}

/// The mean over a pixel of any kind.
fn several_lines(pattern: &Pattern, jet: &Jet, accuracy: &Accuracy) -> Cover {
    let stray = 0.125 * (jet.dxx.abs() + 2.0 * jet.dxy.abs() + jet.dyy.abs());
    let reach = 0.5 * (jet.dx.abs() + jet.dy.abs()) + stray;
    if let Some(value) = pattern.constant(jet.seen, reach) {
        return Cover::Plain(value);
    }
    let squares_per_px = jet.dx.perp_dot(jet.dy).abs().sqrt();
    let stray_px = stray.max_element() / squares_per_px.max(f64::MIN_POSITIVE);
    if stray_px.is_nan() || stray_px > MOST_BEND_PX {
        return Cover::TooBent;
    }
    // Parts that are flat to the error asked for: in each of n x n the map strays n^-2 as far.
    let wanted = (stray_px / accuracy.bend_px).sqrt().ceil().max(1.0);
    let parts = (wanted as u32).min(accuracy.max_division);
    let off_px = stray_px / f64::from(parts * parts);
    Cover::Edge { value: mean_of_parts(pattern, jet, parts), parts, off_px }
}

/// The mean over n x n parts of the pixel, each by the tangent of the map at its centre, which is moved to where the mean
/// of its second order lies. Mirror images are summed in pairs, so that their sums have the same bits.
fn mean_of_parts(pattern: &Pattern, jet: &Jet, n: u32) -> f64 {
    let side = 1.0 / f64::from(n);
    let shift = (jet.dxx + jet.dyy) * (side * side / 24.0);
    let place = |k: u32| (f64::from(2 * k + 1) - f64::from(n)) * (0.5 * side);
    let part = |i: u32, j: u32| {
        let p = DVec2::new(place(i), place(j));
        let bend = 0.5 * ((jet.dxx * (p.x * p.x) + jet.dyy * (p.y * p.y)) + jet.dxy * (2.0 * p.x * p.y));
        let seen = jet.seen + (jet.dx * p.x + jet.dy * p.y) + bend + shift;
        let right = (jet.dx + (jet.dxx * p.x + jet.dxy * p.y)) * (0.5 * side);
        let down = (jet.dy + (jet.dxy * p.x + jet.dyy * p.y)) * (0.5 * side);
        let polygon = [seen - right - down, seen + right - down, seen + right + down, seen - right + down];
        pattern.mean_over(&polygon).unwrap_or_else(|| mean_of_points(pattern, &polygon))
    };
    let row = |j: u32| {
        let pairs: f64 = (0..n / 2).map(|i| part(i, j) + part(n - 1 - i, j)).sum();
        if n % 2 == 1 { pairs + part(n / 2, j) } else { pairs }
    };
    (0..n).map(row).sum::<f64>() * (side * side)
}

/// The mean over a polygon that has shrunk to a line: a grid of points in it.
pub(super) fn mean_of_points(pattern: &Pattern, polygon: &[DVec2]) -> f64 {
    const N: usize = 32;
    let (a, b) = (polygon[1] - polygon[0], polygon[polygon.len() - 1] - polygon[0]);
    let place = |k: usize| (k as f64 + 0.5) / N as f64;
    let points = (0..N * N).map(|k| pattern.radiance(polygon[0] + a * place(k % N) + b * place(k / N)));
    points.sum::<f64>() / (N * N) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose;
    use crate::scene::Board;

    fn pattern() -> Pattern {
        Pattern::new(&Board {
            columns: 9,
            rows: 9,
            square_mm: 1.0,
            margin_mm: 0.0,
            world_from_board: Pose::IDENTITY,
            black: 0.1,
            white: 0.9,
            background: 0.4,
        })
    }

    fn one(pattern: &Pattern, jet: &Jet, accuracy: &Accuracy) -> Cover {
        cover(pattern, &Jets::splat(jet), accuracy)[0]
    }

    /// A pixel that spans some 0.2 squares, about `seen`, its map bent by `bend` px.
    fn jet(k: usize, seen: DVec2, bend: f64) -> Jet {
        let wave = |n: usize| libm::sin((k * n) as f64);
        Jet {
            seen,
            dx: 0.2 * DVec2::new(wave(3), wave(5)),
            dy: 0.2 * DVec2::new(wave(7), wave(11)),
            dxx: 0.2 * bend * DVec2::new(wave(13), wave(17)),
            dxy: 0.2 * bend * DVec2::new(wave(19), wave(23)),
            dyy: 0.2 * bend * DVec2::new(wave(29), wave(31)),
        }
    }

    /// The closed form of one line against the exact integral of many small flat parts.
    #[test]
    fn one_line_is_wrong_by_the_square_of_the_bend() {
        let pattern = pattern();
        let mut lines = 0;
        for bend in [0.0, 1e-4, 1e-3, 1e-2] {
            for k in 1..4000 {
                let seen = DVec2::new(3.9 * libm::sin(0.7 * k as f64), 3.9 * libm::cos(0.3 * k as f64));
                let jet = jet(k, seen, bend);
                // Nearly parallel steps make the pixel a line, on which "to second order" means nothing.
                if jet.dx.perp_dot(jet.dy).abs() < 0.2 * 0.02 {
                    continue;
                }
                let (value, plain, line, _) = at_most_one_line(&pattern, &Jets::splat(&jet), f64::INFINITY);
                if line.none() && plain.none() {
                    continue;
                }
                lines += usize::from(line.all());
                let parts = mean_of_parts(&pattern, &jet, 16);
                // 0.8 of contrast; second order in a bend that slanting steps magnify up to 20 times; in each part of
                // 1/16 the bend is left out along the line, whose mean is right.
                let bound = 1e-13 + 0.8 * (20.0 * bend * 20.0 * bend + bend / 256.0);
                assert!((value.0[0] - parts).abs() < bound, "{k} {bend}: {} {parts}", value.0[0]);
            }
        }
        assert!(lines > 2000, "{lines}");
    }

    #[test]
    fn mirrored_pixels_have_the_same_bits() {
        let pattern = pattern();
        let flip = |v: DVec2| DVec2::new(-v.x, v.y);
        for k in 1..4000 {
            let seen = DVec2::new(4.9 * libm::sin(0.7 * k as f64), 4.9 * libm::cos(0.3 * k as f64));
            let mut right = jet(k, seen, [0.0, 1e-5, 1e-3][k % 3]);
            if k % 5 == 0 {
                // Steps along the axes, and lines that pass through corners of pixels.
                right.dx.y = 0.0;
                right.dy.x = 0.0;
                right.seen.x = 0.5 - 0.5 * right.dx.x * libm::sin(k as f64).signum();
            }
            let left = Jet {
                seen: flip(right.seen),
                dx: -flip(right.dx),
                dy: flip(right.dy),
                dxx: flip(right.dxx),
                dxy: -flip(right.dxy),
                dyy: flip(right.dyy),
            };
            let accuracy = Accuracy::exact();
            assert_eq!(one(&pattern, &right, &accuracy), one(&pattern, &left, &accuracy), "{k}");
        }
    }

    #[test]
    fn a_line_through_the_middle_leaves_half() {
        let pattern = pattern();
        let upright = Jet {
            seen: DVec2::new(0.5, 0.0),
            dx: DVec2::new(0.1, 0.0),
            dy: DVec2::new(0.0, 0.1),
            dxx: DVec2::ZERO,
            dxy: DVec2::ZERO,
            dyy: DVec2::ZERO,
        };
        let value = |jet: &Jet| match one(&pattern, jet, &Accuracy::exact()) {
            Cover::Edge { value, .. } => value,
            other => panic!("{other:?}"),
        };
        assert!((value(&upright) - 0.5).abs() < 1e-15);
        // The line bows by dyy y^2 / 2 over y = -0.5 ..= 0.5, whose mean is dyy / 24, of 0.1 squares a px: to the right the
        // pixel sees 1/240 more of the white square at (1, 0).
        let bowed = Jet { dyy: DVec2::new(0.001, 0.0), ..upright };
        assert!((value(&bowed) - (0.5 + 0.8 * 0.001 / 24.0 / 0.1)).abs() < 1e-12);
    }
}
