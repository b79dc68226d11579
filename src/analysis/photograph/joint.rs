//! The lattices of both halves made one, with the plane on which it lies.

use super::matching::{HalfMatch, MOST_DOUBT, MatchedBy, match_halves};
use super::offsets::offsets;
use super::pose_fit::{FittedPlane, SeenPoint, fit, open_mm};
use super::pose_start::start;
use super::sighting::Sighting;
use crate::analysis::not_judged_cause::NotJudged;
use crate::geom::Pose;
use crate::num::lsq::Failure;
use crate::scene::BoardSpec;
use crate::system::Board;
use glam::{DMat3, DVec2, DVec3, IVec2};

/// Corners of the other half that are asked how surely they are foretold.
const ASKED: usize = 64;

/// The corners of both halves in one numbering.
pub(super) struct JointLattice<'a> {
    /// The half whose numbering it is.
    pub(super) reference: usize,
    /// How the other half's becomes it; `None` where that half shows no corner.
    pub(super) matched: Option<Result<HalfMatch, NotJudged>>,
    /// The corners: of the reference alone where the halves are not matched.
    pub(super) corners: Vec<(IVec2, &'a Sighting)>,
    /// The plane through them, in whose frame corner (i, j) lies at (i, j) squares.
    pub(super) plane: Result<FittedPlane, Failure>,
}

/// Joins the halves; `None` where neither shows a corner.
pub(super) fn join<'a>(board: &Board, halves: &'a [Vec<Sighting>; 2]) -> Option<JointLattice<'a>> {
    let spec = &board.pattern;
    let reference = usize::from(halves[1].len() > halves[0].len());
    let (own, other) = (&halves[reference], &halves[1 - reference]);
    if own.is_empty() {
        return None;
    }
    let point = |index: IVec2| index.as_dvec2() * spec.square_mm;
    let alone: Vec<SeenPoint<'_>> = own.iter().map(|s| (point(s.index), s)).collect();
    let first = start(&alone).or_else(|| stated_lattice(board, own));
    let fitted = first.map_or(Err(Failure::NoStart), |first| fit(spec, first, &alone));

    // Where the corners of the other half lie on the plane that these corners fix, or else on the stated one.
    let (plane, by) = match &fitted {
        Ok(plane) if tells(spec, plane, &alone, other) => (Some(plane.pose), MatchedBy::Rays),
        _ => (stated_lattice(board, own), MatchedBy::StatedPose),
    };
    let plane = plane.map(|pose| Board::new(&BoardSpec { world_from_board: pose, ..*spec }));
    let foretold = |s: &Sighting| Some((s.index, s.met_mm(plane.as_ref()?)? / spec.square_mm));
    let foretold: Vec<(IVec2, DVec2)> = other.iter().filter_map(foretold).collect();
    let matched = (!other.is_empty()).then(|| match_halves([own, other], board.inner_corners(), &foretold, by));

    let mut corners: Vec<(IVec2, &Sighting)> = own.iter().map(|s| (s.index, s)).collect();
    if let Some(Ok(matched)) = &matched {
        corners.extend(other.iter().map(|s| (matched.index(s.index), s)));
    }
    let points: Vec<SeenPoint<'_>> = corners.iter().map(|(index, s)| (point(*index), *s)).collect();
    let begin = fitted.as_ref().map(|plane| plane.pose).ok().or(first);
    let plane = begin.map_or(Err(Failure::NoStart), |begin| fit(spec, begin, &points));
    Some(JointLattice { reference, matched, corners, plane })
}

/// Whether a plane fixes where the corners of the other half lie on it: three standard deviations are less than the doubt that
/// a match may have.
fn tells(board: &BoardSpec, plane: &FittedPlane, points: &[SeenPoint<'_>], other: &[Sighting]) -> bool {
    let some: Vec<&Sighting> = other.iter().step_by(other.len().div_ceil(ASKED).max(1)).collect();
    some.is_empty() || open_mm(board, plane, points, &some).is_some_and(|mm| 3.0 * mm < MOST_DOUBT * board.square_mm)
}

/// The plane of a lattice as the stated pose has it; `None` where no ray meets it.
fn stated_lattice(board: &Board, corners: &[Sighting]) -> Option<Pose> {
    let offset = offsets(&stated_places(board, corners.iter().map(|s| (s.index, s)))).into_iter().next()?;
    Some(lattice_pose(board, &board.pattern.world_from_board, offset.turn, offset.median))
}

/// Corners with their places on the board as it is stated, in columns and rows, where their rays meet it.
pub(super) fn stated_places<'a>(
    board: &Board,
    corners: impl Iterator<Item = (IVec2, &'a Sighting)>,
) -> Vec<(IVec2, DVec2)> {
    let first = board.corner_at(0.0, 0.0);
    corners.filter_map(|(index, s)| Some((index, (s.met_mm(board)? - first) / board.pattern.square_mm))).collect()
}

/// The rotation in the plane that belongs to a quarter turn.
fn in_plane(turn: IVec2) -> DMat3 {
    let x = turn.as_dvec2();
    DMat3::from_cols(x.extend(0.0), x.perp().extend(0.0), DVec3::Z)
}

/// The pose of a lattice on a board at `pose`, whose corners are those of the board after a turn and a shift in squares.
fn lattice_pose(board: &Board, pose: &Pose, turn: IVec2, shift: DVec2) -> Pose {
    let first = board.corner_at(shift.x, shift.y).extend(0.0);
    Pose { rotation: pose.rotation * in_plane(turn), translation_mm: pose.point(first) }
}

/// The pose of the board whose corners are those of a lattice at `pose` after a turn and a shift in squares.
pub(super) fn board_pose(board: &Board, pose: &Pose, turn: IVec2, shift: IVec2) -> Pose {
    let rotation = pose.rotation * in_plane(turn).transpose();
    let first = board.corner_at(f64::from(shift.x), f64::from(shift.y)).extend(0.0);
    Pose { rotation, translation_mm: pose.translation_mm - rotation * first }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::board_indexing::turned;

    /// A corner has one place in the world, by its lattice and by the board.
    #[test]
    fn lattice_and_board_have_one_place() {
        let pose = Pose::new(DVec3::new(30.0, -20.0, 900.0), DVec3::new(0.2, -0.1, 0.3));
        let spec = BoardSpec {
            columns: 12,
            rows: 9,
            square_mm: 7.0,
            margin_mm: 1.0,
            world_from_board: pose,
            black: 0.0,
            white: 1.0,
            background: 0.5,
        };
        let board = Board::new(&spec);
        for turn in super::super::offsets::TURNS {
            let shift = IVec2::new(3, -2);
            let lattice = lattice_pose(&board, &pose, turn, shift.as_dvec2());
            let index = IVec2::new(4, 1);
            let on_board = turned(turn, index) + shift;
            let by_board = board.world(board.corner_at(f64::from(on_board.x), f64::from(on_board.y)));
            let by_lattice = lattice.point((index.as_dvec2() * spec.square_mm).extend(0.0));
            // Some ten roundings of numbers near 1000.
            assert!((by_board - by_lattice).length() < 1e-11, "{turn}");
            let back = board_pose(&board, &lattice, turn, shift);
            assert!((back.translation_mm - pose.translation_mm).length() < 1e-11, "{turn}");
            assert!((back.rotation - pose.rotation).abs_diff_eq(DMat3::ZERO, 1e-14), "{turn}");
        }
    }
}
