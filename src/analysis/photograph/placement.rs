//! Which corners of the board a lattice shows: a quarter turn and a shift by whole squares that keep it on the board.

use super::offsets::{TURNS, bright_main_at_even, offsets};
use crate::analysis::board_indexing::turned;
use crate::scene::BoardSpec;
use crate::vision::Polarity;
use glam::{DVec2, IVec2};

/// What told which corners of the board are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlacedBy {
    /// No other place has the board's size and colours.
    OnlyPlace,
    /// Of the places that have, the one nearest to the stated pose.
    NearestToStated,
    /// No place has the board's colours: the top left square is not the black one.
    AgainstColours,
    /// The lattice has more corners than the board: they are counted from its own first one.
    LargerThanBoard,
}

/// From a lattice to the board's columns and rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LatticePlace {
    pub(super) turn: IVec2,
    pub(super) shift: IVec2,
    pub(super) by: PlacedBy,
}

impl LatticePlace {
    pub(super) fn index(&self, lattice: IVec2) -> IVec2 {
        turned(self.turn, lattice) + self.shift
    }
}

/// A corner of the lattice and which diagonal is bright.
pub(super) type Coloured = (IVec2, Option<Polarity>);

/// The place of `lattice` on `board`; `stated` has corners of it with their places in the board's columns and rows as the stated
/// pose has them.
pub(super) fn place(board: &BoardSpec, lattice: &[Coloured], stated: &[(IVec2, DVec2)]) -> LatticePlace {
    for by in [PlacedBy::OnlyPlace, PlacedBy::AgainstColours] {
        let places: Vec<(IVec2, [IVec2; 2])> =
            TURNS.into_iter().filter_map(|turn| Some((turn, shifts(board, lattice, turn)?))).collect();
        let allowed = |turn: IVec2, shift: IVec2| by == PlacedBy::AgainstColours || agrees(board, lattice, turn, shift);
        // Of one turn every second place along a row has the colours.
        let count = |(turn, range): &(IVec2, [IVec2; 2])| {
            between(*range).filter(|shift| allowed(*turn, *shift)).take(2).count()
        };
        let number: usize = places.iter().map(count).sum();
        let order = offsets(stated);
        let wanted = |turn: IVec2, range: [IVec2; 2]| {
            let middle = (range[0] + range[1]).as_dvec2() * 0.5;
            order.iter().find(|offset| offset.turn == turn).map_or(middle, |offset| offset.median)
        };
        // The turn that suits the stated pose best, or upright, comes first.
        let rank = |turn: IVec2| order.iter().position(|offset| offset.turn == turn).unwrap_or(0);
        let mut ranked = places;
        ranked.sort_by_key(|(turn, _)| rank(*turn));
        let found = ranked.iter().find_map(|(turn, range)| {
            let shift = nearest(*range, wanted(*turn, *range), |shift| allowed(*turn, shift))?;
            Some((*turn, shift))
        });
        if let Some((turn, shift)) = found {
            let by = if by == PlacedBy::OnlyPlace && number > 1 { PlacedBy::NearestToStated } else { by };
            return LatticePlace { turn, shift, by };
        }
    }
    let first = lattice.iter().map(|(index, _)| *index).fold(IVec2::MAX, IVec2::min);
    LatticePlace { turn: IVec2::X, shift: -first, by: PlacedBy::LargerThanBoard }
}

/// The shifts that keep the turned lattice on the board, lowest and highest; `None` where there are none.
fn shifts(board: &BoardSpec, lattice: &[Coloured], turn: IVec2) -> Option<[IVec2; 2]> {
    let (mut low, mut high) = (IVec2::MAX, IVec2::MIN);
    for (index, _) in lattice {
        let index = turned(turn, *index);
        (low, high) = (low.min(index), high.max(index));
    }
    let last = |squares: usize| i32::try_from(squares).unwrap_or(i32::MAX) - 2;
    let most = IVec2::new(last(board.columns), last(board.rows)).checked_sub(high)?;
    (!lattice.is_empty() && (-low).cmple(most).all()).then_some([-low, most])
}

fn between([low, high]: [IVec2; 2]) -> impl Iterator<Item = IVec2> {
    (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| IVec2::new(x, y)))
}

/// The allowed shift nearest to `wanted`: beside the nearest of all, where the colours leave every second one.
fn nearest(range: [IVec2; 2], wanted: DVec2, allowed: impl Fn(IVec2) -> bool) -> Option<IVec2> {
    let kept = wanted.round().as_ivec2().clamp(range[0], range[1]);
    let around = [(kept - 1).max(range[0]), (kept + 1).min(range[1])];
    let away = |shift: &IVec2| shift.as_dvec2().distance_squared(wanted);
    between(around).filter(|shift| allowed(*shift)).min_by(|a, b| away(a).total_cmp(&away(b)))
}

/// Whether the colours that the detector saw are those of the board: its top left square is black.
fn agrees(board: &BoardSpec, lattice: &[Coloured], turn: IVec2, shift: IVec2) -> bool {
    let Some(bright_main) = bright_main_at_even(lattice.iter().copied(), turn) else { return true };
    let shifted = bright_main ^ ((shift.x + shift.y).rem_euclid(2) == 1);
    // The square below and right of corner (0, 0) is black as that above and left of it is.
    shifted == (board.black > board.white)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose;

    fn board(columns: usize, rows: usize) -> BoardSpec {
        BoardSpec {
            columns,
            rows,
            square_mm: 1.0,
            margin_mm: 0.0,
            world_from_board: Pose::IDENTITY,
            black: 0.0,
            white: 1.0,
            background: 0.5,
        }
    }

    /// Corners of a board from `first` on, `size` of them, in the numbering of a lattice from 0, with the colours that a board
    /// has whose top left square is black, or white.
    fn seen(first: IVec2, size: IVec2, black_first: bool) -> Vec<Coloured> {
        let corner = |x: i32, y: i32| {
            let even = (first.x + x + first.y + y) % 2 == 0;
            (IVec2::new(x, y), Some(if even == black_first { Polarity::Anti } else { Polarity::Main }))
        };
        (0..size.y).flat_map(|y| (0..size.x).map(move |x| corner(x, y))).collect()
    }

    /// Places of corners as a pose has them that is off by `off` squares.
    fn stated(first: IVec2, size: IVec2, off: DVec2) -> Vec<(IVec2, DVec2)> {
        seen(first, size, true).into_iter().map(|(index, _)| (index, (index + first).as_dvec2() + off)).collect()
    }

    #[test]
    fn a_lattice_is_placed_where_it_fits() {
        // Of 5 x 4 inner corners the turned board has the other colours.
        let whole = IVec2::new(5, 4);
        let placed = place(&board(6, 5), &seen(IVec2::ZERO, whole, true), &[]);
        assert_eq!(placed, LatticePlace { turn: IVec2::X, shift: IVec2::ZERO, by: PlacedBy::OnlyPlace });
        let placed = place(&board(6, 5), &seen(IVec2::ZERO, whole, false), &[]);
        assert_eq!(placed, LatticePlace { turn: IVec2::NEG_X, shift: whole - 1, by: PlacedBy::OnlyPlace });
        // Of 5 x 3 the colours are the same, and no turn mends wrong ones.
        let stated_upright = stated(IVec2::ZERO, IVec2::new(5, 3), DVec2::ZERO);
        let placed = place(&board(6, 4), &seen(IVec2::ZERO, IVec2::new(5, 3), false), &stated_upright);
        assert_eq!(placed, LatticePlace { turn: IVec2::X, shift: IVec2::ZERO, by: PlacedBy::AgainstColours });
        let placed = place(&board(6, 5), &seen(IVec2::ZERO, IVec2::new(6, 4), true), &[]);
        assert_eq!((placed.shift, placed.by), (IVec2::ZERO, PlacedBy::LargerThanBoard));
    }

    /// A part of a board is placed by the stated pose, as far as its colours let it.
    #[test]
    fn a_part_is_placed_near_to_the_stated_pose() {
        let (first, size) = (IVec2::new(4, 3), IVec2::new(3, 3));
        for (off, moved) in [
            (DVec2::ZERO, IVec2::ZERO),
            (DVec2::new(0.6, -0.3), IVec2::ZERO),
            (DVec2::new(0.7, 0.6), IVec2::ONE),
            // Two squares off, it is taken for another part; beyond the rim it stays on the board.
            (DVec2::new(-2.1, 0.1), IVec2::new(-2, 0)),
            (DVec2::new(90.0, 0.0), IVec2::new(4, 0)),
        ] {
            let placed = place(&board(12, 12), &seen(first, size, true), &stated(first, size, off));
            assert_eq!((placed.turn, placed.by), (IVec2::X, PlacedBy::NearestToStated), "{off}");
            assert_eq!(placed.index(IVec2::new(2, 1)), first + IVec2::new(2, 1) + moved, "{off}");
        }
    }
}
