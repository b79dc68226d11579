//! Board indexing: which corner of the board is which corner of a detected lattice.
//!
//! A checkerboard that fills the view has no mark of its own, so a lattice found in a picture is known only up to a
//! shift and a quarter turn. The instrument settles both: its rays through the corners nearest to the half image's centre
//! meet the board near the corners that they are of, whatever its camera, its prism and its errors are. Whole numbers
//! only are taken from it, so that no measured position depends on the instrument.

use super::half_image::HalfFrame;
use crate::num::stats::quantile;
use crate::system::{InLight, System};
use crate::vision::{LatticeCorner, Polarity};
use glam::{DMat2, DVec2, IVec2};

/// A detected corner that knows its place on the board.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Column and row on the board.
    pub index: [i32; 2],
    /// Position, in px from the half's own origin.
    pub position_px: DVec2,
    /// Covariance of the position, in px^2, where the detector says.
    pub covariance_px2: Option<DMat2>,
}

impl Found {
    /// A corner of a lattice at the place `index` of the board.
    pub(super) fn at(index: [i32; 2], seen: &LatticeCorner) -> Self {
        Self { index, position_px: seen.position_px, covariance_px2: seen.covariance_px2 }
    }
}

/// Where the corners of a lattice lie on the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LatticePlacement {
    turn: IVec2,
    shift: IVec2,
}

impl LatticePlacement {
    /// Column and row on the board of a corner of the lattice.
    pub fn of(&self, index: [i32; 2]) -> [i32; 2] {
        (turned(self.turn, IVec2::from_array(index)) + self.shift).to_array()
    }

    /// Which diagonal is bright by the board's columns and rows, of a corner where it is this by the lattice's.
    pub fn polarity(&self, by_lattice: Polarity) -> Polarity {
        // A quarter turn swaps the diagonals.
        match by_lattice {
            Polarity::Main if self.turn.x == 0 => Polarity::Anti,
            Polarity::Anti if self.turn.x == 0 => Polarity::Main,
            same => same,
        }
    }
}

/// Corners nearest to the centre of the half that vote for the shift.
const VOTERS: usize = 9;
/// Votes may lie this far from a whole shift, in squares.
const MOST_DOUBT: f64 = 0.3;

/// Gives the corners of one half their places on the board; `None` as [`placement`].
pub fn anchor(light: &InLight<'_>, frame: &HalfFrame, corners: &[LatticeCorner]) -> Option<Vec<Found>> {
    let placement = placement(light, frame, corners)?;
    Some(corners.iter().map(|c| Found::at(placement.of(c.index), c)).collect())
}

/// Where the lattice of one half lies on the board; `None` when the instrument cannot tell, because its rays meet the board
/// between two corners or contradict the colours of the squares.
pub fn placement(light: &InLight<'_>, frame: &HalfFrame, corners: &[LatticeCorner]) -> Option<LatticePlacement> {
    let system = light.main();
    let centre = frame.own(frame.centre_px(system));
    let mut voters: Vec<&LatticeCorner> = corners.iter().collect();
    voters.sort_by(|a, b| {
        a.position_px
            .distance_squared(centre)
            .total_cmp(&b.position_px.distance_squared(centre))
            .then(a.index.cmp(&b.index))
    });
    voters.truncate(VOTERS);
    let votes: Vec<(IVec2, DVec2)> = voters
        .iter()
        .filter_map(|c| Some((IVec2::from_array(c.index), board_index(light, frame, c.position_px)?)))
        .collect();
    let turns = [IVec2::new(1, 0), IVec2::new(0, 1), IVec2::new(-1, 0), IVec2::new(0, -1)];
    let (turn, shift, doubt) = turns
        .into_iter()
        .filter_map(|turn| {
            let offsets: Vec<DVec2> =
                votes.iter().map(|(lattice, board)| board - turned(turn, *lattice).as_dvec2()).collect();
            let median = |axis: usize| quantile(&offsets.iter().map(|o| o[axis]).collect::<Vec<_>>(), 0.5);
            let shift = DVec2::new(median(0)?, median(1)?).round();
            let doubt = offsets.iter().fold(0.0, |d: f64, o| d.max((o - shift).abs().max_element()));
            Some((turn, shift.as_ivec2(), doubt))
        })
        .min_by(|a, b| a.2.total_cmp(&b.2))?;
    let placement = LatticePlacement { turn, shift };
    // A detector that does not tell the colours cannot contradict them.
    let told = corners.iter().filter_map(|c| Some(polarity(system, placement.of(c.index)) == c.polarity?));
    let (agree, all) = told.fold((0, 0), |(agree, all), same| (agree + usize::from(same), all + 1));
    let agreed = doubt < MOST_DOUBT && (all == 0 || 2 * agree > all);
    agreed.then_some(placement)
}

/// Which diagonal of the board's corner is bright when it is seen upright, as it is wherever columns run to the right
/// and rows down; the top left square of the board is black.
fn polarity(system: &System, [column, row]: [i32; 2]) -> Polarity {
    let dark_main = (column + row).rem_euclid(2) == 0;
    let inverted = system.board().pattern.black > system.board().pattern.white;
    // A quarter turn of the board swaps the diagonals.
    let x = system.board().vector(glam::DVec3::X);
    let turned = x.y.abs() > x.x.abs();
    if dark_main ^ inverted ^ turned { Polarity::Anti } else { Polarity::Main }
}

/// The lattice vector turned by the quarter turn that takes (1, 0) to `turn`.
pub(super) fn turned(turn: IVec2, v: IVec2) -> IVec2 {
    IVec2::new(turn.x * v.x - turn.y * v.y, turn.y * v.x + turn.x * v.y)
}

/// The board's (column, row), not rounded, that the half sees at `half_px` through its own side.
fn board_index(light: &InLight<'_>, frame: &HalfFrame, half_px: DVec2) -> Option<DVec2> {
    let board = light.main().board();
    let ray = light.exit_ray_through(frame.full(half_px), frame.side()).ok()?;
    let (board_mm, _) = board.intersect(&ray).ok()?;
    Some((board_mm - board.corner_at(0.0, 0.0)) / board.pattern.square_mm)
}
