//! A run over the cases, or over some, with the tolerances that are asked for.

use super::cases::{PIXEL_TOLERANCE, case_names, orphans, run_case};
use super::record::Tolerance;
use super::report::{Folders, GoldenOutput, GoldenReport, Mode, Tolerances};
use crate::error::Error;
use std::collections::BTreeSet;
use std::path::Path;

/// What is asked of a run besides.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GoldenRequest {
    /// The cases to render, all where there is none.
    pub only: Vec<String>,
    /// How far a point in the image and a residual may move more than usual, in px. Where they may, the work of a picture and
    /// the reasons of candidates that were turned down are not held: they follow the smallest moves.
    pub slack_px: f64,
    /// How far a pixel may move more than usual, in linear light of full scale 1; those of random pictures are judged by
    /// their noise.
    pub slack_grey: f64,
}

impl GoldenRequest {
    /// The cases of `names` that are meant.
    ///
    /// # Errors
    /// A case that there is not.
    fn chosen(&self, folders: &Folders<'_>, names: BTreeSet<String>) -> Result<BTreeSet<String>, Error> {
        if self.only.is_empty() {
            return Ok(names);
        }
        let known = |name: &String| {
            let stem = name.strip_suffix(".toml").unwrap_or(name);
            names.get(stem).cloned().ok_or_else(|| {
                let rule = format!("there is no case {stem:?} in {}", folders.cases.display());
                let all: Vec<&str> = names.iter().map(String::as_str).collect();
                Error::new("the name of a case", rule, format!("name one of {}", all.join(", ")))
            })
        };
        self.only.iter().map(known).collect()
    }

    /// A leaf's tolerance with what is allowed more.
    fn widened(&self, pointer: &str, usual: Tolerance) -> Tolerance {
        let follows = ["/counts/", "/rejected/"].iter().any(|part| pointer.contains(part));
        match usual {
            Tolerance::Px(px) => Tolerance::Px(px + self.slack_px),
            // Residuals are in px.
            Tolerance::Number(value) => Tolerance::Number(value + self.slack_px),
            Tolerance::Exact if self.slack_px > 0.0 && follows => Tolerance::Any,
            same => same,
        }
    }
}

/// Renders the cases that are asked for and holds each against its golden.
///
/// `render` is given the path of a case; `tolerance` says for each leaf of a record, by its JSON pointer, how far it
/// may move. Golden files without a case are looked for where all cases are rendered.
///
/// # Errors
/// A folder that cannot be read or holds no case, a case that there is not, and files that cannot be written. What is wrong
/// with a case is in the report.
pub fn run(
    folders: &Folders<'_>,
    mode: Mode,
    request: &GoldenRequest,
    tolerance: &dyn Fn(&str) -> Tolerance,
    render: &dyn Fn(&Path) -> Result<GoldenOutput, Error>,
) -> Result<GoldenReport, Error> {
    let names = request.chosen(folders, case_names(folders)?)?;
    if mode == Mode::Check && !folders.golden.exists() {
        let (golden, cases, n) = (folders.golden.display(), folders.cases.display(), names.len());
        let missing = format!(
            "{golden}: there is no such folder of goldens for the {n} cases of {cases}\n    name it with --golden; or, if this \
             is the first run, make them all: UPDATE_GOLDEN=1 biprism golden {cases} --golden {golden}\n    then look at the \
             pictures in {golden}, and commit them"
        );
        return Ok(GoldenReport { cases: vec![], orphans: vec![], missing: Some(missing) });
    }
    let record = |pointer: &str| request.widened(pointer, tolerance(pointer));
    let tolerances = Tolerances { record: &record, grey: PIXEL_TOLERANCE + request.slack_grey };
    let cases =
        names.iter().map(|name| run_case(folders, mode, &tolerances, render, name)).collect::<Result<_, _>>()?;
    let orphans = if request.only.is_empty() { orphans(folders)? } else { vec![] };
    Ok(GoldenReport { cases, orphans, missing: None })
}
