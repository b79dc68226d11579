//! Output helpers: data to stdout, words to stderr, and no panic when either is closed or full.

use crate::error::Error;
use std::io::{ErrorKind, Write};

/// Writes data to stdout. A reader that has seen enough (`| head`) is no error.
pub(super) fn stdout(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::new("stdout", format!("cannot be written: {error}"), "check where the output goes"))
        }
        _ => Ok(()),
    }
}

/// Says something to the person. Where stderr is closed, nobody listens, and that is no error.
pub(super) fn stderr(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}
