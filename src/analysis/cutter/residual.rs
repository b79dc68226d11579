//! What a prism leaves of the law that it is meant to have, by its own rays.

use super::bench::{Bench, tangents};
use crate::error::Error;
use crate::metrics::Deviation;
use glam::DVec2;

/// Places along each side of a half: 21 x 21 hold the largest of 401 x 401 already.
pub(super) const PLACES: usize = 41;

/// Where the pixels of both halves look at one distance, against the law.
#[derive(Debug, Clone, PartialEq)]
pub struct LawResidual {
    /// The distance from the virtual cameras along their axes, in mm; infinite for directions.
    pub depth_mm: f64,
    /// sqrt(sum e^2 / N) along the rows and across them, in px.
    pub rms_px: DVec2,
    /// sqrt(sum |e|^2 / N) of the vectors, in px.
    pub both_rms_px: f64,
    /// Largest |e|, in px.
    pub max_px: f64,
}

/// The error vectors of the right half.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualMap {
    /// Columns, and rows.
    pub side: usize,
    /// Found minus law, row by row, in px.
    pub errors_px: Vec<DVec2>,
}

/// The residual at the distance `depth_mm`, and its map over the right half.
pub(super) fn residual(bench: &Bench<'_>, depth_mm: f64) -> Result<(LawResidual, ResidualMap), Error> {
    let inverse_mm = 1.0 / depth_mm;
    let places = bench.places(PLACES);
    let mut halves = [Vec::new(), Vec::new()];
    for (half, errors) in bench.halves.iter().zip(&mut halves) {
        for &place_px in &places {
            let ray = bench.passed(&bench.ray(&half.frame, place_px), half.frame.side(), &mut ())?;
            let meant_px = half.rows.map_or(place_px, |rows| rows.undone(place_px));
            let meant = (meant_px - half.camera.principal_px) / half.camera.focal_px;
            // Seen where the law has it, the pixel would look where its ray goes.
            errors.push((meant - tangents(&half.camera, &ray, inverse_mm)) * half.camera.focal_px);
        }
    }
    let [left, right] = halves;
    let all = [left.as_slice(), &right].concat();
    let sizes = Deviation::of(&all).map_err(|why| Error::new("the prism", why.to_string(), "give a smoother prism"))?;
    let squares: DVec2 = all.iter().map(|e| *e * *e).sum();
    let rms_px = (squares / all.len() as f64).map(f64::sqrt);
    let found = LawResidual { depth_mm, rms_px, both_rms_px: sizes.rms, max_px: sizes.max };
    Ok((found, ResidualMap { side: PLACES, errors_px: right }))
}
