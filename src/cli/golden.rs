//! `biprism golden`: regression tests of pictures and corners, for this project's own cases and for a user's.

use super::args::GoldenArgs;
use super::outcome::Outcome;
use super::output;
use super::progress::Progress;
use crate::error::Error;
use crate::golden::{Folders, GoldenRequest, Mode, check_asked};

pub(super) fn run(args: &GoldenArgs) -> Result<Outcome, Error> {
    let variable = |name: &str| std::env::var(name).ok();
    let ci = variable("CI");
    let mode = match args.bless.is_empty() {
        true => Mode::of_variables(variable("UPDATE_GOLDEN").as_deref(), ci.as_deref())?,
        false => Mode::of_named(ci.as_deref())?,
    };
    let request = GoldenRequest {
        only: if args.bless.is_empty() { args.only.clone() } else { args.bless.clone() },
        slack_px: args.tolerance_px,
        slack_grey: args.tolerance_grey,
    };
    let progress = Progress::new(0);
    progress.begin("golden", "cases");
    let report =
        check_asked(&Folders { cases: &args.cases, golden: &args.golden, failures: &args.failures }, mode, &request)?;
    drop(progress);
    if args.json {
        let text = serde_json::to_string_pretty(&report).expect("a golden report holds only strings and numbers");
        output::stdout(&format!("{text}\n"))?;
    } else {
        output::stdout(&format!("{report}\n"))?;
    }
    if !report.passed() {
        output::unmet("some cases are not as their goldens have them");
    }
    Ok(if report.passed() { Outcome::Done } else { Outcome::Unmet })
}
