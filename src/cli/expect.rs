//! The claims of a scene about its own result (`[[expect]]`).

use super::outcome::Outcome;
use super::output;
use crate::error::Error;
use crate::report::expectations::unmet;
use crate::report::json::Report;
use crate::scene::Scene;

/// Holds the scene's claims against the report, and says which are not met.
pub(super) fn expectations(scene: &Scene, report: &Report) -> Result<Outcome, Error> {
    let mut outcome = Outcome::Done;
    for sentence in unmet(scene, report) {
        output::unmet(&sentence?);
        outcome = Outcome::Unmet;
    }
    Ok(outcome)
}
