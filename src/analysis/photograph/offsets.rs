//! By what turn and shift one numbering of corners becomes another.

use crate::analysis::board_indexing::turned;
use crate::num::stats::quantile;
use crate::vision::Polarity;
use glam::{DVec2, IVec2};

/// The four quarter turns, each by where it takes (1, 0).
pub(super) const TURNS: [IVec2; 4] = [IVec2::new(1, 0), IVec2::new(0, 1), IVec2::new(-1, 0), IVec2::new(0, -1)];

/// The shift that is left after a quarter turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Offset {
    pub(super) turn: IVec2,
    /// The median shift, in squares.
    pub(super) median: DVec2,
    /// How far the shifts reach about it (the larger half-distance between quartiles), in squares.
    pub(super) spread: f64,
}

/// The shift under each quarter turn from indices to the places where they are, in squares, the most uniform one first; empty
/// without corners.
pub(super) fn offsets(pairs: &[(IVec2, DVec2)]) -> Vec<Offset> {
    let of_turn = |turn: IVec2| {
        let axis = |k: usize| {
            let shifts: Vec<f64> = pairs.iter().map(|(i, at)| at[k] - f64::from(turned(turn, *i)[k])).collect();
            let quartile = |q: f64| quantile(&shifts, q);
            Some((quartile(0.5)?, 0.5 * (quartile(0.75)? - quartile(0.25)?)))
        };
        let ((x, wide), (y, high)) = (axis(0)?, axis(1)?);
        Some(Offset { turn, median: DVec2::new(x, y), spread: wide.max(high) })
    };
    let mut all: Vec<Offset> = TURNS.into_iter().filter_map(of_turn).collect();
    all.sort_by(|a, b| a.spread.total_cmp(&b.spread));
    all
}

/// Whether a quarter turn takes columns to rows, and with them each bright diagonal to the other.
fn is_odd(turn: IVec2) -> bool {
    turn.x == 0
}

/// Of a lattice whose corners become `index` under `turn` and any even shift: whether the main diagonal is bright where
/// column + row is even, as most of the corners say that say anything.
pub(super) fn bright_main_at_even(
    corners: impl Iterator<Item = (IVec2, Option<Polarity>)>,
    turn: IVec2,
) -> Option<bool> {
    let (mut yes, mut all) = (0, 0);
    for (index, polarity) in corners {
        let Some(polarity) = polarity else { continue };
        let index = turned(turn, index);
        let even = (index.x + index.y).rem_euclid(2) == 0;
        let main = (polarity == Polarity::Main) ^ is_odd(turn);
        yes += usize::from(main == even);
        all += 1;
    }
    (all > 0).then_some(2 * yes > all)
}
