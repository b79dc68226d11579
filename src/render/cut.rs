//! A square part of a pixel that the ridge or the border of a fate passes through: cut along the straight line through the
//! places where its outline changes its passage.

use super::passage::Passage;
use super::piece::Piece;
use super::plan::Plan;
use super::work::Work;
use crate::system::Side;
use glam::DVec2;

/// The place where the ridge crosses a square's side is known to this share of the side: 2^-40.
const BORDER_SHARE: f64 = 1.0 / (1u64 << 40) as f64;
/// The place where light ends is sought by halving, to this share of the bend allowed: the area that it moves is less than
/// that.
pub(super) const BEND_SHARE: f64 = 1.0 / 16.0;
/// Steps of the secant method to the ridge; it is nearly straight, and 3 to 4 are enough.
const SECANTS: usize = 6;

/// The sides of a square along which its passage changes, each by the corner where it begins.
pub(super) fn changes(passages: &[Passage; 4]) -> Vec<usize> {
    (0..4).filter(|&k| passages[k] != passages[(k + 1) % 4]).collect()
}

/// The two pieces of the square with these corners (about `px`) and passages, which change along two of its sides.
pub(super) fn pieces(
    plan: &Plan,
    px: DVec2,
    corners: &[DVec2; 4],
    passages: &[Passage; 4],
    [first, second]: [usize; 2],
    work: &mut Work,
) -> [Piece; 2] {
    let mut cuts = |k: usize| {
        let next = (k + 1) % 4;
        let (ends, beyond) = border(plan, px, [corners[k], corners[next]], [passages[k], passages[next]], work);
        // A third passage may lie between, such as a ground ridge between the sides: it is in neither piece, and dark.
        let swapped = ([corners[next], corners[k]], [passages[next], passages[k]]);
        let begins = if beyond == passages[next] { ends } else { border(plan, px, swapped.0, swapped.1, work).0 };
        (ends, begins)
    };
    let ((end_a, begin_a), (end_b, begin_b)) = (cuts(first), cuts(second));
    let piece = |from: usize, to: usize, start: DVec2, end: DVec2| {
        let mut outline = vec![start];
        outline.extend((from + 1..=to).map(|k| corners[k % 4]));
        outline.push(end);
        Piece { outline, passage: passages[to % 4] }
    };
    [piece(first, second, begin_a, end_b), piece(second, first + 4, begin_b, end_a)]
}

/// Whether nothing lies between two pieces.
pub(super) fn are_adjacent(pieces: &[Piece; 2]) -> bool {
    let [[a_from, a_to], [b_from, b_to]] = pieces.each_ref().map(Piece::border);
    a_from == b_to && a_to == b_from
}

/// The place between two corners of these passages where the first ends, and the passage beyond.
fn border(plan: &Plan, px: DVec2, [a, b]: [DVec2; 2], [from, to]: [Passage; 2], work: &mut Work) -> (DVec2, Passage) {
    let at = |share: f64| px + a + (b - a) * share;
    let offset_mm = |share: f64| {
        work.counts.rays += 1;
        plan.system.front_x_mm(at(share), Side::Right)
    };
    let between_sides = from.class != to.class && [from, to].iter().all(|passage| passage.class.side().is_some());
    let on_ridge = if between_sides { ridge(offset_mm) } else { None };
    let enough = if between_sides { BORDER_SHARE } else { plan.system.accuracy().bend_px * BEND_SHARE / a.distance(b) };
    let mut narrowed = (0.0, 1.0);
    let mut beyond = to;
    let mut ask = |(near, far): (f64, f64), share: f64| {
        if share <= near || share >= far {
            return (near, far);
        }
        let passage = Passage::at(plan, at(share), work);
        if passage == from {
            return (share, far);
        }
        beyond = passage;
        (near, share)
    };
    if let Some(share) = on_ridge {
        narrowed = ask(narrowed, share - 0.5 * BORDER_SHARE);
        narrowed = ask(narrowed, share + 0.5 * BORDER_SHARE);
    }
    // Of the ridge this is done already, but where rounding hides on which side of it a ray passes.
    while narrowed.1 - narrowed.0 > enough {
        narrowed = ask(narrowed, 0.5 * (narrowed.0 + narrowed.1));
    }
    (a + (b - a) * (0.5 * (narrowed.0 + narrowed.1)), beyond)
}

/// Where the secant method, from the ends of 0..1 on, finds `offset_mm` to be 0; `None` where it is not known somewhere.
fn ridge(mut offset_mm: impl FnMut(f64) -> Option<f64>) -> Option<f64> {
    let (mut before, mut here) = ((0.0, offset_mm(0.0)?), (1.0, offset_mm(1.0)?));
    for _ in 0..SECANTS {
        let share: f64 = here.0 - here.1 * (here.0 - before.0) / (here.1 - before.1);
        if !share.is_finite() || (share - here.0).abs() < 0.25 * BORDER_SHARE {
            break;
        }
        (before, here) = (here, (share, offset_mm(share)?));
    }
    Some(here.0)
}
