//! What a golden keeps of a scene besides its picture.

use crate::analysis::fates::fates;
use crate::analysis::judge::measure;
use crate::analysis::view::{HalfView, see};
use crate::error::Error;
use crate::metrics::MeasuredAndTrue;
use crate::raster::Raster;
use crate::render::Outputs;
use crate::scene::Scene;
use crate::{render, system};
use serde_json::{Value, json};

/// The picture of a scene, and its corners, residuals, fates and operation counts; what of these depends on random
/// numbers is left out.
///
/// # Errors
/// When the instrument cannot be built.
pub fn record(scene: &Scene) -> Result<(Raster<f32>, Value), Error> {
    let system = system::build(scene)?;
    let random = system.effects().is_random();
    let film = render::render(&system, &());
    let view = see(&system, &film.radiance, true, &());
    let judgement = measure(scene, &system, view, &[]);
    let half = |k: usize| {
        let (view, figures) = (&judgement.view.halves[k], &judgement.halves[k]);
        if random {
            return json!({ "visible": view.detected.visible, "true_px": truth(view) });
        }
        json!({
            "visible": view.detected.visible,
            "wrong": view.detected.wrong,
            "rejected": view.detected.rejected,
            "found_px": found(view),
            "true_px": truth(view),
            "residuals": {
                "designed_rms_px": rms(&figures.designed, |d| d.px.rms),
                "straightness_rms_px": rms(&figures.straightness, |s| s.both.rms_px),
            },
        })
    };
    let mut value = json!({
        "pixel_centre": "(i + 0.5, j + 0.5), from the half's own origin",
        "fates": film.class.as_ref().map(fates),
        "counts": film.counts,
        "left": half(0),
        "right": half(1),
        "residuals": { "vertical_disparity_rms_px": rms(&judgement.stereo.disparity, |d| d.vertical_rms_px) },
    });
    if random {
        value.as_object_mut().and_then(|value| value.shift_remove("residuals"));
    }
    Ok((film.radiance, value))
}

/// The pictures that the scene gives with as many different seeds; its own is the first.
///
/// # Errors
/// When the instrument cannot be built.
pub fn redrawn(scene: &Scene, count: usize) -> Result<Vec<Raster<f32>>, Error> {
    let system = system::build(scene)?;
    let picture = |replicate: u64| {
        let system = system.redrawn(replicate);
        render::render_wanted(&system, Outputs { truth: false }, &()).radiance
    };
    Ok((0..count as u64).map(picture).collect())
}

fn found(view: &HalfView) -> Value {
    let corner = |f: &crate::analysis::board_indexing::Found| {
        let name = format!("{},{}", f.index[0], f.index[1]);
        (name, json!([f.position_px.x, f.position_px.y]))
    };
    view.found.iter().map(corner).collect::<serde_json::Map<_, _>>().into()
}

fn truth(view: &HalfView) -> Value {
    let corner = |(index, t): (&[i32; 2], &crate::analysis::truth::TrueCorner)| {
        (format!("{},{}", index[0], index[1]), json!([t.position_px.x, t.position_px.y]))
    };
    view.truth.iter().flatten().map(corner).collect::<serde_json::Map<_, _>>().into()
}

fn rms<T>(figure: &MeasuredAndTrue<T>, pick: impl Fn(&T) -> f64) -> Value {
    let side = |side: &Option<Result<T, _>>| side.as_ref().and_then(|r| r.as_ref().ok()).map(&pick);
    json!({ "measured": side(&figure.measured), "true": side(&figure.exact) })
}
