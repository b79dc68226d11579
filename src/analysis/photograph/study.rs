//! The study of a photograph: from its lattices to a view that figures are taken from, and the pose of its board.

use super::joint::{JointLattice, board_pose, join, stated_places};
use super::matching::{HalfMatch, span};
use super::offsets::offsets;
use super::placement::{Coloured, LatticePlace, PlacedBy, place};
use super::pose_fit::{SeenPoint, residuals_px};
use super::sighting::Sighting;
use crate::analysis::board_indexing::Found;
use crate::analysis::half_image::HalfFrame;
use crate::analysis::judge::{Judgement, measure};
use crate::analysis::view::{BoardPlace, BoardView, DetectedLattice};
use crate::geom::Pose;
use crate::metrics::Deviation;
use crate::num::lsq::Failure;
use crate::progress::Observer;
use crate::scene::{self, BoardSpec, Scene};
use crate::system::{Board, InLight, System};
use crate::vision::half::Half;
use glam::IVec2;

/// A stated pose is kept while its residuals are below this, in px: that much a detector makes of noise.
const HOLDS_PX: f64 = 0.1;
/// Or while they are at most this many times those of the fitted pose: then what they come from is not the pose for the most
/// part.
const HOLDS_TIMES: f64 = 2.0;
/// A stated pose that nothing can be fitted against must have its corners to this share of a square.
const SAME_CORNER: f64 = 0.3;

/// Where the pose of the board comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PoseSource {
    /// The scene states it, and the corners agree.
    Stated,
    /// Fitted, as the scene asks.
    Asked,
    /// Fitted, because the stated one does not match the corners.
    Mismatch,
    /// Not known: the fit failed, and the stated pose does not match the corners.
    Unknown(Failure),
}

/// The stated pose against the corners, and against the fitted one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedPose {
    /// Residuals of the corners, in px; `None` where a ray does not meet the stated plane.
    pub deviation: Option<Deviation>,
    /// From its place to the fitted one, in mm.
    pub off_mm: f64,
    /// The angle between the two, in rad.
    pub off_rad: f64,
}

/// What was found of the board's pose.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundPose {
    /// Where it comes from.
    pub source: PoseSource,
    /// The board's frame in the world.
    pub world_from_board: Pose,
    /// Residuals of the corners under it, found minus explained, in px; `None` where it is not known.
    pub deviation: Option<Deviation>,
    /// The stated one, where one was fitted.
    pub stated: Option<StatedPose>,
    /// Another pose that the corners do not tell from the fitted one: tilted the other way.
    pub other: Option<Pose>,
    /// How the halves are matched; `None` where they are not.
    pub matched: Option<HalfMatch>,
    /// What told which corners of the board are seen.
    pub placed: PlacedBy,
    /// Corners of both halves whose rays were asked.
    pub corners: usize,
    /// Columns and rows over which they reach.
    pub seen: [usize; 2],
}

/// A photograph, ready for figures.
#[derive(Debug, Clone)]
pub struct Photograph {
    /// The scene, its board where the picture has it.
    pub scene: Scene,
    /// Its instrument.
    pub system: System,
    /// Its corners, matched and placed.
    pub view: BoardView,
    /// What was found of the board's pose; `None` without corners.
    pub pose: Option<FoundPose>,
}

impl Photograph {
    /// The figures of the picture, and what was found of its board.
    pub fn judged(self) -> (Judgement, Option<FoundPose>) {
        (measure(&self.scene, &self.system, self.view, &[]), self.pose)
    }
}

/// Matches the corners of both halves of a picture by their lattices, and gives them their places on the board and the board
/// its place: the one that the scene states, where the corners agree with it, or else the one that explains them best.
pub fn photograph(
    scene: &Scene,
    system: &System,
    lattices: &[DetectedLattice; 2],
    observer: &dyn Observer,
) -> Photograph {
    observer.stage("pose");
    let light = InLight::new(system);
    let sightings = [(Half::Left, &lattices[0]), (Half::Right, &lattices[1])].map(|(half, lattice)| {
        let frame = HalfFrame::new(system, half);
        lattice.corners.iter().filter_map(|seen| Sighting::of(&light, &frame, seen)).collect::<Vec<_>>()
    });
    let board = system.board();
    let Some(joint) = join(board, &sightings) else {
        let known = scene.board_pose == scene::BoardPose::Stated;
        let place = if known { BoardPlace::Given } else { BoardPlace::Unknown };
        let view = BoardView::of_photograph(system, lattices, [Vec::new(), Vec::new()], place);
        return Photograph { scene: scene.clone(), system: system.clone(), view, pose: None };
    };
    let coloured: Vec<Coloured> = joint.corners.iter().map(|(index, s)| (*index, s.polarity)).collect();
    let stated = stated_places(board, joint.corners.iter().copied());
    let placement = place(&board.pattern, &coloured, &stated);
    let pose = found_pose(scene, board, &joint, &placement);
    let known = match pose.source {
        PoseSource::Stated => BoardPlace::Given,
        PoseSource::Asked | PoseSource::Mismatch => BoardPlace::Fitted,
        PoseSource::Unknown(_) => BoardPlace::Unknown,
    };
    let spec = BoardSpec { world_from_board: pose.world_from_board, ..scene.board };
    let (scene, system) = match known {
        BoardPlace::Fitted => (Scene { board: spec, ..scene.clone() }, system.with_board(&spec)),
        BoardPlace::Given | BoardPlace::Unknown => (scene.clone(), system.clone()),
    };
    let found = [0, 1].map(|k| placed(&lattices[k], k, &joint, &placement));
    let mut view = BoardView::of_photograph(&system, lattices, found, known);
    view.unmatched = joint.matched.and_then(Result::err);
    Photograph { scene, system, view, pose: Some(pose) }
}

/// The corners of half `k` on the board; none where it is not matched to the other one.
fn placed(lattice: &DetectedLattice, k: usize, joint: &JointLattice<'_>, placement: &LatticePlace) -> Vec<Found> {
    let in_joint = |index: IVec2| match &joint.matched {
        _ if k == joint.reference => Some(index),
        Some(Ok(matched)) => Some(matched.index(index)),
        Some(Err(_)) | None => None,
    };
    let place = |seen: &crate::vision::LatticeCorner| {
        let index = placement.index(in_joint(IVec2::from_array(seen.index))?).to_array();
        Some(Found::at(index, seen))
    };
    lattice.corners.iter().filter_map(place).collect()
}

fn found_pose(scene: &Scene, board: &Board, joint: &JointLattice<'_>, placement: &LatticePlace) -> FoundPose {
    let spec = &board.pattern;
    let on_board = |index: IVec2| {
        let index = placement.index(index).as_dvec2();
        board.corner_at(index.x, index.y)
    };
    let points: Vec<SeenPoint<'_>> = joint.corners.iter().map(|(index, s)| (on_board(*index), *s)).collect();
    let told = spec.world_from_board;
    let deviation = residuals_px(spec, &told, &points).and_then(|residuals| Deviation::of(&residuals).ok());
    let matched = joint.matched.as_ref().and_then(|matched| matched.as_ref().ok()).copied();
    let of = |source, world_from_board, deviation| FoundPose {
        source,
        world_from_board,
        deviation,
        stated: None,
        other: None,
        matched,
        placed: placement.by,
        corners: joint.corners.len(),
        seen: span(joint.corners.iter().map(|(index, _)| *index)).to_array().map(|n| n.max(0) as usize),
    };
    match &joint.plane {
        Ok(plane) => {
            let fitted = board_pose(board, &plane.pose, placement.turn, placement.shift);
            let source = match (scene.board_pose, deviation) {
                (scene::BoardPose::Fit, _) => PoseSource::Asked,
                (_, Some(d)) if d.rms <= HOLDS_PX.max(HOLDS_TIMES * plane.deviation.rms) => PoseSource::Stated,
                _ => PoseSource::Mismatch,
            };
            if source == PoseSource::Stated {
                return of(source, told, deviation);
            }
            let turn = fitted.rotation * told.rotation.transpose();
            let cosine = 0.5 * (turn.x_axis.x + turn.y_axis.y + turn.z_axis.z - 1.0);
            let stated = StatedPose {
                deviation,
                off_mm: fitted.translation_mm.distance(told.translation_mm),
                off_rad: libm::acos(cosine.clamp(-1.0, 1.0)),
            };
            let other = plane.other.map(|other| board_pose(board, &other, placement.turn, placement.shift));
            FoundPose { stated: Some(stated), other, ..of(source, fitted, Some(plane.deviation)) }
        }
        Err(_) if scene.board_pose == scene::BoardPose::Stated && agrees(board, joint, placement) => {
            of(PoseSource::Stated, told, deviation)
        }
        Err(failure) => of(PoseSource::Unknown(*failure), told, None),
    }
}

/// Whether the stated pose has the corners where the lattice was placed.
fn agrees(board: &Board, joint: &JointLattice<'_>, placement: &LatticePlace) -> bool {
    let offset = offsets(&stated_places(board, joint.corners.iter().copied())).into_iter().next();
    offset.is_some_and(|offset| {
        let gap = (offset.median - placement.shift.as_dvec2()).abs().max_element();
        offset.turn == placement.turn && gap < SAME_CORNER
    })
}
