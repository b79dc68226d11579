//! Scenes held against their goldens.

use super::cases;
use super::cases::PIXEL_TOLERANCE;
use super::noise::REPLICATES;
use super::record::Tolerance;
use super::report::{CaseResult, Folders, GoldenOutput, GoldenReport, Mode, Tolerances};
use super::run::{GoldenRequest, run};
use super::snapshot::{frames, record};
use crate::error::Error;
use crate::scene;
use std::path::Path;

/// Holds every case against its golden.
///
/// # Errors
/// As [`run`].
pub fn check(folders: &Folders<'_>, mode: Mode) -> Result<GoldenReport, Error> {
    check_asked(folders, mode, &GoldenRequest::default())
}

/// Holds the cases that are asked for against their goldens.
///
/// # Errors
/// As [`run`].
pub fn check_asked(folders: &Folders<'_>, mode: Mode, request: &GoldenRequest) -> Result<GoldenReport, Error> {
    run(folders, mode, request, &tolerance, &rendered)
}

/// Holds one case against its golden.
///
/// # Errors
/// As [`cases::run_case`].
pub fn check_case(folders: &Folders<'_>, mode: Mode, name: &str) -> Result<CaseResult, Error> {
    let tolerances = Tolerances { record: &tolerance, grey: PIXEL_TOLERANCE };
    cases::run_case(folders, mode, &tolerances, &rendered, name)
}

/// What the case at `path` gives.
fn rendered(path: &Path) -> Result<GoldenOutput, Error> {
    let scene = scene::load(path)?;
    let (picture, record) = record(&scene)?;
    if scene.effects.is_random() {
        let (pictures, quiet) = frames(&scene, REPLICATES)?;
        return Ok(GoldenOutput::of_random(&pictures, &quiet, record));
    }
    Ok(GoldenOutput { picture, record, noise: None })
}

/// How far a leaf of a record may move. The house promises the same results to 1e-9 across machines; a fitted corner
/// stops within 1e-6 px of where it would end.
fn tolerance(pointer: &str) -> Tolerance {
    if pointer.contains("/true_px/") {
        Tolerance::Px(1e-9)
    } else if pointer.contains("/found_px/") {
        Tolerance::Px(1e-6)
    } else if pointer.contains("/residuals/") {
        Tolerance::Number(1e-6)
    } else {
        Tolerance::Exact
    }
}
