//! What bounds of effects are made of: the radiances of a scene, and places over its picture.

use super::instrument::System;
use crate::scene::BoardSpec;
use glam::DVec2;
use rayon::prelude::*;
use std::f64::consts::SQRT_2;

/// Rays along the width and the height of the grid.
pub(super) const GRID: [usize; 2] = [33, 17];
/// The same where many instruments are compared.
pub(super) const SMALL_GRID: [usize; 2] = [17, 9];
/// Places of the grid stay this far inside the picture, in px.
pub(super) const INSET_PX: f64 = 1e-6;

/// What an effect changes at most.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Bound {
    /// Change of a pixel, of full scale 1.
    pub grey: f64,
    /// Move of an edge, in px.
    pub px: f64,
}

impl Bound {
    /// The larger of both.
    pub(super) fn or(self, other: Self) -> Self {
        Self { grey: self.grey.max(other.grey), px: self.px.max(other.px) }
    }

    /// Both together.
    pub(super) fn and(self, other: Self) -> Self {
        Self { grey: self.grey + other.grey, px: self.px + other.px }
    }
}

/// What the light of a scene has to do with changes of its picture.
#[derive(Clone, Copy)]
pub(super) struct RadianceRange {
    pub(super) brightest: f64,
    /// Between any two things.
    pub(super) contrast: f64,
    /// Between the squares.
    pub(super) edge: f64,
    /// Of the squares.
    pub(super) mean: f64,
    /// Lines of the board through one pixel, at most.
    pub(super) lines: f64,
    /// Whether the ridge of a prism may be seen as well: 1 or 0.
    pub(super) ridge: f64,
}

impl RadianceRange {
    pub(super) fn of(system: &System) -> Self {
        let board = &system.board().pattern;
        let all = [board.black, board.white, board.background];
        let (low, high) = all.iter().fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(*v), high.max(*v)));
        let edge = (board.white - board.black).abs();
        let mean = 0.5 * (board.black + board.white);
        let ridge = if system.prism().is_some() { 1.0 } else { 0.0 };
        Self { brightest: high, contrast: high - low, edge, mean, lines: lines(system, board), ridge }
    }

    /// That of a scene lit `gain` times as brightly, in which an edge may be of the scene's own contrast.
    pub(super) fn times(self, gain: f64) -> Self {
        Self { brightest: gain * self.brightest, contrast: (gain - 1.0) * self.brightest + self.contrast, ..self }
    }

    /// How far an edge between squares moves by what changes pixels by up to `grey`.
    pub(super) fn moved_px(&self, grey: f64) -> f64 {
        if self.edge > 0.0 { 2.0 * grey / self.edge } else { 0.0 }
    }

    /// The change of a pixel where the board moves by up to `px` and the image of the ridge by up to `ridge_px`.
    pub(super) fn moved_by(&self, px: f64, ridge_px: f64) -> f64 {
        self.contrast * (SQRT_2 * (self.lines * px + self.ridge * ridge_px)).min(1.0)
    }
}

/// Lines of the board through one pixel, at most: of each family one more than the lines' distances that a pixel is wide,
/// and on both sides of the ridge.
fn lines(system: &System, board: &BoardSpec) -> f64 {
    let margin = if board.margin_mm > 0.0 { board.margin_mm } else { f64::INFINITY };
    let distance_mm = board.square_mm.min(margin);
    let across = |px: &DVec2| {
        let Ok(footprint) = system.footprint(*px) else { return DVec2::ZERO };
        (footprint.jacobian.x_axis.abs() + footprint.jacobian.y_axis.abs()) / distance_mm
    };
    let spans: Vec<DVec2> = grid(system, GRID).par_iter().map(across).collect();
    let widest = |of: fn(&DVec2) -> f64| {
        let (largest, step) = extremes(&spans.iter().map(of).collect::<Vec<_>>(), GRID);
        (largest + step).floor() + 1.0
    };
    let families = widest(|span| span.x) + widest(|span| span.y);
    if system.prism().is_some() { 2.0 * families } else { families }
}

/// Places over the picture, row by row.
pub(super) fn grid(system: &System, [columns, rows]: [usize; 2]) -> Vec<DVec2> {
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let place = |i: usize, n: usize, side: f64| (side * i as f64 / (n - 1) as f64).clamp(INSET_PX, side - INSET_PX);
    let row = |j: usize| (0..columns).map(move |i| DVec2::new(place(i, columns, width), place(j, rows, height)));
    (0..rows).flat_map(row).collect()
}

/// The largest of values on a grid, and the largest step between neighbours.
pub(super) fn extremes(values: &[f64], [columns, _]: [usize; 2]) -> (f64, f64) {
    let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let step = |a: usize, b: usize| (values[a] - values[b]).abs();
    let across = (0..values.len()).filter(|k| k % columns > 0).map(|k| step(k, k - 1));
    let down = (columns..values.len()).map(|k| step(k, k - columns));
    (largest, across.chain(down).fold(0.0, f64::max))
}
