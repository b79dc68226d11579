//! Which of the lattices of a picture are boards, and which of them is answered.

use super::candidates::Candidates;
use super::detection::{Detection, Reason, Rejected};
use super::fit_all::measure_lattice;
use super::lattice_growth::{Lattice, Lattices};
use super::settings::Settings;

/// Measures the corners of the largest board: the lattice of which most corners turn out to be some.
pub fn measure(candidates: &Candidates<'_>, lattices: Lattices, settings: &Settings) -> Detection {
    // Measure lattices, largest first, until no other can hold more.
    let mut best: Option<(usize, Detection)> = None;
    for (number, lattice) in lattices.0.iter().enumerate() {
        if best.as_ref().is_some_and(|(_, found)| found.corners.len() >= lattice.len()) {
            break;
        }
        let found = measure_lattice(candidates, lattice, settings);
        if best.as_ref().is_none_or(|(_, best)| found.corners.len() > best.corners.len()) {
            best = Some((number, found));
        }
    }

    // Turn down the candidates outside it.
    let others = |answered: Option<usize>| {
        let other = lattices.0.iter().enumerate().filter(move |(number, _)| Some(*number) != answered);
        other.flat_map(|(_, lattice)| lattice.values().copied())
    };
    match best {
        None => Detection {
            corners: Vec::new(),
            rejected: outside(candidates, &lattices, others(None)),
            sigma_px: None,
            lean_px: 0.0,
        },
        Some((number, found)) => {
            let mut rejected = outside(candidates, &lattices, others(Some(number)));
            rejected.extend(found.rejected);
            Detection { rejected, ..found }
        }
    }
}

/// Measures every board, that of most corners first. Candidates that belong to none are in the answer of the first, which is there
/// even where there is no board.
pub fn measure_all(candidates: &Candidates<'_>, lattices: &Lattices, settings: &Settings) -> Vec<Detection> {
    let mut found: Vec<Detection> =
        lattices.0.iter().map(|lattice| measure_lattice(candidates, lattice, settings)).collect();
    // Stable: of equal boards the one found first stays first.
    found.sort_by_key(|board| std::cmp::Reverse(board.corners.len()));
    let mut rejected = outside(candidates, lattices, std::iter::empty());
    let boards = found.iter().filter(|board| !board.corners.is_empty()).count().max(1);
    // What a lattice that is no board after all turned down is told with the first.
    let rest: Vec<Rejected> = found.drain(boards.min(found.len())..).flat_map(|lost| lost.rejected).collect();
    match found.first_mut() {
        None => found.push(Detection { corners: Vec::new(), rejected, sigma_px: None, lean_px: 0.0 }),
        Some(first) => {
            rejected.append(&mut first.rejected);
            rejected.extend(rest);
            first.rejected = rejected;
        }
    }
    found
}

/// What was turned down before any lattice was measured: what is no crossing, crossings of no lattice, and those of `others`.
fn outside(candidates: &Candidates<'_>, lattices: &Lattices, others: impl Iterator<Item = usize>) -> Vec<Rejected> {
    let mut reasons = vec![Some(Reason::NoGrid); candidates.list.len()];
    lattices.0.iter().flat_map(Lattice::values).for_each(|&k| reasons[k] = None);
    others.for_each(|k| reasons[k] = Some(Reason::OtherGrid));
    let outside = candidates.list.iter().zip(reasons);
    let mut rejected = candidates.rejected.clone();
    rejected.extend(outside.filter_map(|(c, reason)| Some(Rejected { position_px: c.position, reason: reason? })));
    rejected
}
