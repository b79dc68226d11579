//! The arguments of `completions` and `man`.

use clap_complete::Shell;
use std::path::PathBuf;

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// The shell.
    pub shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub struct ManArgs {
    /// Folder for a page a verb, biprism.1, biprism-compare.1 and so on, in place of biprism.1 on stdout.
    #[arg(long)]
    pub out: Option<PathBuf>,
}
