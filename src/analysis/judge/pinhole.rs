//! The halves of a picture against ideal pinholes: the designed one, and those that fit best.

use super::rays::pixel_rays;
use crate::analysis::view::{BoardPlace, BoardView};
use crate::metrics::pinhole::Pinhole;
use crate::metrics::ray_bundle::{PixelRay, PlaneDeviation, on_plane};
use crate::metrics::reprojection::{ALL, POSE, POSE_AND_ANAMORPHIC, POSE_AND_FOCAL, Parameter, PinholeFit};
use crate::metrics::row_law::{self, ROW_LAW, ROW_LAW_AT_ONE_DEPTH, RowDeviation, RowShift};
use crate::metrics::straightness::{IndexedCorner, RowsAndColumns, StraightnessReference, straightness};
use crate::metrics::{Deviation, MeasuredAndTrue, Observation, Unmeasurable, homography, reprojection};
use crate::scene::Scene;
use crate::system::System;
use glam::DVec2;

/// Deviation from the designed virtual camera at one depth.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthFigures {
    /// Distance of the board's centre from the camera along z, in mm.
    pub depth_mm: f64,
    /// Without a fit, in px.
    pub designed: MeasuredAndTrue<Deviation>,
    /// With the centre of projection fitted to this depth alone ([`CENTRE_ONLY`]), in px.
    pub fitted: MeasuredAndTrue<Deviation>,
    /// How far that centre lies from the designed one, in mm, and the count of corners behind it.
    pub drift_mm: MeasuredAndTrue<(f64, usize)>,
    /// Straightness of rows and columns, against chords.
    pub straightness: MeasuredAndTrue<RowsAndColumns>,
}

/// Deviation of one half, or of both pooled, from an ideal pinhole.
#[derive(Debug, Clone, PartialEq)]
pub struct PinholeFigures {
    /// Exit rays of a uniform grid in the plane z = -f of the designed virtual camera: Table 1 of the design paper.
    pub designed: MeasuredAndTrue<PlaneDeviation>,
    /// Against a pinhole fitted over all depths, pose and one focal length free, in px.
    pub fitted: MeasuredAndTrue<Deviation>,
    /// The same with two focal lengths free.
    pub anamorphic: MeasuredAndTrue<Deviation>,
    /// The same with the principal point free too: a pinhole that may be turned and anamorphic.
    pub principal: MeasuredAndTrue<Deviation>,
    /// Against the designed virtual camera over all depths, after one homography of the half: its own centre, but turned and
    /// stretched at will.
    pub homography: MeasuredAndTrue<Deviation>,
    /// Against the row law that fits best over all depths, the rows as they are.
    pub row_law: MeasuredAndTrue<RowDeviation>,
    /// The same with the shift of each row undone.
    pub rows_undone: MeasuredAndTrue<RowDeviation>,
    /// Straightness of rows and columns at the scene's own board, against chords.
    pub straightness: MeasuredAndTrue<RowsAndColumns>,
    /// Depth by depth, nearest first.
    pub depths: Vec<DepthFigures>,
}

impl PinholeFigures {
    /// The figures at the depth nearest to `depth_mm`.
    pub fn at(&self, depth_mm: f64) -> Option<&DepthFigures> {
        let from = |figures: &DepthFigures| (figures.depth_mm - depth_mm).abs();
        self.depths.iter().min_by(|a, b| from(a).total_cmp(&from(b)))
    }
}

/// What a fit at a single depth leaves free: a board that faces the camera does not tell its distance from the focal
/// length, nor a small turn from a shift.
pub const CENTRE_ONLY: [Parameter; 3] = [Parameter::ShiftX, Parameter::ShiftY, Parameter::ShiftZ];

/// One half, with the board at its own depth (`own`) and at all depths (`asked`), nearest first.
pub(super) fn half_figures(
    scene: &Scene,
    system: &System,
    k: usize,
    own: &BoardView,
    asked: &[&BoardView],
) -> PinholeFigures {
    let straight = |view: &BoardView| {
        MeasuredAndTrue::of_sides(view.halves[k].indexed(), |corners| {
            straightness(&corners, StraightnessReference::Chord)
        })
    };
    let camera = match designed_pinhole(own, k) {
        Ok(camera) => camera,
        Err(reason) => return without_pinhole(reason, own, asked, straight),
    };
    let fitted = |free: &[Parameter]| {
        // A single depth does not tell focal lengths from distances: there the pose alone is fitted.
        let free = free_at(free, asked.len());
        let fit = |o: Vec<Observation>| Ok(reprojection::fit(&camera, free, &o)?.deviation);
        MeasuredAndTrue::of_sides(observations_of_all(asked, k), fit)
    };
    // What is designed has its shift of the rows besides the pinhole.
    let half = &own.halves[k];
    let undone = |px: DVec2| half.rows.map_or(px, |rows| rows.undone(px));
    let plane = |sightings: Vec<PixelRay>| {
        let sightings: Vec<_> = sightings.iter().map(|s| PixelRay { image_px: undone(s.image_px), ..*s }).collect();
        on_plane(&camera, &sightings, -scene.camera.focal_length_mm)
    };
    let designed = |observed: Vec<Observation>| -> Vec<Observation> {
        observed.iter().map(|o| Observation { image_px: undone(o.image_px), ..*o }).collect()
    };
    let free_of_rows: &[Parameter] = if asked.len() > 1 { &ROW_LAW } else { &ROW_LAW_AT_ONE_DEPTH };
    let row_law = |rows: Option<&RowShift>| {
        MeasuredAndTrue::of_sides(observations_of_all(asked, k), |o| {
            row_law::deviation(&camera, free_of_rows, rows, &o)
        })
    };
    let depth = |view: &&BoardView| {
        let observed = view.halves[k].observations(&view.board);
        let fit = MeasuredAndTrue::of_sides(observed.clone(), |o| reprojection::fit(&camera, &CENTRE_ONLY, &o));
        let drift = |f: &PinholeFit| Ok(((f.pinhole.centre_mm() - camera.centre_mm()).length(), f.deviation.n));
        DepthFigures {
            depth_mm: view.depth_mm,
            designed: MeasuredAndTrue::of_sides(observed, |o| camera.deviation_px(&designed(o))),
            drift_mm: fit.then(drift),
            fitted: fit.then(|f| Ok(f.deviation)),
            straightness: straight(view),
        }
    };
    PinholeFigures {
        designed: pixel_rays(scene, system, k, own, asked).flat_then(plane),
        fitted: fitted(&POSE_AND_FOCAL),
        anamorphic: fitted(&POSE_AND_ANAMORPHIC),
        principal: fitted(&ALL),
        homography: MeasuredAndTrue::of_sides(observations_of_all(asked, k), |o| homography::deviation(&camera, &o)),
        row_law: row_law(None),
        rows_undone: row_law(half.epipolar_rows.as_ref()),
        straightness: straight(own),
        depths: asked.iter().map(depth).collect(),
    }
}

/// The camera that half `k` is designed to be, where there is one and it is known where the board is.
pub(super) fn designed_pinhole(own: &BoardView, k: usize) -> Result<Pinhole, Unmeasurable> {
    let camera = own.halves[k].camera.map_err(|why| Unmeasurable::NoPinhole(why.reason()))?;
    if own.place == BoardPlace::Unknown { Err(BOARD_UNKNOWN) } else { Ok(camera) }
}

/// Why a half has no figure that tells what it sees of the world.
pub(super) const BOARD_UNKNOWN: Unmeasurable = Unmeasurable::Degenerate("it is not known where the board is");

/// The figures of a half that has no pinhole, or no place in the world: those that need none.
fn without_pinhole(
    reason: Unmeasurable,
    own: &BoardView,
    asked: &[&BoardView],
    straight: impl Fn(&BoardView) -> MeasuredAndTrue<RowsAndColumns>,
) -> PinholeFigures {
    let depths = asked.iter().map(|view| DepthFigures {
        depth_mm: view.depth_mm,
        designed: MeasuredAndTrue::neither(reason),
        fitted: MeasuredAndTrue::neither(reason),
        drift_mm: MeasuredAndTrue::neither(reason),
        straightness: straight(view),
    });
    PinholeFigures {
        designed: MeasuredAndTrue::neither(reason),
        fitted: MeasuredAndTrue::neither(reason),
        anamorphic: MeasuredAndTrue::neither(reason),
        principal: MeasuredAndTrue::neither(reason),
        homography: MeasuredAndTrue::neither(reason),
        row_law: MeasuredAndTrue::neither(reason),
        rows_undone: MeasuredAndTrue::neither(reason),
        straightness: straight(own),
        depths: depths.collect(),
    }
}

/// What a fit over `depths` depths leaves free of `free`.
pub fn free_at(free: &[Parameter], depths: usize) -> &[Parameter] {
    if depths > 1 { free } else { &POSE }
}

/// The observations of one half at all depths.
pub(super) fn observations_of_all(asked: &[&BoardView], k: usize) -> [Option<Vec<Observation>>; 2] {
    let by_view: Vec<_> = asked.iter().map(|v| v.halves[k].observations(&v.board)).collect();
    [0, 1]
        .map(|side| by_view.iter().map(|sides| sides[side].clone()).collect::<Option<Vec<_>>>().map(|all| all.concat()))
}

/// Residuals of both halves together.
pub(super) fn pool(halves: &[PinholeFigures; 2], own: &BoardView, asked: &[&BoardView]) -> PinholeFigures {
    let [left, right] = halves;
    let weighted = |a: &Deviation, b: &Deviation| Ok(a.pooled(b));
    let weighted_rows = |a: &RowDeviation, b: &RowDeviation| Ok(a.pooled(b));
    let straight = |view: &BoardView| {
        // Rows of the two halves are different lines: they get different indices.
        const APART: i32 = 1 << 24;
        let [l, r] = [0, 1].map(|k| view.halves[k].indexed());
        let apart = |c: &IndexedCorner| IndexedCorner { index: c.index.map(|i| i + APART), ..*c };
        let joined = [0, 1].map(|side| {
            let (l, r) = (l[side].as_ref()?, r[side].as_ref()?);
            Some(l.iter().copied().chain(r.iter().map(apart)).collect::<Vec<_>>())
        });
        MeasuredAndTrue::of_sides(joined, |corners| straightness(&corners, StraightnessReference::Chord))
    };
    let depths = left.depths.iter().zip(&right.depths).zip(asked).map(|((a, b), view)| DepthFigures {
        depth_mm: a.depth_mm,
        designed: a.designed.with(&b.designed, weighted),
        fitted: a.fitted.with(&b.fitted, weighted),
        drift_mm: a.drift_mm.with(&b.drift_mm, |a, b| Ok((a.0.max(b.0), a.1 + b.1))),
        straightness: straight(view),
    });
    PinholeFigures {
        designed: left.designed.with(&right.designed, |a, b| {
            Ok(PlaneDeviation {
                plane_z_mm: a.plane_z_mm,
                residuals_mm: [a.residuals_mm.as_slice(), &b.residuals_mm].concat(),
                mm: a.mm.pooled(&b.mm),
                px: a.px.pooled(&b.px),
            })
        }),
        fitted: left.fitted.with(&right.fitted, weighted),
        anamorphic: left.anamorphic.with(&right.anamorphic, weighted),
        principal: left.principal.with(&right.principal, weighted),
        homography: left.homography.with(&right.homography, weighted),
        row_law: left.row_law.with(&right.row_law, weighted_rows),
        rows_undone: left.rows_undone.with(&right.rows_undone, weighted_rows),
        straightness: straight(own),
        depths: depths.collect(),
    }
}
