//! The accuracy report of a command: the target, and what was achieved.

use super::outcome::Outcome;
use super::output;
use crate::accuracy::Accuracy;
use crate::render::{AccuracyReport, Counts};
use crate::report::design;
use crate::scene::Scene;

/// The scene at the cheapest level that keeps to `target_px`, or as it is.
pub(super) fn asked(scene: Scene, target_px: Option<f64>) -> Scene {
    match target_px {
        Some(target_px) => Scene { accuracy: Accuracy::for_target(target_px), ..scene },
        None => scene,
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
    let unmet = design::accuracy(account, counts).unmet();
    unmet.iter().for_each(|words| output::unmet(&format!("{name}: {words}")));
    if unmet.is_empty() { Outcome::Done } else { Outcome::Unmet }
}
