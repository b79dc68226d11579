//! Left against right: vertical disparity, epipolar curves, disparity against depth.

use super::cameras::CameraFigures;
use super::pinhole::{BOARD_UNKNOWN, designed_pinhole};
use super::rays::grid_sightings;
use crate::analysis::view::{BoardPlace, BoardView, HalfView};
use crate::geom::Pose;
use crate::metrics::depth_error::{DepthError, depth_error};
use crate::metrics::epipolar::Summary;
use crate::metrics::pixel_map::DEGREE;
use crate::metrics::rectification::Rectification;
use crate::metrics::stereo::{DepthLaw, Disparity};
use crate::metrics::{MeasuredAndTrue, Pair, Unmeasurable, epipolar, stereo};
use crate::scene::Scene;
use crate::system::System;
use crate::system::aim::Aimer;
use glam::{DVec2, DVec3};

/// Figures of the pair.
#[derive(Debug, Clone, PartialEq)]
pub struct StereoFigures {
    /// Vertical disparity on the raw halves at the scene's own board.
    pub disparity: MeasuredAndTrue<Disparity>,
    /// Epipolar curves in the right half of pixels of the left half.
    pub epipolar: MeasuredAndTrue<Summary>,
    /// Vertical disparity at the scene's own board after one homography a half: rectified by the cameras fitted over all depths.
    pub rectified: MeasuredAndTrue<Disparity>,
    /// Disparity against depth.
    pub depth_law: MeasuredAndTrue<DepthLaw>,
    /// Depth of the scene's own board by the designed pair on the raw halves, against the true one.
    pub depth_error: MeasuredAndTrue<DepthError>,
}

/// Pixels along each side of a half whose epipolar curves are traced.
const CURVES: usize = 9;
/// Samples on each traced epipolar curve.
const SAMPLES: usize = 16;

/// The pair, with the board at its own depth (`own`) and at all depths (`asked`), nearest first.
pub(super) fn stereo_figures(
    scene: &Scene,
    system: &System,
    own: &BoardView,
    asked: &[&BoardView],
    cameras: &CameraFigures,
) -> StereoFigures {
    let width = own.halves[0].frame.size_px.x;
    let by_depth: Vec<[Option<Vec<Pair>>; 2]> = asked.iter().map(|view| pairs(view)).collect();
    let of_side = |side: usize| by_depth.iter().map(|sides| sides[side].clone()).collect::<Option<Vec<_>>>();
    let law = |depths: Vec<Vec<Pair>>| {
        if own.place == BoardPlace::Unknown {
            return Err(BOARD_UNKNOWN);
        }
        let disparity = |p: &Pair| p.left_px.x - p.right_px.x;
        let of_view = |(view, pairs): (&&BoardView, &Vec<Pair>)| {
            let sample = |p: &Pair| (view.board.corner_depth_mm(p.index, scene.camera.position_mm.z), disparity(p));
            pairs.iter().map(sample).collect::<Vec<_>>()
        };
        stereo::depth_law(&asked.iter().zip(&depths).flat_map(of_view).collect::<Vec<_>>())
    };
    let measured_curves =
        |depths: Vec<Vec<Pair>>| epipolar::summary(&epipolar::curves_from_depths(&depths, DEGREE)?, width);
    let known = own.halves[0].truth.is_some();
    let rectification = cameras.fits[0].with(&cameras.fits[1], |left, right| {
        at_least_two(asked)?;
        Rectification::of([&left.pinhole, &right.pinhole])
    });
    let [measured, exact] = pairs(own).map(|side| side.map(Ok));
    let own_pairs = MeasuredAndTrue { measured, exact };
    StereoFigures {
        disparity: MeasuredAndTrue::of_sides(pairs(own), |p| stereo::disparity(&p)),
        epipolar: MeasuredAndTrue {
            measured: of_side(0).map(measured_curves),
            exact: known.then(|| {
                // At a single depth a curve is a point.
                at_least_two(asked)?;
                let range = [asked[0].depth_mm, asked[asked.len() - 1].depth_mm];
                epipolar::summary(&epipolar_curves(scene, system, &own.halves, range), width)
            }),
        },
        rectified: own_pairs.with(&rectification, |pairs, maps| stereo::disparity(&maps.pairs(pairs)?)),
        depth_law: MeasuredAndTrue::of_sides([0, 1].map(of_side), law),
        depth_error: MeasuredAndTrue::of_sides(pairs(own), |pairs| error_of_depth(own, &pairs)),
    }
}

/// The error of depth over the pairs of the board `own`.
fn error_of_depth(own: &BoardView, pairs: &[Pair]) -> Result<DepthError, Unmeasurable> {
    if own.place == BoardPlace::Unknown {
        return Err(BOARD_UNKNOWN);
    }
    let [left, right] = [designed_pinhole(own, 0)?, designed_pinhole(own, 1)?];
    let place = |[column, row]: [i32; 2]| own.board.world(own.board.corner_at(f64::from(column), f64::from(row)));
    depth_error([&left, &right], &pairs.iter().map(|pair| (*pair, place(pair.index))).collect::<Vec<_>>())
}

fn at_least_two(asked: &[&BoardView]) -> Result<(), Unmeasurable> {
    match asked.len() {
        found @ 0..2 => Err(Unmeasurable::TooFew { what: "depths of the board", found, needed: 2 }),
        _ => Ok(()),
    }
}

/// Corners seen in both halves, detected and exact.
fn pairs(view: &BoardView) -> [Option<Vec<Pair>>; 2] {
    let [left, right] = [0, 1].map(|k| view.halves[k].positions());
    [0, 1].map(|side| {
        let (left, right) = (left[side].as_ref()?, right[side].as_ref()?);
        let pair = |(index, &left_px): (&[i32; 2], &DVec2)| {
            Some(Pair { index: *index, left_px, right_px: *right.get(index)? })
        };
        Some(left.iter().filter_map(pair).collect())
    })
}

/// The exact epipolar curves in the right half of a uniform grid of pixels of the left half: the left pixel's ray,
/// sampled at equal steps of 1/depth over the range of depths, each point aimed at through the right side.
/// Pixels that the right half does not see over the whole range of depths are left out.
fn epipolar_curves(scene: &Scene, system: &System, halves: &[HalfView; 2], [near, far]: [f64; 2]) -> Vec<Vec<DVec2>> {
    let [left, right] = [&halves[0].frame, &halves[1].frame];
    let sightings = grid_sightings(system, left, CURVES);
    let mut curves = vec![Vec::new(); sightings.len()];
    let mut nearest = vec![None; sightings.len()];
    for s in 0..SAMPLES {
        let share = s as f64 / (SAMPLES - 1) as f64;
        let depth_mm = 1.0 / ((1.0 - share) / near + share / far);
        let mut plane = scene.board;
        let place = DVec3::new(0.0, 0.0, scene.camera.position_mm.z + depth_mm);
        plane.world_from_board = Pose { translation_mm: place, ..Pose::IDENTITY };
        let system = system.with_board(&plane);
        let aimer = Aimer::new(&system);
        // A curve that lacks a point is left out, and has no more of them sought.
        let whole = curves.iter_mut().zip(&mut nearest).zip(&sightings).filter(|((curve, _), _)| curve.len() == s);
        for ((curve, near), sighting) in whole {
            // The search starts where the same ray was seen at the depth before.
            let met = system.board().intersect(&sighting.ray);
            let seen = met.and_then(|(mm, _)| aimer.aim_from(mm, right.side(), *near)).ok();
            *near = seen.or(*near);
            let inside = seen.map(|full_px| right.own(full_px)).filter(|px| right.contains(*px));
            curve.extend(inside.map(|px| right.rectified(system.camera(), px)));
        }
    }
    curves.retain(|curve| curve.len() == SAMPLES);
    curves
}
