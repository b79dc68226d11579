//! Where the corners of the board really are in a picture, by the exact inverse trace.

use super::half_image::HalfFrame;
use crate::system::System;
use crate::system::aim::Aimer;
use glam::DVec2;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A corner of the board in a half image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueCorner {
    /// Position, in px from the half's own origin.
    pub position_px: DVec2,
    /// Whether the four squares that meet in it are wholly in the half.
    pub whole: bool,
}

/// Corners of a half by board index (column, row).
pub type TrueCorners = BTreeMap<[i32; 2], TrueCorner>;

/// More corners than this in a half are not sought: their squares would be about 2 px wide at most on any sensor
/// that is allowed, and no detector resolves them.
const MOST_CORNERS: usize = 1_000_000;

/// Every inner corner of the board that the half sees, with its exact position; `None` when there are more than could
/// be told apart.
pub fn corners(system: &System, aimer: &Aimer<'_>, frame: &HalfFrame) -> Option<TrueCorners> {
    let [columns, rows] = system.board().inner_corners();
    let Some([low, high]) = seen_range(aimer.main_light(), frame) else { return Some(TrueCorners::new()) };
    let range = |axis: usize, count: usize| {
        let square = system.board().pattern.square_mm;
        let index = |mm: f64| mm / square + 0.5 * (count as f64 + 1.0) - 1.0;
        let first = index(low[axis]).floor().max(0.0) as usize;
        let end = (index(high[axis]).ceil() + 1.0).clamp(0.0, count as f64) as usize;
        first..end.max(first)
    };
    let (columns, rows) = (range(0, columns), range(1, rows));
    if columns.len().saturating_mul(rows.len()) > MOST_CORNERS {
        return None;
    }
    let indices: Vec<[usize; 2]> = rows.flat_map(|row| columns.clone().map(move |column| [column, row])).collect();
    let aimed: BTreeMap<[i32; 2], DVec2> = indices
        .par_iter()
        .filter_map(|&[column, row]| {
            let board_mm = system.board().corner_at(column as f64, row as f64);
            if is_beyond(aimer, frame, board_mm) {
                return None;
            }
            let full_px = aimer.aim(board_mm, frame.side()).ok()?;
            // Through the side as the ridge really bounds it, not as it was continued for the search.
            let seen = frame.contains(frame.own(full_px)) && aimer.sees(full_px, frame.side());
            seen.then(|| ([column as i32, row as i32], frame.own(full_px)))
        })
        .collect::<Vec<_>>()
        .into_iter()
        .collect();
    let whole = |[column, row]: [i32; 2]| {
        let around = (-1..=1).flat_map(|j| (-1..=1).map(move |i| [column + i, row + j]));
        around.into_iter().all(|index| aimed.contains_key(&index) || on_rim(system, aimer, frame, index))
    };
    Some(aimed.iter().map(|(&index, &position_px)| (index, TrueCorner { position_px, whole: whole(index) })).collect())
}

/// Whether the index is that of an outer corner of the squares, which is no crossing, and lies in the half.
fn on_rim(system: &System, aimer: &Aimer<'_>, frame: &HalfFrame, [column, row]: [i32; 2]) -> bool {
    let [columns, rows] = system.board().inner_corners().map(|n| n as i32);
    let outer = column == -1 || row == -1 || column == columns || row == rows;
    let board_mm = system.board().corner_at(f64::from(column), f64::from(row));
    let seen = |px| frame.contains(frame.own(px)) && aimer.sees(px, frame.side());
    outer && !is_beyond(aimer, frame, board_mm) && aimer.aim(board_mm, frame.side()).is_ok_and(seen)
}

/// How far a place must be seen beyond the half to be out of the question, in px.
const BEYOND_PX: f64 = 8.0;
/// Steps after which a place is left to the search.
const MOST_STEPS: usize = 8;
/// A step along the border of a half that is shorter has come to an end, in px.
const SETTLED_PX: f64 = 0.5;

/// Whether the half surely does not show a place of the board, so that it need not be searched for outside, where the glass may end: from
/// the pixel of the half's border that looks nearest to it, it lies well outside. Newton's method, kept within the half, tells; of
/// surfaces in more parts than the two backs of one piece of glass, across which the map leaps, it tells nothing.
fn is_beyond(aimer: &Aimer<'_>, frame: &HalfFrame, board_mm: DVec2) -> bool {
    let (system, side) = (aimer.main_light(), frame.side());
    let Some(mut px) =
        aimer.nearest_start(board_mm, side).filter(|_| system.most_parts().iter().all(|parts| *parts <= 2))
    else {
        return false;
    };
    let [low, high] = [frame.full(DVec2::ZERO), frame.full(frame.size_px)];
    for _ in 0..MOST_STEPS {
        let Ok(here) = system.footprint_through(px, side) else { return false };
        let next = px + here.jacobian.inverse() * (board_mm - here.sight.board_mm);
        let kept = next.clamp(low, high);
        // What leads into the half, or nowhere, is for the search.
        if !next.is_finite() || kept == next {
            return false;
        }
        if kept.distance(px) < SETTLED_PX {
            return kept.distance(next) > BEYOND_PX;
        }
        px = kept;
    }
    false
}

/// A rectangle on the board, in mm, that holds everything the half sees: that of a grid of traced pixels, grown by a
/// cell.
fn seen_range(system: &System, frame: &HalfFrame) -> Option<[DVec2; 2]> {
    const N: usize = 16;
    let place = |i: usize, j: usize| frame.full(frame.size_px * DVec2::new(i as f64, j as f64) / N as f64);
    let mut range: Option<[DVec2; 2]> = None;
    for (i, j) in (0..=N).flat_map(|j| (0..=N).map(move |i| (i, j))) {
        if let Ok(f) = system.footprint_through(place(i, j), frame.side()) {
            let (here, cell) = (f.sight.board_mm, frame.size_px / N as f64);
            let reach = f.jacobian.x_axis.abs() * cell.x + f.jacobian.y_axis.abs() * cell.y;
            let [low, high] = range.unwrap_or([here, here]);
            range = Some([low.min(here - reach), high.max(here + reach)]);
        }
    }
    range
}
