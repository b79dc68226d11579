//! The command: arguments, one file per verb.
//!
//! Exit codes: 0 done, 1 ran but something that was asked for is not so (a claim of the scene's `[[expect]]`, a golden, a
//! target accuracy, a bound of the stability study), 2 could not run.
//! Data goes to stdout, words to stderr.

mod accuracy;
mod analyse;
pub mod args;
mod check;
mod plan;
mod compare;
mod corners;
mod cost;
mod design;
mod expect;
mod files;
mod golden;
mod machine;
mod measure;
mod progress;
mod render;
mod trace;
mod output;
mod outcome;

use crate::error::Error;
use args::{Args, Verb};
use clap::Parser;
use outcome::Outcome;
use std::io::IsTerminal;
use std::process::ExitCode;

/// Parses the arguments, runs the verb and says how it went.
pub fn run() -> ExitCode {
    let args = Args::parse();
    let outcome = match args.verb.unwrap_or_else(Verb::main_job) {
        Verb::Compare(args) => compare::run(&args),
        Verb::Render(args) => render::run(&args),
        Verb::Corners(args) => corners::run(&args),
        Verb::Measure(args) => measure::run(&args),
        Verb::Design(args) => design::run(&args),
        Verb::Check(args) => check::run(&args),
        Verb::Trace(args) => trace::run(&args),
        Verb::Analyse(args) => analyse::run(&args),
        Verb::Cost(args) => cost::run(&args),
        Verb::Golden(args) => golden::run(&args),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Unmet) => ExitCode::from(1),
        Err(problem) => {
            complain(&problem);
            ExitCode::from(2)
        }
    }
}

fn complain(problem: &Error) {
    output::stderr(&problem.render(std::io::stderr().is_terminal()));
}
