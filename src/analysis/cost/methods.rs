//! Render methods that the study compares: each level of this renderer, and supersampling.

use super::settings::CostSettings;
use crate::accuracy::{Accuracy, Arithmetic, Level};
use crate::raster::Raster;
use crate::render::supersample::{SamplePlaces, supersampled};
use crate::render::{AccuracyReport, Counts, Outputs, render_wanted};
use crate::system::System;

/// One way to make a picture.
#[derive(Debug, Clone)]
pub(super) struct RenderMethod {
    pub(super) knob: &'static str,
    pub(super) value: String,
    pub(super) number: f64,
    kind: MethodKind,
}

#[derive(Debug, Clone)]
enum MethodKind {
    By(Accuracy),
    Points(usize, SamplePlaces),
}

/// A rendered picture.
pub(super) struct Made {
    pub(super) radiance: Raster<f32>,
    pub(super) counts: Counts,
    pub(super) account: Option<AccuracyReport>,
}

impl RenderMethod {
    fn by(knob: &'static str, value: impl Into<String>, number: f64, accuracy: Accuracy) -> Self {
        Self { knob, value: value.into(), number, kind: MethodKind::By(accuracy) }
    }

    /// The accuracy by which the picture is rendered; `None` of point samples.
    pub(super) fn accuracy(&self) -> Option<Accuracy> {
        match self.kind {
            MethodKind::By(accuracy) => Some(accuracy),
            MethodKind::Points(..) => None,
        }
    }

    /// The picture of `system` by this method.
    pub(super) fn picture(&self, system: &System) -> Made {
        match self.kind {
            MethodKind::By(accuracy) => {
                let system = system.with_accuracy(accuracy);
                let film = render_wanted(&system, Outputs { truth: false }, &());
                Made { radiance: film.radiance, counts: film.counts, account: Some(film.account) }
            }
            MethodKind::Points(n, samples) => {
                let [width, height] = system.camera().size_px();
                let counts = Counts { rays: (width * height * n * n) as u64, ..Counts::default() };
                Made { radiance: supersampled(system, n, samples), counts, account: None }
            }
        }
    }
}

/// Every knob one by one, the other knobs as the level that the first list names has them.
pub(super) fn all(settings: &CostSettings) -> Vec<RenderMethod> {
    let (standard, exact) = (Accuracy::standard(), Accuracy::exact());
    let mut ways: Vec<RenderMethod> = (1..)
        .zip(Level::ALL)
        .filter(|(_, level)| settings.levels.contains(level))
        .map(|(k, level)| RenderMethod::by("level", level.name(), f64::from(k), level.accuracy()))
        .collect();
    for residual in [1e-1, 1e-3, 1e-6, 1e-9, 1e-12] {
        let accuracy = Accuracy { surface_residual_mm: residual, ..exact };
        ways.push(RenderMethod::by("surface_residual_mm", format!("{residual:.0e}"), residual, accuracy));
    }
    for &bend_px in &settings.bends_px {
        let accuracy = Accuracy { bend_px, max_division: 64, ..standard };
        ways.push(RenderMethod::by("bend_px", format!("{bend_px:.0e}"), bend_px, accuracy));
    }
    for (value, number, arithmetic) in [("f32", 32.0, Arithmetic::Single), ("f64", 64.0, Arithmetic::Double)] {
        // Nothing but the arithmetic differs, and nothing keeps f32 from being used.
        let accuracy = Accuracy { arithmetic, bend_px: 1.0, ..standard };
        ways.push(RenderMethod::by("arithmetic", value, number, accuracy));
    }
    for degree in [2, 3, 4, 6, 8, 10] {
        let accuracy = Accuracy { map_degree: Some(degree), map_px: f64::INFINITY, ..standard };
        ways.push(RenderMethod::by("map_degree", degree.to_string(), degree as f64, accuracy));
    }
    for patch_px in [1024, 512, 256, 128] {
        let accuracy = Accuracy { map_degree: Some(3), map_px: f64::INFINITY, patch_px, ..standard };
        ways.push(RenderMethod::by("patch_px, degree 3", patch_px.to_string(), patch_px as f64, accuracy));
    }
    for (knob, samples) in [("samples, grid", SamplePlaces::Grid), ("samples, jittered", SamplePlaces::Jittered)] {
        for &n in &settings.supersampling {
            ways.push(RenderMethod {
                knob,
                value: format!("{n} x {n}"),
                number: (n * n) as f64,
                kind: MethodKind::Points(n, samples),
            });
        }
    }
    ways
}
