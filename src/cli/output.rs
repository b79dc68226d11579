//! Data to stdout, words to stderr, and no panic when either is closed or full.

use crate::error::Problem;
use std::io::{ErrorKind, Write};

/// Writes data to stdout. A reader that has seen enough (`| head`) is no error.
pub(super) fn data(text: &str) -> Result<(), Problem> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Problem::new("stdout", format!("cannot be written: {error}"), "check where the output goes"))
        }
        _ => Ok(()),
    }
}

/// Says something to the person. Where stderr is closed, nobody listens, and that is no error.
pub(super) fn words(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}
