//! What a corner is held against: the corners around it. Light may fall by any factor over a board, and with it contrast and
//! noise, so that no corner is judged by those at the other end.

use super::candidate::NEIGHBOURS;
use super::corner_fit::CornerFit;
use super::lattice_growth::Lattice;
use crate::num::stats::quantile;
use glam::IVec2;
use std::collections::BTreeMap;

/// The weakest contrast against what the next corners along a line lead to: growth takes no weaker neighbour either.
const LEAST_CONTRAST: f64 = 0.25;
/// The largest residual, as a share of the contrast, against the median of the corners within two steps, and of all: of 7,500
/// true corners on photographs none has more than 3.8 times both, of crossings at a board's rim, where the background has two
/// levels of its own, all have more.
const MOST_RESIDUAL: f64 = 4.0;
/// The same at a line of a lattice's rim that has no more than half as many corners as the line beside it: a board has whole lines, and
/// what is behind its rim makes crossings here and there.
const MOST_AT_RIM: f64 = 2.0;
/// A residual below this share of the contrast is no sign of anything: without noise the rest of the model's own error differs from
/// corner to corner by more than any factor.
const SMALL_RESIDUAL: f64 = 0.006;
/// How far the corners around one reach, in steps.
const AROUND: i32 = 2;
/// Corners that make a median of their own.
const LEAST_AROUND: usize = 3;

/// Contrast, and residual as a share of it, of each corner of a lattice.
#[derive(Debug, Default)]
pub(super) struct Neighbourhood {
    contrast: BTreeMap<[i32; 2], f64>,
    relative: BTreeMap<[i32; 2], f64>,
    typical: f64,
    /// Corners in each column, and in each row.
    counts: [BTreeMap<i32, usize>; 2],
}

impl Neighbourhood {
    /// From the fits of some corners, and the contrasts of those that were fitted before.
    pub(super) fn new<'a>(
        fits: impl Iterator<Item = ([i32; 2], &'a CornerFit)>,
        known: impl Iterator<Item = ([i32; 2], f64)>,
    ) -> Self {
        let mut contrast: BTreeMap<[i32; 2], f64> = known.collect();
        let mut relative = BTreeMap::new();
        for (cell, fit) in fits {
            let own = 2.0 * fit.model.light[3].abs();
            contrast.insert(cell, own);
            relative.insert(cell, fit.residual / own);
        }
        let typical = median(relative.values().copied()).unwrap_or(0.0);
        let mut counts: [BTreeMap<i32, usize>; 2] = Default::default();
        for cell in relative.keys() {
            (0..2).for_each(|axis| *counts[axis].entry(cell[axis]).or_default() += 1);
        }
        Self { contrast, relative, typical, counts }
    }

    /// Whether a corner is far fainter than the corners beside it along some line lead to.
    pub(super) fn is_faint(&self, cell: [i32; 2]) -> bool {
        let Some(own) = self.contrast.get(&cell) else { return false };
        NEIGHBOURS.into_iter().any(|direction| {
            let at = |k: i32| self.contrast.get(&(IVec2::from_array(cell) + direction * k).to_array());
            // Carry on a fall by a constant factor, and no rise.
            let foretold = |near: f64, far: f64| near * (near / far).clamp(LEAST_CONTRAST, 1.0);
            let stronger = at(1).filter(|near| *own < LEAST_CONTRAST * **near);
            stronger.is_some_and(|near| at(2).is_some_and(|far| *own < LEAST_CONTRAST * foretold(*near, *far)))
        })
    }

    /// Whether the picture at a corner is far less like two crossing edges than around it.
    pub(super) fn is_unlike(&self, cell: [i32; 2]) -> bool {
        let Some(&own) = self.relative.get(&cell) else { return false };
        // Below this it is alike to all, whatever the corners around it are.
        if own <= SMALL_RESIDUAL.max(MOST_AT_RIM * self.typical) {
            return false;
        }
        let around = (-AROUND..=AROUND).flat_map(|i| (-AROUND..=AROUND).map(move |j| [cell[0] + i, cell[1] + j]));
        let around: Vec<f64> =
            around.filter(|other| *other != cell).filter_map(|other| self.relative.get(&other).copied()).collect();
        let near = if around.len() < LEAST_AROUND { None } else { median(around.into_iter()) };
        let most = if self.is_at_gappy_rim(cell) { MOST_AT_RIM } else { MOST_RESIDUAL };
        own > SMALL_RESIDUAL.max(most * self.typical.max(near.unwrap_or(0.0)))
    }

    /// Whether a corner is in a line of the rim with no more than half as many corners as the line beside it.
    fn is_at_gappy_rim(&self, cell: [i32; 2]) -> bool {
        (0..2).any(|axis| {
            let count = |line: i32| self.counts[axis].get(&line).copied().unwrap_or(0);
            let own = count(cell[axis]);
            [-1, 1].into_iter().any(|out| count(cell[axis] + out) == 0 && 2 * own <= count(cell[axis] - out))
        })
    }
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    quantile(&values.collect::<Vec<_>>(), 0.5)
}

/// The corners that hang on their lattice by a single neighbour, or by none, though the places beside them are in sight: a
/// crossing of a board's rim with an edge behind it makes a row of its own. `in_sight` tells of a cell where a corner is missing.
pub(super) fn hanging(lattice: &Lattice, in_sight: impl Fn([i32; 2]) -> bool) -> Vec<[i32; 2]> {
    let beside = |cell: [i32; 2]| NEIGHBOURS.map(|n| (IVec2::from_array(cell) + n).to_array());
    let hangs = |cell: &[i32; 2]| {
        let missing: Vec<_> = beside(*cell).into_iter().filter(|other| !lattice.contains_key(other)).collect();
        // Along one of its lines at least nothing is out of sight.
        missing.len() >= 3 && missing.into_iter().filter(|other| in_sight(*other)).count() >= 2
    };
    lattice.keys().copied().filter(hangs).collect()
}
