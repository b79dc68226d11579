//! The corner detector in the study: the metrics that a user would take from a picture.

use super::shifts::Shifts;
use crate::analysis::half_image::{HalfFrame, virtual_camera};
use crate::analysis::truth::TrueCorners;
use crate::analysis::view::{BoardView, see};
use crate::metrics::pinhole::Pinhole;
use crate::metrics::stereo::disparity;
use crate::metrics::{Observation, Pair};
use crate::raster::Raster;
use crate::system::{Board, System};
use glam::DVec2;
use std::collections::BTreeMap;

/// The stereo pair in a picture, by its detected corners only.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Measured {
    /// Corners found in both halves.
    pub corners: usize,
    /// Their shifts against the same corners found in the reference.
    pub shifts_px: Option<Shifts>,
    /// RMS distance of the corners from where the two designed virtual cameras see them, nothing fitted, in px.
    pub reprojection_rms_px: Option<f64>,
    /// RMS difference of the rows of a corner in the left and the right half, in px.
    pub vertical_disparity_rms_px: Option<f64>,
}

/// Detected corners by half and board index, in px from the half's own origin.
type Positions = [BTreeMap<[i32; 2], DVec2>; 2];

/// The reference as the detector sees it.
pub(super) struct DetectorRun {
    reference: Positions,
}

impl DetectorRun {
    /// Detects the corners of the reference.
    pub(super) fn new(system: &System, reference: &Raster<f32>) -> Self {
        Self { reference: positions(&look(system, &system.effects().decoded(reference))) }
    }

    /// Compares another picture of the same instrument.
    pub(super) fn measure(&self, system: &System, picture: &Raster<f32>) -> Measured {
        let view = look(system, &system.effects().decoded(picture));
        let found = positions(&view);
        let shift = |k: usize| {
            let reference = &self.reference[k];
            found[k].iter().filter_map(move |(index, px)| reference.get(index).map(|own| own.distance(*px)))
        };
        let shifts: Vec<f64> = [0, 1].into_iter().flat_map(shift).collect();
        let cameras = view.halves.each_ref().map(|half| half.camera.ok());
        let rectified = view.halves.each_ref().map(|half| half.positions()[0].clone().unwrap_or_default());
        let residuals: Vec<DVec2> = [0, 1]
            .into_iter()
            .filter_map(|k| cameras[k].and_then(|camera| residuals_px(&camera, &view.board, &rectified[k])))
            .flatten()
            .collect();
        let pairs: Vec<Pair> = rectified[0]
            .iter()
            .filter_map(|(&index, &left_px)| {
                rectified[1].get(&index).map(|&right_px| Pair { index, left_px, right_px })
            })
            .collect();
        Measured {
            corners: found.iter().map(BTreeMap::len).sum(),
            shifts_px: Shifts::of(&shifts),
            reprojection_rms_px: rms_px(&residuals),
            vertical_disparity_rms_px: disparity(&pairs).ok().map(|d| d.vertical_rms_px),
        }
    }
}

/// RMS distance of a half's exact corners from where its virtual camera sees them; `None` of none.
pub(super) fn true_reprojection_rms_px(system: &System, frame: &HalfFrame, corners: &TrueCorners) -> Option<f64> {
    let camera = virtual_camera(system, frame).ok()?;
    let rectified = |px| frame.rectified(system.camera(), px);
    let positions = corners.iter().map(|(&index, corner)| (index, rectified(corner.position_px))).collect();
    rms_px(&residuals_px(&camera, system.board(), &positions)?)
}

fn look(system: &System, picture: &Raster<f32>) -> BoardView {
    see(system, picture, false, &())
}

fn positions(view: &BoardView) -> Positions {
    view.halves.each_ref().map(|half| half.found.iter().map(|f| (f.index, f.position_px)).collect())
}

fn residuals_px(camera: &Pinhole, board: &Board, positions: &BTreeMap<[i32; 2], DVec2>) -> Option<Vec<DVec2>> {
    let observation = |(&[column, row], &image_px): (&[i32; 2], &DVec2)| Observation {
        point_mm: board.world(board.corner_at(f64::from(column), f64::from(row))),
        image_px,
    };
    camera.residuals_px(&positions.iter().map(observation).collect::<Vec<_>>()).ok()
}

/// sqrt(sum |e|^2 / N); `None` of none.
pub(super) fn rms_px(residuals: &[DVec2]) -> Option<f64> {
    let mean_square = residuals.iter().map(|e| e.length_squared()).sum::<f64>() / residuals.len() as f64;
    mean_square.is_finite().then(|| mean_square.sqrt())
}
