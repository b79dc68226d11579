//! The accuracy report of a command: the target, and what was achieved.

use super::outcome::Outcome;
use super::output;
use crate::accuracy::Accuracy;
use crate::render::{AccuracyReport, Counts};
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
    let mut outcome = Outcome::Done;
    if let Some(target_px) = account.target_px.filter(|_| !account.keeps_to_target()) {
        output::unmet(&format!("{name}: not kept to {target_px:.0e} px, as was asked for"));
        outcome = Outcome::Unmet;
    }
    if let Some(target) = account.noise_target.filter(|_| !account.keeps_to_noise()) {
        let reached = account.noise.map_or("not told".to_owned(), |noise| format!("{noise:.1e}"));
        output::unmet(&format!(
            "{name}: the standard error in the worst block is {reached}, and `quadrature.noise` asks for {target:.1e}: give \
             more `replicates` or `points`"
        ));
        outcome = Outcome::Unmet;
    }
    outcome
}
