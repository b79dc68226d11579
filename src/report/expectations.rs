//! What a scene claims about its own result, held against the report.

use super::json::{Report, number_at};
use crate::error::Error;
use crate::scene::{Expect, Scene};

/// The claims of `scene` that `report` does not meet, a sentence each, in their order.
///
/// # Errors
/// Instead of a sentence, where a claim names no number of the report.
pub fn unmet(scene: &Scene, report: &Report) -> impl Iterator<Item = Result<String, Error>> {
    scene.expect.iter().filter_map(move |claim| held(scene, claim, report).transpose())
}

fn held(scene: &Scene, claim: &Expect, report: &Report) -> Result<Option<String>, Error> {
    let value = number_at(report, &claim.value).map_err(|why| {
        let help = "name a number of report.json, as in freeform/pinhole/designed/mean_abs_v_mm/true";
        Error::new(format!("scene {}", scene.name), format!("`expect.value`: {why}"), help)
    })?;
    let too_small = claim.min.is_some_and(|min| value < min);
    let too_large = claim.max.is_some_and(|max| value > max);
    let bound = |b: Option<f64>| b.map_or("any".to_owned(), |b| b.to_string());
    let range = format!("{} .. {}", bound(claim.min), bound(claim.max));
    Ok((too_small || too_large)
        .then(|| format!("not as expected: {} is {value}, and the scene expects {range}", claim.value)))
}
