//! Corners that make a kink in a lattice line before anything is fitted closely: a crossing behind the board's rim that growth took
//! for one of the board's.

use super::detection::{Reason, Rejected};
use super::lattice_lines::Grid;
use glam::{DVec2, IVec2};

/// A second difference along a line may differ from its neighbours' by this many px or this share of a step.
const MOST_KINK: (f64, f64) = (0.6, 0.12);
/// A corner off by so much shows at others of its line, and of the lines beside it, so many steps away.
const AROUND: i32 = 2;
/// How often what is left is looked at again.
const ROUNDS: usize = 8;

/// Drops corners that make a kink in a line: the second difference there is unlike that of the corners beside it. Of those near each
/// other the worst goes first, since it makes kinks of its neighbours too.
pub(super) fn prune_kinks(grid: &mut Grid, rejected: &mut Vec<Rejected>) {
    for _ in 0..ROUNDS {
        let cells = grid.lattice().keys().map(|&cell| (cell, kink(grid, IVec2::from_array(cell))));
        let kinked: Vec<([i32; 2], f64)> = cells.filter(|(_, kink)| *kink > 1.0).collect();
        let near = |a: [i32; 2], b: [i32; 2]| (0..2).all(|k| (a[k] - b[k]).abs() <= AROUND);
        let is_worst =
            |&&(cell, own): &&([i32; 2], f64)| kinked.iter().all(|(other, kink)| !near(cell, *other) || *kink <= own);
        let worst: Vec<[i32; 2]> = kinked.iter().filter(is_worst).map(|(cell, _)| *cell).collect();
        for cell in &worst {
            if let Some(k) = grid.remove(*cell) {
                rejected.push(Rejected { position_px: grid.positions[k], reason: Reason::OffLattice });
            }
        }
        if worst.is_empty() {
            return;
        }
    }
}

/// The kink at a cell, as a share of what may be.
fn kink(grid: &Grid, cell: IVec2) -> f64 {
    // Take second differences along lines.
    let second = |cell: IVec2, direction: IVec2| {
        Some(grid.at(cell - direction)? + grid.at(cell + direction)? - 2.0 * grid.at(cell)?)
    };

    // Compare each with those of the parallel lines beside it.
    let along = |direction: IVec2| {
        let own = second(cell, direction)?;
        let asides = [direction.perp(), -direction.perp()];
        let beside: Vec<DVec2> = asides.into_iter().filter_map(|aside| second(cell + aside, direction)).collect();
        let expected = beside.iter().sum::<DVec2>() / beside.len() as f64;
        let step = grid.step(cell, direction).map_or(0.0, DVec2::length);
        // A kink of one corner by e shows as 2 e here and as e at its neighbours.
        Some((own - expected).length() / (2.0 * MOST_KINK.0.max(MOST_KINK.1 * step)))
    };
    // Without lines beside it there is nothing to compare with, and the share is no number.
    [IVec2::X, IVec2::Y].into_iter().filter_map(along).filter(|kink| kink.is_finite()).fold(0.0, f64::max)
}
