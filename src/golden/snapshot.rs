//! What a golden keeps of a scene besides its picture.

use super::residuals::{Reasons, residual, traced};
use crate::analysis::board_indexing::Found;
use crate::analysis::fates::fates;
use crate::analysis::judge::measure;
use crate::analysis::truth::TrueCorner;
use crate::analysis::view::{HalfView, see};
use crate::error::Error;
use crate::raster::Raster;
use crate::render::Outputs;
use crate::scene::Scene;
use crate::system::System;
use crate::{render, system};
use serde_json::{Value, json};

/// The picture of a scene, and its corners, residuals, fates and operation counts; what of these depends on random
/// numbers is left out. A residual that does not exist is the reason, in words.
///
/// # Errors
/// When the instrument cannot be built.
pub fn record(scene: &Scene) -> Result<(Raster<f32>, Value), Error> {
    let system = system::build(scene)?;
    let random = system.effects().is_random();
    let film = render::render(&system, &());
    let mut view = see(&system, &system.effects().decoded(&film.radiance), true, &());
    let reasons = view.halves.each_ref().map(|half| Reasons::of(&system, half, random));
    if random {
        // The exact residuals are those of all corners, not of those that chance let be found.
        view.halves.iter_mut().for_each(|half| half.found.clear());
    }
    let judgement = measure(scene, &system, view, &[]);
    let half = |k: usize| {
        let (view, figures, reasons) = (&judgement.view.halves[k], &judgement.halves[k], &reasons[k]);
        let own = figures.at(judgement.view.depth_mm).expect("the scene's own board has a depth");
        let residuals = json!({
            "designed_rms_px": residual(&own.designed, reasons, |d| d.rms),
            "exit_rays_rms_px": traced(&figures.designed, reasons, |d| d.px.rms),
            "straightness_rms_px": residual(&figures.straightness, &reasons.without_pinhole(), |s| s.both.rms_px),
        });
        if random {
            return json!({ "visible": view.detected.visible, "true_px": truth(view), "residuals": residuals });
        }
        json!({
            "visible": view.detected.visible,
            "wrong": view.detected.wrong,
            "rejected": view.detected.rejected,
            "found_px": found(view),
            "true_px": truth(view),
            "residuals": residuals,
        })
    };
    let pair = reasons[0].without_pinhole().or(&reasons[1].without_pinhole());
    let value = json!({
        "pixel_centre": "(i + 0.5, j + 0.5), from the half's own origin",
        "fates": film.class.as_ref().map(fates),
        "counts": film.counts,
        "left": half(0),
        "right": half(1),
        "residuals": {
            "vertical_disparity_rms_px": residual(&judgement.stereo.disparity, &pair, |d| d.vertical_rms_px),
        },
    });
    Ok((film.radiance, value))
}

/// The pictures that one specimen of the sensor takes of the scene in as many frames, its own first, and the picture without
/// noise.
///
/// # Errors
/// When the instrument cannot be built.
pub fn frames(scene: &Scene, count: usize) -> Result<(Vec<Raster<f32>>, Raster<f32>), Error> {
    let system = system::build(scene)?;
    let picture = |system: &System| render::render_wanted(system, Outputs { truth: false }, &()).radiance;
    let pictures = (0..count as u32).map(|later| picture(&system.in_frame(later))).collect();
    Ok((pictures, picture(&system.without_noise())))
}

fn found(view: &HalfView) -> Value {
    let corner = |f: &Found| {
        let name = format!("{},{}", f.index[0], f.index[1]);
        (name, json!([f.position_px.x, f.position_px.y]))
    };
    view.found.iter().map(corner).collect::<serde_json::Map<_, _>>().into()
}

fn truth(view: &HalfView) -> Value {
    let corner = |(index, t): (&[i32; 2], &TrueCorner)| {
        (format!("{},{}", index[0], index[1]), json!([t.position_px.x, t.position_px.y]))
    };
    view.truth.iter().flatten().map(corner).collect::<serde_json::Map<_, _>>().into()
}
