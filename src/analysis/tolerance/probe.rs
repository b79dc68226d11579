//! The probe: what an instrument with an error is judged by.

use super::made::made_of_surfaces;
use crate::analysis::half_image::{HalfFrame, virtual_camera};
use crate::analysis::relay::lens::{RelayLens, disc};
use crate::analysis::relay::pencil::Pencil;
use crate::analysis::relay::spot::{PencilSpot, best_focus_mm};
use crate::error::Error;
use crate::geom::Pose;
use crate::metrics::Observation;
use crate::metrics::pinhole::Pinhole;
use crate::metrics::reprojection::{POSE_AND_FOCAL, fit};
use crate::num::stats::rms;
use crate::scene::{BoardSpec, Scene};
use crate::system::aim::Aimer;
use crate::system::{self, Side, System};
use crate::vision::half::Half;
use glam::{DVec2, DVec3};

/// Points that are looked at, along x and y of the left half image.
const POINTS: [usize; 2] = [9, 7];

/// What is asked of an instrument with an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// Root mean square radius of the relay lens' spot, in um, focused where the right prism's is: see [`crate::analysis::relay`].
    Spot,
    /// The same, focused anew.
    BestSpot,
    /// Root mean square vertical disparity of points of the scene's board, as the halves are, in px.
    Vertical,
    /// Root mean square deviation of both halves from the pinhole that fits each best, over two distances, in px.
    Pinhole,
}

impl Criterion {
    /// All.
    pub const ALL: [Self; 4] = [Self::Spot, Self::BestSpot, Self::Vertical, Self::Pinhole];

    /// Its key, with the unit.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Spot => "spot_um",
            Self::BestSpot => "best_spot_um",
            Self::Vertical => "vertical_px",
            Self::Pinhole => "pinhole_px",
        }
    }

    /// The criterion of this key.
    pub fn named(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|criterion| criterion.key() == key)
    }
}

/// A plane with points that both halves see.
#[derive(Debug, Clone)]
struct ProbePlane {
    board: BoardSpec,
    /// On the board, in mm, and where the right instrument sees it in the left and in the right half, in px of the picture.
    points: Vec<(DVec2, [DVec2; 2])>,
}

/// What instruments with errors are judged by, made from the right one.
#[derive(Debug, Clone)]
pub struct Probe {
    /// The scene, its prism given by surfaces: what operands are put into.
    pub scene: Scene,
    lens: RelayLens,
    rings: usize,
    focus_mm: f64,
    planes: Vec<ProbePlane>,
    frames: [HalfFrame; 2],
    cameras: [Pinhole; 2],
}

/// Why an instrument has no figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NoFigure(pub String);

impl Probe {
    /// The probe of `scene`: points of its board seen in both halves and of a facing plane twice as far, and the relay `lens` with a pupil of
    /// `rings` rings, focused on the plane of O' or on `focus_mm`.
    ///
    /// # Errors
    /// When the prism cannot be built, has no virtual camera, or no point is seen in both halves.
    pub fn new(scene: &Scene, lens: RelayLens, rings: usize, focus_mm: Option<f64>) -> Result<Self, Error> {
        // Which effects may be left out is not asked of every prism with an error: those of the scene count as they stand.
        let mut scene = made_of_surfaces(scene)?;
        scene.effects.auto = None;
        let system = system::build(&scene)?;
        let frames = [Half::Left, Half::Right].map(|half| HalfFrame::new(&system, half));
        let camera = |frame: &HalfFrame| {
            let help = "use a pinhole camera whose half images look through the prism";
            let none = |why: String| Error::new("the half image", format!("it has no virtual camera: {why}"), help);
            virtual_camera(&system, frame).map_err(|why| none(why.reason().to_owned()))
        };
        let cameras = [camera(&frames[0])?, camera(&frames[1])?];
        let distance = scene.board.world_from_board.translation_mm.z - scene.camera.position_mm.z;
        let far = DVec3::new(0.0, 0.0, scene.camera.position_mm.z + 2.0 * distance);
        let facing = Pose { translation_mm: far, ..Pose::IDENTITY };
        let boards = [scene.board, BoardSpec { world_from_board: facing, ..scene.board }];
        let planes: Vec<ProbePlane> = boards.map(|board| plane(&system, &frames, board)).into();
        if planes.iter().any(|plane| plane.points.len() < POINTS[0]) {
            let rule = "too few points of the board are seen in both halves";
            return Err(Error::new(
                "the scene",
                rule,
                "use a board at a distance where the views of the halves overlap",
            ));
        }
        let focus_mm = focus_mm.unwrap_or_else(|| cameras[1].centre_mm().z);
        Ok(Self { scene, lens, rings, focus_mm, planes, frames, cameras })
    }

    /// The figures of the instrument of `scene`, one for each of `asked`.
    ///
    /// # Errors
    /// Where rays no longer pass, or nothing fits.
    pub fn figures(&self, scene: &Scene, asked: &[Criterion]) -> Result<Vec<f64>, NoFigure> {
        let system = system::build(scene).map_err(|problem| NoFigure(problem.to_string()))?;
        let spot = asked.iter().any(|c| matches!(c, Criterion::Spot | Criterion::BestSpot));
        let spots = if spot { self.spots(&system)? } else { [0.0; 2] };
        let pair = asked.iter().any(|c| matches!(c, Criterion::Vertical | Criterion::Pinhole));
        let planes = if asked.contains(&Criterion::Pinhole) { 2 } else { usize::from(pair) };
        let seen =
            self.planes[..planes].iter().map(|plane| self.seen(&system, plane)).collect::<Result<Vec<_>, _>>()?;
        let figure = |criterion: &Criterion| match criterion {
            Criterion::Spot => Ok(spots[0]),
            Criterion::BestSpot => Ok(spots[1]),
            Criterion::Vertical => Ok(rms(&seen[0].iter().map(|[left, right]| left.y - right.y).collect::<Vec<_>>())),
            Criterion::Pinhole => self.pinhole_px(&system, &seen),
        };
        asked.iter().map(figure).collect()
    }

    /// The spot of the right half, focused as the right prism's is and anew, in um.
    fn spots(&self, system: &System) -> Result<[f64; 2], NoFigure> {
        let prism = system.prism().ok_or_else(|| NoFigure("there is no prism".to_owned()))?;
        let pencil = Pencil::new(system, prism, Side::Right, DVec3::ZERO);
        let places: Vec<DVec2> = std::iter::once(DVec2::ZERO).chain(disc(self.rings)).collect();
        let rays = pencil.pupil(self.lens.na, &places);
        let rays = rays.map_err(|(p, fate)| NoFigure(format!("the ray at {p} of the pupil: {}", fate.name())))?;
        let (chief, rays) = (rays[0].exit, &rays[1..]);
        let best = best_focus_mm(rays).ok_or_else(|| NoFigure("the pencil is parallel".to_owned()))?;
        Ok([self.focus_mm, best].map(|z| 1e3 * self.lens.magnification * PencilSpot::new(rays, &chief, z).rms_mm))
    }

    /// Where both halves see the points of a plane, rectified, in px of each half.
    fn seen(&self, system: &System, plane: &ProbePlane) -> Result<Vec<[DVec2; 2]>, NoFigure> {
        let system = system.with_board(&plane.board);
        let aim = |board_mm: DVec2, px: DVec2, k: usize| {
            let found = system.aim_from(px, board_mm, self.frames[k].side());
            let found = found.map_err(|fate| NoFigure(format!("the point seen at {px} px: {}", fate.name())))?;
            Ok(self.frames[k].rectified(system.camera(), self.frames[k].own(found)))
        };
        plane.points.iter().map(|(mm, [left, right])| Ok([aim(*mm, *left, 0)?, aim(*mm, *right, 1)?])).collect()
    }

    /// Root mean square over both halves of what the best pinhole leaves.
    fn pinhole_px(&self, system: &System, seen: &[Vec<[DVec2; 2]>]) -> Result<f64, NoFigure> {
        let mut squares = 0.0;
        for (k, camera) in self.cameras.iter().enumerate() {
            let mut observations = Vec::new();
            for (plane, seen) in self.planes.iter().zip(seen) {
                let board = system.with_board(&plane.board);
                let observed = plane.points.iter().zip(seen);
                observations.extend(
                    observed.map(|((mm, _), px)| Observation { image_px: px[k], point_mm: board.board().world(*mm) }),
                );
            }
            let fitted = fit(camera, &POSE_AND_FOCAL, &observations).map_err(|why| NoFigure(why.to_string()))?;
            squares += fitted.deviation.rms * fitted.deviation.rms;
        }
        Ok((0.5 * squares).sqrt())
    }
}

/// The points of a plane that a grid over the left half sees and the right half sees as well.
fn plane(system: &System, frames: &[HalfFrame; 2], board: BoardSpec) -> ProbePlane {
    let system = system.with_board(&board);
    let aimer = Aimer::new(&system);
    let place = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
    let both = |k: usize| {
        let share = DVec2::new(place(k % POINTS[0], POINTS[0]), place(k / POINTS[0], POINTS[1]));
        let left = frames[0].full(frames[0].size_px * share);
        let board_mm = system.footprint_through(left, Side::Left).ok()?.sight.board_mm;
        let right = aimer.aim(board_mm, Side::Right).ok()?;
        (aimer.sees(left, Side::Left) && aimer.sees(right, Side::Right)).then_some((board_mm, [left, right]))
    };
    ProbePlane { board, points: (0..POINTS[0] * POINTS[1]).filter_map(both).collect() }
}
