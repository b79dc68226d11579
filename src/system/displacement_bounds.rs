//! Bounds of what displacements change: of effects by which an instrument sees other points of the board.

use super::instrument::System;
use super::radiance_range::{Bound, GRID, RadianceRange, SMALL_GRID, extremes, grid};
use super::ridge_image::{ridge_moves, rows};
use crate::effect::{Bounding, EffectId, EffectRow, Effects, Variant};
use glam::DVec2;
use rayon::prelude::*;

/// Variants of other effects among which one is looked at, and its own variants there.
const AMONG: usize = 8;
const OWN: usize = 64;
/// Variants beyond this count are not examined: their effect is kept.
const MOST_VARIANTS: usize = 2048;
/// Of a wave that the rays of a grid follow, they are at most so much of its phase apart.
const FOLLOWED_RAD: f64 = 1.5;
/// Moves of an edge below this, in px, leave it within the ramp of a pixel.
const SMALL_PX: f64 = 0.25;

/// By how far all variants of `with` see from what `without` sees. `None` where rays end, so that it cannot be told.
pub(super) fn displacements(without: &System, with: &System, light: RadianceRange) -> Option<Bound> {
    if !waves_are_followed(with) {
        return None;
    }
    let seen = variants(&with.effects)?;
    let systems: Vec<(f64, System)> = seen.iter().map(|variant| (variant.grey, with.variant(variant))).collect();
    displaced(without, &systems, light, GRID)
}

/// Whether the rays of the grid follow the waves of the surfaces: a wave of their own distance looks like none.
fn waves_are_followed(with: &System) -> bool {
    let Some(made) = &with.effects.manufacture else { return true };
    let figures = [&made.front, &made.back].into_iter().filter_map(|surface| surface.figure.as_ref());
    let shortest = figures.flat_map(|figure| &figure.waves).map(|wave| wave.rad_per_mm.length()).fold(0.0, f64::max);
    if shortest == 0.0 {
        return true;
    }
    let met: Vec<Option<DVec2>> =
        grid(with, GRID).into_iter().map(|px| with.path(px).0.points.last().map(|point| point.truncate())).collect();
    let step = |a: usize, b: usize| met[a].zip(met[b]).map_or(f64::INFINITY, |(a, b)| a.distance(b));
    let across = (0..met.len()).filter(|k| k % GRID[0] > 0).map(|k| step(k, k - 1));
    let down = (GRID[0]..met.len()).map(|k| step(k, k - GRID[0]));
    across.chain(down).fold(0.0, f64::max) * shortest < FOLLOWED_RAD
}

/// The same among variants of the other effects that let rays stray.
pub(super) fn displaced_among(
    ideal: &System,
    effects: &Effects,
    row: &EffectRow,
    light: RadianceRange,
) -> Option<Bound> {
    let others = effects.only(|other| {
        other.id == EffectId::Telecentric || (other.id != row.id && other.bounding == Bounding::Displacements)
    });
    let all = effects.only(|other| other.id == EffectId::Telecentric || other.bounding == Bounding::Displacements);
    let own = effects.only(|other| other.id == EffectId::Telecentric || other.id == row.id);
    let (before, after) = (ideal.with_effects(&others), ideal.with_effects(&all));
    let own = variants(&own)?;
    let own: Vec<Variant> = own.iter().step_by(own.len().div_ceil(OWN)).copied().collect();
    let mut worst = Bound { grey: 0.0, px: 0.0 };
    for other in others.variants(0).some(AMONG) {
        // A variant of both: what varies by this effect is its own.
        let both = |own: &Variant| match row.id {
            EffectId::ThinLens => Variant { pupil: own.pupil, ..other },
            EffectId::Roughness => Variant { slopes: own.slopes, ..other },
            EffectId::Dispersion => Variant { wave: own.wave, ..other },
            _ => other,
        };
        let systems: Vec<(f64, System)> = own.iter().map(|own| (own.grey, after.variant(&both(own)))).collect();
        worst = worst.or(displaced(&before.variant(&other), &systems, light, SMALL_GRID)?);
    }
    Some(worst)
}

/// By how far `systems`, each with its share of the picture, see from what `without` sees, over places of a grid. `None` where it
/// cannot be told.
fn displaced(without: &System, systems: &[(f64, System)], light: RadianceRange, size: [usize; 2]) -> Option<Bound> {
    // Beside the edge in which the two backs of a solid prism meet, a small move takes a ray from the one to the other.
    if without.is_creased_by_halves_alone() {
        return None;
    }
    let total: f64 = systems.iter().map(|(share, _)| share).sum();
    let strays = |px: &DVec2| {
        let side = without.trace(*px).ok()?.side;
        let here = without.footprint_through(*px, side).ok()?;
        let mut lines = [Moves::default(); 2];
        for (share, system) in systems {
            let there = system.footprint_through(*px, side).ok()?;
            let moved_mm = there.sight.board_mm - here.sight.board_mm;
            for (axis, line) in lines.iter_mut().enumerate() {
                line.add(share / total, moved_mm[axis] / here.jacobian.row(axis).length());
            }
        }
        Some(lines)
    };
    let strays = grid(without, size).par_iter().map(strays).collect::<Option<Vec<[Moves; 2]>>>()?;
    let over_grid = |of: &dyn Fn(&[Moves; 2]) -> f64| {
        let (largest, step) = extremes(&strays.iter().map(of).collect::<Vec<_>>(), size);
        largest + step
    };
    let lines_px = [0, 1].map(|axis| over_grid(&|lines| lines[axis].of_mean()));
    let ridges: Option<Vec<(f64, Vec<f64>)>> =
        systems.par_iter().map(|(share, system)| Some((share / total, ridge_moves(without, system)?))).collect();
    let mut ridge = vec![Moves::default(); rows(without).count()];
    for (share, moves) in ridges? {
        ridge.iter_mut().zip(moves).for_each(|(row, px)| row.add(share, px));
    }
    let ridge_px = ridge.iter().map(Moves::of_mean).fold(0.0, f64::max);
    let px = over_grid(&|lines| DVec2::new(lines[0].edge_px(), lines[1].edge_px()).length());
    Some(Bound { grey: light.moved_by(lines_px, ridge_px), px })
}

/// How far a line moves in the pictures that a picture is the mean of, across itself, in px.
#[derive(Debug, Clone, Copy, Default)]
struct Moves {
    mean: f64,
    mean_size: f64,
    largest: f64,
}

impl Moves {
    fn add(&mut self, share: f64, px: f64) {
        self.mean += share * px;
        self.mean_size += share * px.abs();
        self.largest = self.largest.max(px.abs());
    }

    /// What the mean of the pictures changes as a move by so much would at most. The share of a pixel beyond a line grows by
    /// between 0 and s a px; by s / 2 of the mean move, that is, and at most s / 2 more of each.
    fn of_mean(&self) -> f64 {
        0.5 * (self.mean.abs() + self.mean_size)
    }

    /// How far an edge moves in the mean of the pictures: while all are within the ramp of a pixel, as their mean.
    fn edge_px(&self) -> f64 {
        if self.largest < SMALL_PX { self.mean_size } else { self.largest }
    }
}

/// All variants that the picture may be the mean of; `None` where they are more than can be examined in a moment.
pub(super) fn variants(effects: &Effects) -> Option<Vec<Variant>> {
    let sets = effects.sets();
    if effects.variants(0).len().saturating_mul(sets) > MOST_VARIANTS {
        return None;
    }
    Some((0..sets).flat_map(|set| effects.variants(set).iter().collect::<Vec<_>>()).collect())
}
