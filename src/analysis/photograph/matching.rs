//! Which corner of one half is which of the other: a quarter turn and a shift by whole squares between their lattices.

use super::offsets::{Offset, bright_main_at_even, offsets};
use super::sighting::Sighting;
use crate::analysis::board_indexing::turned;
use crate::analysis::not_judged_cause::NotJudged;
use glam::{DVec2, IVec2};

/// A shift may be this far from a whole one, in squares, where the colours of the squares are not known.
pub(super) const MOST_DOUBT: f64 = 0.3;
/// The same where they are, and shifts of like colours are two squares apart: the sum over both axes.
const MOST_DOUBT_OF_COLOURS: f64 = 0.6;

/// What told a shift between the halves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatchedBy {
    /// Both halves show all of the board's columns, or rows.
    WholeBoard,
    /// The plane that the corners of one half fix, by the size of their squares, and the rays of the other half.
    Rays,
    /// The pose that the scene states.
    StatedPose,
}

/// How the lattice of one half becomes that of the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfMatch {
    /// The quarter turn, by where it takes (1, 0).
    pub turn: IVec2,
    /// The shift after it, in squares.
    pub shift: IVec2,
    /// What told the shift in columns and in rows.
    pub by: [MatchedBy; 2],
    /// How far it is from what the rays, or the stated pose, say, in squares along the worse axis; 0 where these say nothing.
    pub doubt: f64,
}

impl HalfMatch {
    /// The index in the lattice of the reference half.
    pub fn index(&self, index: IVec2) -> IVec2 {
        turned(self.turn, index) + self.shift
    }

    /// Whether the match holds whatever prism, camera and pose the scene states.
    pub fn is_sure(&self) -> bool {
        self.by == [MatchedBy::WholeBoard; 2]
    }
}

/// Columns and rows over which a lattice reaches.
pub(super) fn span(corners: impl Iterator<Item = IVec2> + Clone) -> IVec2 {
    let low = corners.clone().fold(IVec2::MAX, IVec2::min);
    let high = corners.fold(IVec2::MIN, IVec2::max);
    if low.cmple(high).all() { high - low + 1 } else { IVec2::ZERO }
}

/// Matches the lattice `other` to `reference`. `inner` counts the board's inner corners; `foretold` has the indices of corners
/// of `other` with their places in the lattice of the reference, in squares, as `by` says.
///
/// # Errors
/// [`NotJudged::NotMatched`] where no whole shift is near to what is foretold.
pub(super) fn match_halves(
    [reference, other]: [&[Sighting]; 2],
    inner: [usize; 2],
    foretold: &[(IVec2, DVec2)],
    by: MatchedBy,
) -> Result<HalfMatch, NotJudged> {
    let offset = offsets(foretold).into_iter().next();
    let turn = offset.map_or(IVec2::X, |offset| offset.turn);
    let whole = if turn == IVec2::X { whole_axes(reference, other, inner) } else { [false; 2] };
    let colours = |corners: &[Sighting], turn| bright_main_at_even(corners.iter().map(|s| (s.index, s.polarity)), turn);
    let odd = colours(reference, IVec2::X).zip(colours(other, turn)).map(|(a, b)| a != b);
    // Where a whole board contradicts the colours, one half shows other columns than the other.
    let found = [whole, [false; 2]].into_iter().find_map(|whole| nearest(offset, whole, odd));
    let doubt = found.map(|(_, _, doubt)| doubt);
    let most = if odd.is_some() { MOST_DOUBT_OF_COLOURS } else { MOST_DOUBT };
    match found {
        Some((shift, whole, doubt)) if doubt <= most => {
            let by = whole.map(|whole| if whole { MatchedBy::WholeBoard } else { by });
            let gap = offset.map_or(DVec2::ZERO, |offset| (shift.as_dvec2() - offset.median).abs());
            Ok(HalfMatch { turn, shift, by, doubt: gap.max_element() })
        }
        _ => Err(NotJudged::NotMatched(doubt)),
    }
}

/// In which axes both lattices reach over all of the board's corners, so that they begin at the same one.
fn whole_axes(reference: &[Sighting], other: &[Sighting], inner: [usize; 2]) -> [bool; 2] {
    let [a, b] = [reference, other].map(|half| span(half.iter().map(|s| s.index)).to_array());
    let upright = inner.map(|n| i32::try_from(n).unwrap_or(i32::MAX));
    // A board that stands on its side has its rows along x.
    let fits = |inner: [i32; 2]| (0..2).all(|k| a[k] <= inner[k] && b[k] <= inner[k]);
    let [fits_upright, fits_turned] = [fits(upright), fits([upright[1], upright[0]])];
    [0, 1].map(|k| {
        let whole = |count: i32| a[k] == count && b[k] == count;
        match (fits_upright, fits_turned) {
            (true, false) => whole(upright[k]),
            (false, true) => whole(upright[1 - k]),
            (true, true) => whole(upright[0].max(upright[1])) || (upright[0] == upright[1] && whole(upright[0])),
            (false, false) => false,
        }
    })
}

/// The whole shift nearest to an offset that is 0 in the axes that show the whole board, whose parity is `odd`, and its doubt.
fn nearest(offset: Option<Offset>, whole: [bool; 2], odd: Option<bool>) -> Option<(IVec2, [bool; 2], f64)> {
    let candidates = |k: usize| match (whole[k], offset) {
        (true, _) => vec![0],
        (false, Some(offset)) => {
            let below = offset.median[k].floor() as i32;
            (below - 1..=below + 2).collect()
        }
        (false, None) => Vec::new(),
    };
    let (columns, rows) = (candidates(0), candidates(1));
    let shifts = rows.iter().flat_map(|y| columns.iter().map(move |x| IVec2::new(*x, *y)));
    let away = |shift: IVec2| {
        let gap = offset.map_or(DVec2::ZERO, |offset| (shift.as_dvec2() - offset.median).abs());
        let gap = DVec2::new(if whole[0] { 0.0 } else { gap.x }, if whole[1] { 0.0 } else { gap.y });
        if odd.is_some() { gap.x + gap.y } else { gap.max_element() }
    };
    shifts
        .filter(|shift| odd.is_none_or(|odd| ((shift.x + shift.y).rem_euclid(2) == 1) == odd))
        .map(|shift| (shift, whole, away(shift)))
        .min_by(|a, b| a.2.total_cmp(&b.2))
}
