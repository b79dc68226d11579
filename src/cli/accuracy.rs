//! What was asked of a picture's accuracy, and what came of it.

use super::{Outcome, say};
use crate::accuracy::Accuracy;
use crate::render::{Account, Counts};
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
pub(super) fn entry(account: &Account, counts: &Counts) -> json::Accuracy {
    json::Accuracy {
        level: account.level.name().to_owned(),
        target_px: account.target_px,
        promise_px: account.promise_px,
        achieved_px: account.achieved_px(),
        capped_pixels: counts.capped_pixels,
        unpromised_pixels: account.unpromised_pixels,
    }
}

/// Says which level made the picture `name`, why, and what it kept to; unmet where that is not what was asked for.
pub(super) fn told(name: &str, account: &Account, counts: &Counts) -> Outcome {
    say::words(&format!("{name}: {account}"));
    if counts.capped_pixels > 0 {
        say::words(&format!(
            "{name}: {} pixels were divided as often as is allowed and hold no promise",
            counts.capped_pixels
        ));
    }
    match account.target_px {
        Some(target_px) if account.achieved_px() > target_px => {
            say::words(&format!("{name}: not kept to {target_px:.0e} px, as was asked for"));
            Outcome::Unmet
        }
        _ => Outcome::Done,
    }
}
