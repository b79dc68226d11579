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

/// More corners than this in a half are not looked for: their squares would be about 2 px wide at most on any sensor
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
    outer && aimer.aim(board_mm, frame.side()).is_ok_and(seen)
}

/// A rectangle on the board, in mm, that holds everything the half sees: that of a grid of looks, grown by a cell.
fn seen_range(system: &System, frame: &HalfFrame) -> Option<[DVec2; 2]> {
    const N: usize = 32;
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
