//! The error of a picture: shifts of its corners and lines from the reference.

use super::corners::ReferenceCorners;
use super::detector::DetectorRun;
use super::lines::line_shifts;
use super::methods::RenderMethod;
use super::shifts::Shifts;
use super::study::Setting;
use super::time::Taken;
use crate::raster::Raster;
use crate::system::System;

/// What pictures are held against.
pub(super) struct Judge<'a> {
    pub(super) system: &'a System,
    pub(super) reference: &'a Raster<f32>,
    pub(super) corners: &'a ReferenceCorners,
    pub(super) eye: &'a DetectorRun,
}

impl Judge<'_> {
    /// A setting, given the times of its pictures.
    pub(super) fn setting(&self, way: &RenderMethod, taken: &Taken) -> Setting {
        let Self { system, reference, corners, eye } = self;
        let made = way.picture(system);
        let contrast = system.board().pattern.white - system.board().pattern.black;
        Setting {
            knob: way.knob,
            value: way.value.clone(),
            number: way.number,
            time_ms: taken.spread_ms(1.0),
            yardsticks: taken.in_yardsticks(reference.data().len() as f64),
            counts: made.counts,
            rmse: rmse(&made.radiance, reference),
            lines_px: Shifts::of(&line_shifts(&made.radiance, reference, contrast)),
            corners_px: way.accuracy().and_then(|accuracy| corners.shifts(system, accuracy)),
            measured: eye.measure(system, &made.radiance),
            account: made.account,
        }
    }
}

/// Root of the mean square of the difference of two pictures.
pub(super) fn rmse(a: &Raster<f32>, b: &Raster<f32>) -> f64 {
    let squares = a.data().iter().zip(b.data()).map(|(a, b)| f64::from(a - b) * f64::from(a - b));
    (squares.sum::<f64>() / a.data().len() as f64).sqrt()
}
