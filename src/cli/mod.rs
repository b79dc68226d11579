//! The command: arguments, one file per verb.
//!
//! Exit codes: 0 done, 1 ran but something that was asked for is not so (a claim of the scene's `[[expect]]`, a golden, a
//! target accuracy, a bound of the stability study), 2 could not run.
//! Data goes to stdout, words to stderr.

mod accuracy;
mod analyse;
pub mod args;
pub mod compare_args;
pub mod design_args;
pub mod new_args;
pub mod prisms_args;
pub mod dataset_args;
pub mod rectify_args;
pub mod set_args;
pub mod export_args;
pub mod shell_args;
pub mod study_args;
pub mod tolerance_args;
pub mod batch;
pub mod batch_args;
mod check;
mod plan;
mod picture_time;
mod threads;
mod compare;
mod corners;
mod cost;
mod dataset;
mod field_lines;
mod appended;
mod design;
mod expect;
mod export;
mod examples;
mod build_facts;
mod completions;
mod man;
mod files;
mod golden;
mod light;
mod machine;
mod measure;
mod new;
mod progress;
mod rectify;
mod render;
mod study;
mod trace;
mod output;
mod origin;
mod outcome;

use crate::error::{Error, printable};
use crate::io::inputs;
use args::{Args, Verb};
use clap::{CommandFactory, FromArgMatches};
use outcome::Outcome;
use std::borrow::Cow;
use std::ffi::OsString;
use tolerance_args::MergeArgs;

/// What [`run`] is told of how the command was started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Started {
    /// Whether somebody holds the other end of stdout.
    pub stdout_is_open: bool,
}

/// The exit code of a command that could not run.
const FAILED: u8 = 2;

/// Parses the arguments, of which the first is the command's own name, runs the verb and gives the exit code. A process does this
/// once: threads, loudness and the files that were read are kept for all of it.
pub fn run(words: Vec<OsString>, started: Started) -> u8 {
    let args = match arguments(&words) {
        Ok(args) => args,
        Err(code) => return code,
    };
    origin::note_words(&words);
    output::set_up(args.words);
    if !started.stdout_is_open {
        output::stdout_is_closed();
    }
    inputs::watch();
    match threads::set_up(args.threads.map(usize::from)).and_then(|()| verb(args)) {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Unmet) => 1,
        Err(problem) => {
            output::complain(&problem);
            FAILED
        }
    }
}

/// The arguments, or the exit code where they are told to be wrong or help was asked for.
fn arguments(words: &[OsString]) -> Result<Args, u8> {
    let parsed = Args::command().color(output::color_of_help(words)).try_get_matches_from(words);
    parsed.and_then(|matches| Args::from_arg_matches(&matches)).map_err(|error| {
        let obeyed = |word: &OsString| matches!(printable(&word.to_string_lossy()), Cow::Owned(_));
        if words.iter().any(obeyed) {
            // The library would hand them on to the terminal.
            output::stderr(&error.render().to_string());
            return FAILED;
        }
        // Where nobody listens, that is no error.
        let _ = error.print();
        u8::try_from(error.exit_code()).unwrap_or(FAILED)
    })
}

/// Makes one of the parts of a run, of whichever kind they are.
fn merge(args: &MergeArgs) -> Result<Outcome, Error> {
    let mut is_batch = false;
    for path in &args.files {
        is_batch |= batch::is_batch(path)?;
    }
    if is_batch { batch::join(args) } else { study::tolerance::merge(args) }
}

fn verb(args: Args) -> Result<Outcome, Error> {
    match args.verb.unwrap_or_else(Verb::main_job) {
        Verb::Compare(args) => compare::run(&args),
        Verb::New(args) => new::run(&args),
        Verb::Render(args) => render::run(&args),
        Verb::Corners(args) => corners::run(&args),
        Verb::Measure(args) => measure::run(&args),
        Verb::Design(args) => design::run(&args),
        Verb::Check(args) => check::run(&args),
        Verb::Trace(args) => trace::run(&args),
        Verb::Rectify(args) => rectify::run(&args),
        Verb::Export(args) => export::run(&args),
        Verb::Dataset(args) => dataset::run(&args),
        Verb::Analyse(args) => analyse::run(&args),
        Verb::Batch(args) => batch::run(&args),
        Verb::Merge(args) => merge(&args),
        Verb::Cost(args) => cost::run(&args),
        Verb::Golden(args) => golden::run(&args),
        Verb::Completions(args) => completions::run(&args),
        Verb::Man(args) => man::run(&args),
    }
}
