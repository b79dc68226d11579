//! The claims of a scene about its own result (`[[expect]]`).

use super::outcome::Outcome;
use super::output;
use crate::error::Error;
use crate::report::json::{Report, number_at};
use crate::scene::Scene;

/// Holds the scene's claims against the report.
pub(super) fn expectations(scene: &Scene, report: &Report) -> Result<Outcome, Error> {
    let mut outcome = Outcome::Done;
    for claim in &scene.expect {
        let value = number_at(report, &claim.value).map_err(|why| {
            let help = "name a number of report.json, as in freeform/pinhole/designed/mean_abs_v_mm/true";
            Error::new(format!("scene {}", scene.name), format!("`expect.value`: {why}"), help)
        })?;
        let too_small = claim.min.is_some_and(|min| value < min);
        let too_large = claim.max.is_some_and(|max| value > max);
        if too_small || too_large {
            let bound = |b: Option<f64>| b.map_or("any".to_owned(), |b| b.to_string());
            let range = format!("{} .. {}", bound(claim.min), bound(claim.max));
            output::stderr(&format!("not as expected: {} is {value}, and the scene expects {range}", claim.value));
            outcome = Outcome::Unmet;
        }
    }
    Ok(outcome)
}
