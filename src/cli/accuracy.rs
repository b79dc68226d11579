//! What was asked of a picture's accuracy, and what came of it.

use super::outcome::Outcome;
use super::output;
use crate::accuracy::Accuracy;
use crate::render::{AccuracyReport, Counts};
use crate::report::json;
use crate::scene::Scene;

/// The scene at the cheapest level that keeps to `target_px`, or as it is.
pub(super) fn asked(scene: Scene, target_px: Option<f64>) -> Scene {
    match target_px {
        Some(target_px) => Scene { accuracy: Accuracy::for_target(target_px), ..scene },
        None => scene,
    }
}

/// The entry in a report.
pub(super) fn entry(account: &AccuracyReport, counts: &Counts) -> json::AccuracyEntry {
    json::AccuracyEntry {
        level: account.level.name().to_owned(),
        target_px: account.target_px,
        promise_px: account.promise_px,
        achieved_px: account.achieved_px(),
        capped_pixels: counts.capped_pixels,
    }
}

/// Says which level made the picture `name`, why, and what it kept to; unmet where that is not what was asked for.
pub(super) fn told(name: &str, account: &AccuracyReport, counts: &Counts) -> Outcome {
    output::stderr(&format!("{name}: {account}"));
    if counts.capped_pixels > 0 {
        output::stderr(&format!(
            "{name}: {} pixels were divided as often as is allowed and hold no promise",
            counts.capped_pixels
        ));
    }
    match account.target_px {
        Some(target_px) if !account.keeps_to_target() => {
            output::stderr(&format!("{name}: not kept to {target_px:.0e} px, as was asked for"));
            Outcome::Unmet
        }
        _ => Outcome::Done,
    }
}
