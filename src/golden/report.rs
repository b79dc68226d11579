//! The report of a golden run: how each case went.

use super::noise::{self, Regions};
use super::record::{RecordDifference, Tolerance};
use crate::error::Error;
use crate::raster::Raster;
use crate::raster::compare::Difference;
use serde::Serialize;
use serde_json::Value;
use std::fmt;
use std::path::Path;

/// What a case gives.
#[derive(Debug, Clone, PartialEq)]
pub struct GoldenOutput {
    /// Linear light in [0, 1]: the picture, or the mean of random ones.
    pub picture: Raster<f32>,
    /// Corners, residuals, fates, counts: nothing that changes from run to run.
    pub record: Value,
    /// What the pictures of a case with random effects are like.
    pub noise: Option<Regions>,
}

impl GoldenOutput {
    /// The output of a case that is drawn at random, from the pictures of its frames (at least three) and the one without
    /// noise.
    pub(crate) fn of_random(pictures: &[Raster<f32>], quiet: &Raster<f32>, record: Value) -> Self {
        Self { picture: noise::mean_picture(pictures), record, noise: Some(Regions::of(pictures, quiet)) }
    }
}

/// How far a case may be from its golden.
#[derive(Clone, Copy)]
pub struct Tolerances<'a> {
    /// For each leaf of a record, by its JSON pointer.
    pub record: &'a dyn Fn(&str) -> Tolerance,
    /// For a pixel, in linear light of full scale 1.
    pub grey: f64,
}

impl fmt::Debug for Tolerances<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tolerances").field("grey", &self.grey).finish_non_exhaustive()
    }
}

/// Where things are.
#[derive(Debug, Clone, Copy)]
pub struct Folders<'a> {
    /// The cases, `*.toml`.
    pub cases: &'a Path,
    /// Their goldens.
    pub golden: &'a Path,
    /// What failing cases leave behind; created when needed.
    pub failures: &'a Path,
}

/// Whether goldens are only checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Goldens are read only.
    Check,
    /// The goldens of failing cases are written anew, all others are left as they are.
    Update,
}

impl Mode {
    /// The mode by the values of the variables `UPDATE_GOLDEN` and `CI`.
    ///
    /// # Errors
    /// A value of `UPDATE_GOLDEN` other than 0 and 1, and an update where `CI` is set: there, nobody reviews it.
    pub fn of_variables(update: Option<&str>, ci: Option<&str>) -> Result<Self, Error> {
        match (update, ci.is_some_and(|value| !value.is_empty())) {
            (None | Some("" | "0"), _) => Ok(Self::Check),
            (Some("1"), false) => Ok(Self::Update),
            (Some("1"), true) => Err(Error::new(
                "UPDATE_GOLDEN",
                "goldens are not rewritten where CI is set",
                "run it on your own machine, look at the pictures, and commit them",
            )),
            (Some(other), _) => {
                Err(Error::new("UPDATE_GOLDEN", format!("the value is {other:?}, and must be 0 or 1"), "set it to 1"))
            }
        }
    }
}

impl Mode {
    /// [`Mode::Update`], for cases that are named, by the value of the variable `CI`.
    ///
    /// # Errors
    /// Where `CI` is set.
    pub(crate) fn of_named(ci: Option<&str>) -> Result<Self, Error> {
        match Self::of_variables(Some("1"), ci) {
            Err(problem) => Err(Error { place: "--bless".to_owned(), ..problem }),
            mode => mode,
        }
    }
}

/// How it went with one case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GoldenOutcome {
    /// As its golden.
    Passed,
    /// Not as its golden, or without one.
    Failed,
    /// It failed, and its golden was written anew.
    Updated,
}

/// The judgement of one case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseResult {
    /// Its name, without an ending.
    pub name: String,
    /// How it went.
    pub outcome: GoldenOutcome,
    /// Why it failed, one sentence each.
    pub reasons: Vec<String>,
    /// How far the picture is from its golden, where both are there and of one size.
    pub picture: Option<Difference>,
    /// How far the record is from its golden, where both are there.
    pub record: Option<RecordDifference>,
}

/// The judgement of all cases.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GoldenReport {
    /// One entry a case, by name.
    pub cases: Vec<CaseResult>,
    /// Golden files without a case.
    pub orphans: Vec<String>,
    /// Why no case was rendered: there is no folder of goldens to hold them against.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missing: Option<String>,
}

impl GoldenReport {
    /// Whether there are goldens, no case failed, and no golden is left over.
    pub fn passed(&self) -> bool {
        self.missing.is_none()
            && self.orphans.is_empty()
            && self.cases.iter().all(|case| case.outcome != GoldenOutcome::Failed)
    }
}

impl fmt::Display for GoldenReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(missing) = &self.missing {
            return write!(f, "FAILED {missing}");
        }
        for case in self.cases.iter().filter(|case| case.outcome != GoldenOutcome::Passed) {
            let word = if case.outcome == GoldenOutcome::Updated { "updated" } else { "FAILED" };
            writeln!(f, "{word} {}", case.name)?;
            for reason in &case.reasons {
                writeln!(f, "    {reason}")?;
            }
        }
        for orphan in &self.orphans {
            writeln!(f, "FAILED {orphan}\n    no case has this golden: delete it, or bring its case back")?;
        }
        let count = |outcome| self.cases.iter().filter(|case| case.outcome == outcome).count();
        write!(
            f,
            "{} cases: {} passed, {} failed, {} updated; {} goldens without a case",
            self.cases.len(),
            count(GoldenOutcome::Passed),
            count(GoldenOutcome::Failed),
            count(GoldenOutcome::Updated),
            self.orphans.len()
        )
    }
}
