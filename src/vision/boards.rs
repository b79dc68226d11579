//! Which of the lattices of a picture are boards, and which of them is answered.

use super::candidates::Candidates;
use super::detection::{Detection, Reason, Rejected};
use super::fit_all::{hanging_candidates, measure_lattice};
use super::lattice_growth::{Lattice, Lattices};
use super::settings::Settings;
use glam::DVec2;

/// A corner of one board is that of another within this, in px.
const SAME_PX: f64 = 1.0;

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
        None => Detection::none(outside(candidates, &lattices, others(None))),
        Some((number, found)) => {
            let mut rejected = outside(candidates, &lattices, others(Some(number)));
            rejected.extend(found.rejected);
            Detection { rejected, ..found }
        }
    }
}

/// A detection in the picture itself, or of a lattice that only coarser pictures show, where that has more corners.
pub(super) fn measure_coarser(
    candidates: &Candidates<'_>,
    lattices: &Lattices,
    found: Detection,
    settings: &Settings,
) -> Detection {
    let mut best: Option<(usize, Detection)> = None;
    // Most coarser lattices show the same board over again. What hangs on a lattice is turned down, and so is what was unlike the
    // corners around it before.
    let mut lost: Vec<DVec2> = turned_down(&found);
    for (number, lattice) in lattices.0.iter().enumerate() {
        let most = best.as_ref().map_or(&found, |(_, best)| best).corners.len();
        if most >= lattice.len() {
            break;
        }
        let coarse = lattice.values().any(|&k| k >= candidates.crossings());
        let is_lost = |at: DVec2| lost.iter().any(|other| other.distance(at) < SAME_PX);
        let hopeful = lattice.values().filter(|&&k| !is_lost(candidates.list[k].position)).count();
        if !coarse || hopeful <= most || hopeful <= most + hanging_candidates(candidates, lattice) {
            continue;
        }
        let other = measure_lattice(candidates, lattice, settings);
        lost.extend(turned_down(&other));
        if other.corners.len() > most {
            best = Some((number, other));
        }
    }
    let Some((answered, best)) = best else { return found };
    let others = lattices.0.iter().enumerate().filter(|(number, _)| *number != answered);
    let mut rejected = outside(candidates, lattices, others.flat_map(|(_, lattice)| lattice.values().copied()));
    rejected.extend(best.rejected);
    Detection { rejected, ..best }
}

/// Where the picture was found to be unlike two crossing edges, in px.
fn turned_down(found: &Detection) -> Vec<DVec2> {
    found.rejected.iter().filter(|r| r.reason == Reason::Residual).map(|r| r.position_px).collect()
}

/// Measures every board, that of most corners first. Candidates that belong to none are in the answer of the first, which is there
/// even where there is no board.
pub fn measure_all(candidates: &Candidates<'_>, lattices: &Lattices, settings: &Settings) -> Vec<Detection> {
    let mut measured: Vec<(usize, Detection)> =
        lattices.0.iter().map(|lattice| measure_lattice(candidates, lattice, settings)).enumerate().collect();
    // Stable: of equal boards the one found first stays first.
    measured.sort_by_key(|(_, board)| std::cmp::Reverse(board.corners.len()));

    // Leave out the lattices of other resolutions that show a board over again.
    let (mut found, mut again): (Vec<Detection>, Vec<usize>) = Default::default();
    for (number, board) in measured {
        if found.iter().any(|larger| shows(larger, &board)) {
            again.push(number);
        } else {
            found.push(board);
        }
    }
    let again = again.iter().flat_map(|&number| lattices.0[number].values().copied());
    let mut rejected = outside(candidates, lattices, again);
    let boards = found.iter().filter(|board| !board.corners.is_empty()).count().max(1);
    // What a lattice that is no board after all turned down is told with the first.
    let rest: Vec<Rejected> = found.drain(boards.min(found.len())..).flat_map(|lost| lost.rejected).collect();
    match found.first_mut() {
        None => found.push(Detection::none(rejected)),
        Some(first) => {
            rejected.append(&mut first.rejected);
            rejected.extend(rest);
            first.rejected = rejected;
        }
    }
    found
}

/// Whether a board has half of another's corners.
fn shows(larger: &Detection, board: &Detection) -> bool {
    let near = |at: DVec2| larger.corners.iter().any(|c| c.position_px.distance(at) < SAME_PX);
    let shared = board.corners.iter().filter(|corner| near(corner.position_px)).count();
    !board.corners.is_empty() && 2 * shared >= board.corners.len()
}

/// What was turned down before any lattice was measured: what is no crossing, crossings of no lattice, and those of `others`.
fn outside(candidates: &Candidates<'_>, lattices: &Lattices, others: impl Iterator<Item = usize>) -> Vec<Rejected> {
    let mut reasons = vec![Some(Reason::NoGrid); candidates.list.len()];
    lattices.0.iter().flat_map(Lattice::values).for_each(|&k| reasons[k] = None);
    others.for_each(|k| reasons[k] = Some(Reason::OtherGrid));
    // A crossing of a coarser picture is one of the picture itself, or nothing to tell of.
    let outside = candidates.list[..candidates.crossings()].iter().zip(reasons);
    let mut rejected = candidates.rejected.clone();
    rejected.extend(outside.filter_map(|(c, reason)| Some(Rejected { position_px: c.position, reason: reason? })));
    rejected
}
