//! The command `biprism`.

use std::process::ExitCode;

fn main() -> ExitCode {
    biprism::cli::run()
}
