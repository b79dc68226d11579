//! Output helpers: data to stdout, words to stderr, and no panic when either is closed or full.

use crate::error::{Error, printable};
use std::io::{ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether stdout was closed when the command began: by then the system library has put a device in its place that swallows
/// everything.
static CLOSED: AtomicBool = AtomicBool::new(false);

/// Notes that nobody can read what is written to stdout.
pub(super) fn stdout_is_closed() {
    CLOSED.store(true, Ordering::Relaxed);
}

/// Writes data to stdout. A reader that has seen enough (`| head`) is no error.
pub(super) fn stdout(text: &str) -> Result<(), Error> {
    if CLOSED.load(Ordering::Relaxed) && !text.is_empty() {
        return Err(Error::new("stdout", "it is closed, and the data is lost", "say where the output goes"));
    }
    let mut out = std::io::stdout().lock();
    match out.write_all(printable(text).as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::new("stdout", format!("cannot be written: {error}"), "check where the output goes"))
        }
        _ => Ok(()),
    }
}

/// Says something to the person. Where stderr is closed, nobody listens, and that is no error.
pub(super) fn stderr(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}", printable(text));
}

/// Says what is wrong. Where stderr is closed, nobody listens, and that is no error.
pub(super) fn complain(problem: &Error) {
    use std::io::IsTerminal;
    let mut err = std::io::stderr();
    let colour = err.is_terminal();
    let _ = writeln!(err, "{}", problem.render(colour));
}
