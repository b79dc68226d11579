//! `biprism golden`: regression tests of pictures and corners, for this project's own cases and for a user's.

use super::args::GoldenArgs;
use super::outcome::Outcome;
use super::output;
use super::progress::Progress;
use crate::error::Error;
use crate::golden::{Folders, Mode, check};

pub(super) fn run(args: &GoldenArgs) -> Result<Outcome, Error> {
    let variable = |name: &str| std::env::var(name).ok();
    let mode = Mode::of_variables(variable("UPDATE_GOLDEN").as_deref(), variable("CI").as_deref())?;
    let progress = Progress::new(0);
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
