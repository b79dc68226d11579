//! From pictures of the board to the judgement of one prism.

use super::cameras::{CameraFigures, camera_figures};
use super::centre::{CentreFigures, centre_figures};
use super::pinhole::{PinholeFigures, half_figures, pool};
use super::stereo::{StereoFigures, stereo_figures};
use crate::analysis::not_judged::not_judged;
use crate::analysis::not_judged_cause::NotJudged;
use crate::analysis::view::{BoardPlace, BoardView, Detected, see};
use crate::progress::Observer;
use crate::render::{self, Film};
use crate::scene::Scene;
use crate::system::System;

/// The judgement of one prism.
#[derive(Debug, Clone)]
pub struct Judgement {
    /// The scene's own board.
    pub view: BoardView,
    /// Detection in the left and the right half.
    pub detected: [Detected; 2],
    /// Left and right against their pinholes.
    pub halves: [PinholeFigures; 2],
    /// Both pooled.
    pub pooled: PinholeFigures,
    /// The centres of projection of left and right, where the virtual camera is known.
    pub centres: [Option<CentreFigures>; 2],
    /// The pair.
    pub stereo: StereoFigures,
    /// The cameras that the pair is used as.
    pub cameras: CameraFigures,
    /// Nearest and farthest depth of the analysis, in mm.
    pub depths_mm: Option<[f64; 2]>,
    /// Why no figure of the pair was measured, where that is so.
    pub not_judged: Option<NotJudged>,
}

/// Renders the scene's board, and the board at every depth of the analysis, and judges what `system` made of them.
/// `observer` hears what is done next, and how many pixels were rendered.
pub fn judge(scene: &Scene, system: &System, observer: &dyn Observer) -> (Film, Judgement) {
    let look = |system: &System| {
        observer.stage("render");
        let film = render::render(system, observer);
        let view = see(system, &system.effects().decoded(&film.radiance), true, observer);
        (film, view)
    };
    let (film, own) = look(system);
    let others: Vec<BoardView> =
        other_depths(scene).map(|depth_mm| look(&at_depth(scene, system, depth_mm)).1).collect();
    observer.stage("measure");
    let judgement = measure(scene, system, own, &others);
    (film, judgement)
}

/// The figures of the scene's own board `own`, with those of the boards at other depths.
pub fn measure(scene: &Scene, system: &System, own: BoardView, others: &[BoardView]) -> Judgement {
    let mut asked: Vec<&BoardView> = others.iter().chain([&own]).collect();
    asked.sort_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm));
    let halves = [0, 1].map(|k| half_figures(scene, system, k, &own, &asked));
    let pooled = pool(&halves, &own, &asked);
    let centres = [0, 1].map(|k| centre_figures(scene, system, k, &own, &asked));
    let cameras = camera_figures(&own, &asked);
    let stereo = stereo_figures(scene, system, &own, &asked, &cameras);
    let known = own.place != BoardPlace::Unknown;
    let depths_mm = known.then(|| [asked[0].depth_mm, asked[asked.len() - 1].depth_mm]);
    let detected = own.halves.each_ref().map(|h| h.detected.clone());
    let not_judged = not_judged(scene, system, &own);
    Judgement { detected, halves, pooled, centres, stereo, cameras, depths_mm, not_judged, view: own }
}

/// The depths of the analysis that are not, up to rounding, that of the scene's own board, in mm.
pub fn other_depths(scene: &Scene) -> impl Iterator<Item = f64> {
    let own_mm = scene.board.world_from_board.translation_mm.z - scene.camera.position_mm.z;
    let other = move |depth_mm: &f64| (depth_mm - own_mm).abs() > 1e-9 * (depth_mm.abs() + own_mm.abs());
    scene.analysis.depths_mm.iter().copied().filter(other)
}

/// The same instrument with the board moved along z to `depth_mm` from the camera.
fn at_depth(scene: &Scene, system: &System, depth_mm: f64) -> System {
    let mut board = scene.board;
    board.world_from_board.translation_mm.z = scene.camera.position_mm.z + depth_mm;
    system.with_board(&board)
}
