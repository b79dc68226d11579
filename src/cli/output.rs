//! Output helpers: data to stdout, words to stderr, and no panic when either is closed or full.

use super::args::{ColorArg, WordsArgs};
use crate::error::{Error, printable};
use clap::ColorChoice;
use std::ffi::OsString;
use std::io::{ErrorKind, Write};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

/// Whether stdout was closed when the command began: by then the system library has put a device in its place that swallows
/// everything.
static CLOSED: AtomicBool = AtomicBool::new(false);

/// Notes that nobody can read what is written to stdout.
pub(super) fn stdout_is_closed() {
    CLOSED.store(true, Ordering::Relaxed);
}

/// Writes data to stdout. A reader that has seen enough (`| head`) is no error.
pub(super) fn stdout(text: &str) -> Result<(), Error> {
    numbers(&printable(text))
}

/// The same of text that holds nothing which a terminal obeys.
pub(super) fn numbers(text: &str) -> Result<(), Error> {
    if CLOSED.load(Ordering::Relaxed) && !text.is_empty() {
        return Err(Error::new("stdout", "it is closed, and the data is lost", "say where the output goes"));
    }
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::new("stdout", format!("cannot be written: {error}"), "check where the output goes"))
        }
        _ => Ok(()),
    }
}

/// How much is said on stderr.
static LOUDNESS: AtomicU8 = AtomicU8::new(USUAL);
const QUIET: u8 = 0;
const USUAL: u8 = 1;
const VERBOSE: u8 = 2;

/// Whether errors have colours where `--color` says so; otherwise by what stderr is.
static COLOR: AtomicU8 = AtomicU8::new(ColorArg::Auto as u8);

/// Takes how much is to be said, and in which colours.
pub(super) fn set_up(words: WordsArgs) {
    let loudness = match words {
        WordsArgs { quiet: true, .. } => QUIET,
        WordsArgs { verbose: true, .. } => VERBOSE,
        _ => USUAL,
    };
    LOUDNESS.store(loudness, Ordering::Relaxed);
    COLOR.store(words.color as u8, Ordering::Relaxed);
}

/// The colours of help and of wrong arguments, which are told before the arguments are known.
pub(super) fn color_of_help(words: &[OsString]) -> ColorChoice {
    let words: Vec<String> = words.iter().map(|word| word.to_string_lossy().into_owned()).collect();
    let after = words.iter().position(|word| word == "--color").and_then(|at| words.get(at + 1));
    let joined = words.iter().find_map(|word| word.strip_prefix("--color="));
    match after.map(String::as_str).or(joined) {
        Some("always") => ColorChoice::Always,
        Some("never") => ColorChoice::Never,
        _ => ColorChoice::Auto,
    }
}

/// Says something to the person, unless they want quiet. Where stderr is closed, nobody listens, and that is no error.
pub(super) fn stderr(text: &str) {
    if LOUDNESS.load(Ordering::Relaxed) != QUIET {
        unmet(text);
    }
}

/// Says why the exit code is 1, in any case.
pub(super) fn unmet(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}", printable(text));
}

/// Whether the person wants to know how long each stage took.
pub(super) fn is_verbose() -> bool {
    LOUDNESS.load(Ordering::Relaxed) == VERBOSE
}

/// Whether progress is shown.
pub(super) fn is_quiet() -> bool {
    LOUDNESS.load(Ordering::Relaxed) == QUIET
}

/// Says what is wrong. Where stderr is closed, nobody listens, and that is no error.
pub(super) fn complain(problem: &Error) {
    use std::io::IsTerminal;
    let mut err = std::io::stderr();
    let colour = match COLOR.load(Ordering::Relaxed) {
        always if always == ColorArg::Always as u8 => true,
        never if never == ColorArg::Never as u8 => false,
        _ => err.is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()),
    };
    let _ = writeln!(err, "{}", problem.render(colour));
}
