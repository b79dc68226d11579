//! What lies between the points of a pupil: each stands for the part of it around it, whose blur is given to the mean of their pictures.
//!
//! A point of the pupil shows the board from one place; moved by u, it shows it moved by B u px, where B = J^-1 A, by the derivatives J of
//! what a pixel sees by the pixel's place and A by the point's. B differs little from place to place, so that what a part of the pupil
//! blurs in the picture of one point, it blurs in all of them, and in their mean. A part is a square of [`SHARE`] of the
//! pupil's area over the count of points; blurred by it, a picture is that of a pupil whose mean square has grown by that of the square.
//! So the points are drawn in by as much: mean and mean square are the pupil's own.
//!
//! Along rows and along columns a pixel becomes the mean of the pixels about it: of whole ones on either side and a share of the next, as
//! many as have the mean square wanted. Where the picture ends, it is that of as many as there are.
//!
//! The ridge and the rims of the glass, at another distance, are blurred otherwise. Where the pupil blurs them less than the board, parts
//! are taken as small as leave them as sharp as they are.

use crate::effect::Variant;
use crate::raster::Raster;
use crate::system::{Side, System};
use glam::{DMat2, DVec2};
use rayon::prelude::*;
use std::ops::Range;

/// The side of the square that a point stands for, as a share of that of its part of the pupil's area: parts of a whole one are seen to
/// overlap where edges run between points.
const SHARE: f64 = 0.8;
/// Places along each side of the picture where the blur is found.
const PLACES: usize = 17;
/// They stay this far inside it, in px.
const INSET_PX: f64 = 0.5;
/// The steps by which derivatives are taken, as shares of the pupil's radius and in px.
const STEP: f64 = 1e-3;
const STEP_PX: f64 = 0.5;
/// Mean squares below this, in px^2, are left out: those of a blur by half a pixel.
const LEAST: f64 = 0.25 / 12.0;
/// Pixels in a row that become the mean of as many pixels.
const RUN: usize = 16;
/// Rows that are blurred at a time.
const ROWS: usize = 16;
/// Columns that are blurred at a time: as many as keep their sums within a second-level cache.
const STRIP: usize = 64;

/// The blur of the parts of a pupil.
#[derive(Debug)]
pub(super) struct Fill {
    /// By how much points are drawn in.
    drawn_in: DVec2,
    size_px: [usize; 2],
    /// Mean squares of the blur of a part along rows and along columns, in px^2, at [`PLACES`] x [`PLACES`] places, row by row.
    squares: Vec<DVec2>,
}

impl Fill {
    /// The blur of the parts of the pupil of `system`; `None` where points stand for themselves, or it is too small to tell.
    pub(super) fn of(system: &System) -> Option<Self> {
        let effects = system.effects();
        let pupil = effects.filled_pupil()?;
        let ghosts = effects.ghosts.is_some_and(|ghosts| !ghosts.is_nothing());
        if ghosts || effects.diffracting().is_some() || effects.clipping.is_some() || !system.layers().is_empty() {
            return None;
        }

        // Find how far a step of the pupil moves the board, and how far the ridge, by the lens and the glass as it is meant.
        let lens = crate::effect::Effects { lens: effects.lens, ..Default::default() };
        let moves = PupilMoves::new(&system.with_effects(&lens), STEP * pupil.radius);
        let size_px = system.camera().size_px();
        let by_step: Vec<DMat2> = (0..PLACES * PLACES).map(|k| moves.of_board(place(size_px, k))).collect();
        let share = moves.of_ridge_to_board(DVec2::new(size_px[0] as f64, size_px[1] as f64) * 0.5);

        // Take the mean squares of a part of the pupil, and of its blur.
        let points: Vec<DVec2> = effects.variants(0).iter().map(|variant| variant.pupil).collect();
        let side_square = share * SHARE * SHARE * pupil.area() / points.len() as f64;
        let square = side_square / 12.0;
        let squares: Vec<DVec2> = by_step
            .iter()
            .map(|by| square * DVec2::new(by.row(0).length_squared(), by.row(1).length_squared()))
            .collect();
        let most = squares.iter().fold(0.0, |most: f64, square| most.max(square.max_element()));
        let own = points.iter().map(|p| *p * *p).sum::<DVec2>() / points.len() as f64;
        let drawn_in = ((pupil.mean_square() - square) / own).max(DVec2::ZERO).map(f64::sqrt);
        (most >= LEAST && drawn_in.is_finite()).then_some(Self { drawn_in, size_px, squares })
    }

    /// Where a point of the pupil is drawn in to.
    pub(super) fn drawn_in(&self, pupil: DVec2) -> DVec2 {
        pupil * self.drawn_in
    }

    /// Blurs the mean of the pictures of all points by the parts for which they stand.
    pub(super) fn spread(&self, picture: &mut Raster<f64>) {
        // Along columns, strip by strip.
        let [width, height] = self.size_px;
        let strips: Vec<Vec<f64>> = (0..width)
            .into_par_iter()
            .step_by(STRIP)
            .map(|first| self.strip(picture, first..width.min(first + STRIP)))
            .collect();

        // Along rows.
        picture.data_mut().par_chunks_mut(width * ROWS).enumerate().for_each(|(k, rows)| {
            let (mut columns, mut sums) = (Vec::with_capacity(width), vec![0.0; width + 1]);
            for (y, row) in (k * ROWS..height).zip(rows.chunks_mut(width)) {
                columns.clear();
                for strip in &strips {
                    let width = strip.len() / height;
                    columns.extend_from_slice(&strip[y * width..(y + 1) * width]);
                }
                let mut sum = 0.0;
                for (to, value) in sums[1..].iter_mut().zip(&columns) {
                    sum += value;
                    *to = sum;
                }
                let line = self.line(y as f64 + 0.5);
                for (first, run) in (0..).step_by(RUN).zip(row.chunks_mut(RUN)) {
                    let end = first + run.len();
                    let square = self.at(&line, 0.5 * (first + end) as f64).x;
                    let taps = Taps::new(square, first.min(width - end));
                    let whole = taps.whole;
                    let inner = [&sums[first - whole..end - whole], &sums[first + whole + 1..end + whole + 1]];
                    let next = (taps.share > 0.0).then(|| {
                        [&columns[first - whole - 1..end - whole - 1], &columns[first + whole + 1..end + whole + 1]]
                    });
                    taps.means(inner, next, run);
                }
            }
        });
    }

    /// The columns of the picture, blurred along them, row by row.
    fn strip(&self, picture: &Raster<f64>, columns: Range<usize>) -> Vec<f64> {
        // Sum up the rows.
        let (width, height) = (columns.len(), picture.height());
        let row = |y: usize, run: &Range<usize>| &picture.row(y)[columns.start + run.start..columns.start + run.end];
        let mut sums = vec![0.0; (height + 1) * width];
        for y in 0..height {
            let (above, here) = sums.split_at_mut((y + 1) * width);
            let above = &above[y * width..];
            let values = row(y, &(0..width));
            here.iter_mut().zip(above).zip(values).for_each(|((sum, above), value)| *sum = above + value);
        }

        // Take means of as many as the blur asks.
        let mut out = vec![0.0; height * width];
        for (y, out) in out.chunks_mut(width).enumerate() {
            let line = self.line(y as f64 + 0.5);
            for (first, out) in (0..).step_by(RUN).zip(out.chunks_mut(RUN)) {
                let run = first..first + out.len();
                let square = self.at(&line, columns.start as f64 + 0.5 * (run.start + run.end) as f64).y;
                let taps = Taps::new(square, y.min(height - 1 - y));
                let sum = |y: usize| &sums[y * width + run.start..y * width + run.end];
                let inner = [sum(y - taps.whole), sum(y + taps.whole + 1)];
                let next = (taps.share > 0.0).then(|| [row(y - taps.whole - 1, &run), row(y + taps.whole + 1, &run)]);
                taps.means(inner, next, out);
            }
        }
        out
    }

    /// The mean squares along the row at the height y of the picture, at the columns of the places.
    fn line(&self, y: f64) -> [DVec2; PLACES] {
        let (row, share) = between(y, self.size_px[1]);
        let at = |row: usize, k: usize| self.squares[row * PLACES + k];
        std::array::from_fn(|k| at(row, k).lerp(at(row + 1, k), share))
    }

    /// The mean squares at a column of the picture.
    fn at(&self, line: &[DVec2; PLACES], x: f64) -> DVec2 {
        let (k, share) = between(x, self.size_px[0]);
        line[k].lerp(line[k + 1], share)
    }
}

/// Place `k` of the picture.
fn place(size_px: [usize; 2], k: usize) -> DVec2 {
    let along = |k: usize, size: usize| {
        let size = size as f64;
        (size * k as f64 / (PLACES - 1) as f64).clamp(INSET_PX, size - INSET_PX)
    };
    DVec2::new(along(k % PLACES, size_px[0]), along(k / PLACES, size_px[1]))
}

/// The place before `at`, of those along a side of `size` px, and how far on it is to the next.
fn between(at: f64, size: usize) -> (usize, f64) {
    let along = at / size as f64 * (PLACES - 1) as f64;
    let k = (along.max(0.0) as usize).min(PLACES - 2);
    (k, along - k as f64)
}

/// The pixels of which one becomes the mean.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Taps {
    /// Whole ones on either side.
    whole: usize,
    /// The share of the next on either side.
    share: f64,
    /// One over their sum.
    weight: f64,
}

impl Taps {
    /// As many as have this mean square, in px^2, of `room` pixels on either side.
    fn new(square: f64, room: usize) -> Self {
        // m whole ones on either side have m (m + 1) / 3.
        let of = |m: f64| m * (m + 1.0) / 3.0;
        let most = room as f64;
        if square >= of(most) {
            return Self { whole: room, share: 0.0, weight: 1.0 / (2.0 * most + 1.0) };
        }
        let m = (0.5 * ((1.0 + 12.0 * square.max(0.0)).sqrt() - 1.0)).floor().min(most - 1.0);
        let pixels = 2.0 * m + 1.0;
        let next = (m + 1.0) * (m + 1.0);
        let both = (pixels * (square - of(m)) / (next - square)).clamp(0.0, 2.0);
        Self { whole: m as usize, share: 0.5 * both, weight: 1.0 / (pixels + both) }
    }

    /// The means of a run of pixels, given the sums before the first and after the last of the whole ones, and the next on either
    /// side where they have a share.
    #[inline(always)]
    fn means(&self, [before, after]: [&[f64]; 2], next: Option<[&[f64]; 2]>, out: &mut [f64]) {
        let sums = before.iter().zip(after).map(|(before, after)| after - before);
        match next {
            None => out.iter_mut().zip(sums).for_each(|(out, sum)| *out = sum * self.weight),
            Some([a, b]) => {
                let ends = a.iter().zip(b).map(|(a, b)| self.share * (a + b));
                out.iter_mut().zip(sums.zip(ends)).for_each(|(out, (sum, ends))| *out = (sum + ends) * self.weight);
            }
        }
    }
}

/// Instruments a step of the pupil to either side along both axes, by which derivatives are taken.
struct PupilMoves {
    own: System,
    step: f64,
    beside: [[System; 2]; 2],
}

impl PupilMoves {
    fn new(own: &System, step: f64) -> Self {
        let plain = own.effects().variants(0).get(0);
        let beside = [DVec2::X, DVec2::Y]
            .map(|axis| [-step, step].map(|by| own.variant(&Variant { pupil: axis * by, ..plain })));
        let own = own.variant(&Variant { pupil: DVec2::ZERO, ..plain });
        Self { own, step, beside }
    }

    /// How far the board moves in the picture at `px` by the pupil's place: px by its units. 0 where it is not seen.
    fn of_board(&self, px: DVec2) -> DMat2 {
        let seen = || {
            let side = self.own.trace(px).ok()?.side;
            let mm_by_px = self.own.footprint_through(px, side).ok()?.jacobian;
            let at = |system: &System| Some(system.footprint_through(px, side).ok()?.sight.board_mm);
            let by = |[before, behind]: &[System; 2]| Some((at(behind)? - at(before)?) / (2.0 * self.step));
            let moves = mm_by_px.inverse() * DMat2::from_cols(by(&self.beside[0])?, by(&self.beside[1])?);
            moves.is_finite().then_some(moves)
        };
        seen().unwrap_or(DMat2::ZERO)
    }

    /// The square of how far the ridge moves near `px` over how far the board does across it, at most 1; 0 where it is not known.
    fn of_ridge_to_board(&self, px: DVec2) -> f64 {
        if self.own.prism().is_none() {
            return 1.0;
        }
        let by_side = |side: Side| {
            let x_mm = |system: &System, px: DVec2| system.front_x_mm(px, side);
            let along = |axis: DVec2| {
                Some((x_mm(&self.own, px + axis * STEP_PX)? - x_mm(&self.own, px - axis * STEP_PX)?) / (2.0 * STEP_PX))
            };
            let by = |[before, behind]: &[System; 2]| Some((x_mm(behind, px)? - x_mm(before, px)?) / (2.0 * self.step));
            let by_px = DVec2::new(along(DVec2::X)?, along(DVec2::Y)?);
            let by_pupil = DVec2::new(by(&self.beside[0])?, by(&self.beside[1])?);
            let board = (self.of_board(px).transpose() * by_px.normalize()).length();
            let ridge = by_pupil.length() / by_px.length();
            let share = ridge / board;
            Some(share * share).filter(|share| !share.is_nan())
        };
        let shares = Side::ALL.into_iter().filter_map(by_side);
        shares.reduce(f64::min).map_or(0.0, |share| share.min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Their weights sum up to 1, and their mean square is the one asked for, or that of the room.
    #[test]
    fn taps_have_the_mean_square() {
        for square in [0.0, 0.02, 0.3, 2.0 / 3.0, 1.7, 2.0, 40.0, 333.3] {
            for room in [0, 1, 2, 9, 100] {
                let Taps { whole, share, weight } = Taps::new(square, room);
                let m = whole as f64;
                let sum = (2.0 * m + 1.0 + 2.0 * share) * weight;
                let found = (m * (m + 1.0) * (2.0 * m + 1.0) / 3.0 + 2.0 * share * (m + 1.0) * (m + 1.0)) * weight;
                let most = room as f64 * (room as f64 + 1.0) / 3.0;
                assert!((sum - 1.0).abs() < 1e-14, "{square} {room}: {sum}");
                assert!((found - square.min(most)).abs() < 1e-12 * (1.0 + square), "{square} {room}: {found}");
                assert!(whole + usize::from(share > 0.0) <= room);
            }
        }
    }

    /// A single light becomes one of the mean squares asked for at its place, whatever the picture's size is to strips and runs.
    #[test]
    fn a_light_is_spread_by_the_mean_squares() {
        for size_px in [[150, 97], [97, 150], [64, 64]] {
            let squares = vec![DVec2::new(7.3, 21.9); PLACES * PLACES];
            let fill = Fill { drawn_in: DVec2::ONE, size_px, squares };
            let mut picture = Raster::filled(size_px[0], size_px[1], 0.0);
            let (x, y) = (41, 45);
            picture.data_mut()[y * size_px[0] + x] = 1.0;
            fill.spread(&mut picture);
            let (mut sum, mut mean, mut square) = (0.0, DVec2::ZERO, DVec2::ZERO);
            for (j, i) in (0..size_px[1]).flat_map(|j| (0..size_px[0]).map(move |i| (j, i))) {
                let off = DVec2::new(i as f64 - x as f64, j as f64 - y as f64);
                let value = picture.get(i, j);
                (sum, mean, square) = (sum + value, mean + off * value, square + off * off * value);
            }
            assert!((sum - 1.0).abs() < 1e-12 && mean.length() < 1e-11, "{sum} {mean}");
            assert!((square - DVec2::new(7.3, 21.9)).length() < 1e-10, "{square}");
        }
    }
}
