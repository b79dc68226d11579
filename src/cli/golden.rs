//! `biprism golden`: regression tests of pictures and corners, for this project's own cases and for a user's.

use super::args::GoldenArgs;
use super::outcome::Outcome;
use super::output;
use super::progress::Progress;
use crate::error::Error;
use crate::golden::noise::REPLICATES;
use crate::golden::record::Tolerance;
use crate::golden::snapshot::{record, redrawn};
use crate::golden::{Folders, GoldenOutput, GoldenReport, Mode};
use crate::{golden, scene};
use std::path::Path;

pub(super) fn run(args: &GoldenArgs) -> Result<Outcome, Error> {
    let variable = |name: &str| std::env::var(name).ok();
    let mode = Mode::of_variables(variable("UPDATE_GOLDEN").as_deref(), variable("CI").as_deref())?;
    let mut progress = Progress::new(0);
    progress.begin("golden", "cases");
    let report = check(&Folders { cases: &args.cases, golden: &args.golden, failures: &args.failures }, mode)?;
    drop(progress);
    if args.json {
        let text = serde_json::to_string_pretty(&report).expect("a golden report holds only strings and numbers");
        output::stdout(&format!("{text}\n"))?;
    } else {
        output::stdout(&format!("{report}\n"))?;
    }
    Ok(if report.passed() { Outcome::Done } else { Outcome::Unmet })
}

/// Holds every case against its golden.
///
/// # Errors
/// As [`golden::run`].
pub fn check(folders: &Folders<'_>, mode: Mode) -> Result<GoldenReport, Error> {
    let render = |path: &Path| {
        let scene = scene::load(path)?;
        let (picture, record) = record(&scene)?;
        if scene.effects.is_random() {
            return Ok(GoldenOutput::of_random(&redrawn(&scene, REPLICATES)?, record));
        }
        Ok(GoldenOutput { picture, record, noise: None })
    };
    golden::run(folders, mode, &tolerance, &render)
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
