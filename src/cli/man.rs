//! `biprism man`: the pages of the manual, a page a verb.

use super::args::Args;
use super::outcome::Outcome;
use super::shell_args::ManArgs;
use super::{files, output};
use crate::error::Error;
use clap::{Command, CommandFactory};
use clap_mangen::Man;

pub(super) fn run(args: &ManArgs) -> Result<Outcome, Error> {
    let mut command = Args::command().long_version(env!("CARGO_PKG_VERSION")).disable_help_subcommand(true);
    command.build();
    let Some(folder) = &args.out else {
        output::stdout(&page(command)?.1)?;
        return Ok(Outcome::Done);
    };
    let mut pages = Vec::new();
    collect(command, &mut pages)?;
    let names: Vec<&str> = pages.iter().map(|(name, _)| name.as_str()).collect();
    let paths = files::outputs(folder, &names)?;
    for (path, (_, text)) in paths.iter().zip(&pages) {
        files::text(path, text)?;
    }
    output::stderr(&format!("wrote {} pages into {}", paths.len(), folder.display()));
    Ok(Outcome::Done)
}

/// The pages of a command and of all below it.
fn collect(command: Command, pages: &mut Vec<(String, String)>) -> Result<(), Error> {
    for below in command.get_subcommands() {
        collect(below.clone(), pages)?;
    }
    pages.push(page(command)?);
    Ok(())
}

/// The name of a page's file, and its text.
fn page(command: Command) -> Result<(String, String), Error> {
    let (man, mut text) = (Man::new(command), Vec::new());
    let unwritten = |e: std::io::Error| Error::new("the manual", e.to_string(), "use `biprism help`");
    man.render(&mut text).map_err(unwritten)?;
    Ok((man.get_filename(), String::from_utf8_lossy(&text).into_owned()))
}
