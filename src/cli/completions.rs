//! `biprism completions`: what a shell completes.

use super::args::Args;
use super::outcome::Outcome;
use super::output;
use super::shell_args::CompletionsArgs;
use crate::error::Error;
use clap::CommandFactory;

pub(super) fn run(args: &CompletionsArgs) -> Result<Outcome, Error> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Args::command(), "biprism", &mut script);
    output::stdout(&String::from_utf8_lossy(&script))?;
    Ok(Outcome::Done)
}
