//! The command `biprism`.

use biprism::cli::{self, Started};
use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs the command of these words, of which the first is its name, and gives its exit code. A process does this once.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, words: Vec<OsString>, stdout_is_open: bool) -> u8 {
    py.detach(|| cli::run(words, Started { stdout_is_open }))
}
