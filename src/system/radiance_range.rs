//! What bounds of effects are made of: the radiances of a scene, and places over its picture.

use super::instrument::System;
use super::ridge_image::{INSET_PX, ridge_direction};
use crate::scene::BoardSpec;
use glam::DVec2;
use rayon::prelude::*;
use std::f64::consts::SQRT_2;

/// Rays along the width and the height of the grid.
pub(super) const GRID: [usize; 2] = [33, 17];
/// The same where many instruments are compared.
pub(super) const SMALL_GRID: [usize; 2] = [17, 9];

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
    /// What the lines of the board along y and along x, in one pixel, sweep of it for each px that they move across themselves,
    /// at most.
    lines: [f64; 2],
    /// The same of the image of the ridge; 0 without a prism.
    ridge: f64,
    /// All of them together.
    pub(super) sweep: f64,
}

impl RadianceRange {
    pub(super) fn of(system: &System) -> Self {
        let board = &system.board().pattern;
        let all = [board.black, board.white, board.background];
        let (low, high) = all.iter().fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(*v), high.max(*v)));
        let edge = (board.white - board.black).abs();
        let mean = 0.5 * (board.black + board.white);
        let (lines, ridge) = sweeps(system, board);
        Self { brightest: high, contrast: high - low, edge, mean, lines, ridge, sweep: lines[0] + lines[1] + ridge }
    }

    /// That of a scene lit `gain` times as brightly, in which an edge may be of the scene's own contrast.
    pub(super) fn times(self, gain: f64) -> Self {
        Self { brightest: gain * self.brightest, contrast: (gain - 1.0) * self.brightest + self.contrast, ..self }
    }

    /// How far an edge between squares moves by what changes pixels by up to `grey`.
    pub(super) fn moved_px(&self, grey: f64) -> f64 {
        if self.edge > 0.0 { 2.0 * grey / self.edge } else { 0.0 }
    }

    /// The change of a pixel where the lines of the board along y and along x move by up to `px`, each across itself, and the
    /// image of the ridge by up to `ridge_px`.
    pub(super) fn moved_by(&self, px: [f64; 2], ridge_px: f64) -> f64 {
        self.contrast * (self.lines[0] * px[0] + self.lines[1] * px[1] + self.ridge * ridge_px).min(1.0)
    }
}

/// What the lines of the board along y and along x, and the image of the ridge, sweep of a pixel for each px that they move: as
/// many lines of a family as the distances between them that a pixel is wide, and one, each as long as a line of its direction
/// is in a pixel at most. In a pixel on the ridge those on both sides of it count.
fn sweeps(system: &System, board: &BoardSpec) -> ([f64; 2], f64) {
    let margin = if board.margin_mm > 0.0 { board.margin_mm } else { f64::INFINITY };
    let distance_mm = system.feature_mm().min(margin);
    let ridge = system.prism().map(|_| ridge_direction(system));
    let family = |axis: usize| {
        // Of each place: the lines across a pixel, and how long one is, on both sides of the ridge together.
        let of = |px: &DVec2| {
            let Ok(footprint) = system.footprint(*px) else { return [0.0, 2.0 * SQRT_2] };
            let slope = footprint.jacobian.row(axis);
            let span = slope.abs().element_sum() / distance_mm;
            let length = longest(slope.perp());
            let both = match ridge {
                None => length,
                Some(None) => 2.0 * length,
                Some(Some(along)) => {
                    // Each reaches over a part of the pixel's extent across the ridge.
                    let across = along.perp().abs().element_sum();
                    (2.0 * length).min(across / along.perp_dot(slope.perp().normalize_or_zero()).abs())
                }
            };
            [span, both]
        };
        let found: Vec<[f64; 2]> = grid(system, GRID).par_iter().map(of).collect();
        let most = |k: usize| {
            let (largest, step) = extremes(&found.iter().map(|place| place[k]).collect::<Vec<_>>(), GRID);
            largest + step
        };
        (most(0).floor() + 1.0) * most(1).min(2.0 * SQRT_2)
    };
    let ridge = match ridge {
        None => 0.0,
        // A row counts how far it moves to the right.
        Some(along) => along.map_or(SQRT_2, |along| longest(along) * along.y.abs()),
    };
    ([family(0), family(1)], ridge)
}

/// How long a line of a direction is in a pixel at most.
fn longest(direction: DVec2) -> f64 {
    direction.length() / direction.abs().max_element().max(f64::MIN_POSITIVE)
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
