//! The threads of the command, made before any work.

use super::args::MOST_THREADS;
use super::output;
use crate::error::Error;
use std::sync::Mutex;
use std::sync::mpsc::channel;
use std::thread::{Builder, scope};

/// Threads that are left for the writing of files and the like.
pub(super) const SPARE_THREADS: usize = 4;
/// Address space of a thread: its stack, and what it works with.
const BYTES_A_THREAD: usize = 16 << 20;
/// Address space that a thread begins with: twice its stack.
const BYTES_TO_BEGIN: usize = 4 << 20;

/// Makes `stated` threads, or as many as `RAYON_NUM_THREADS` asks for, or as there are processors: at most [`MOST_THREADS`], and fewer
/// where the system gives no more.
///
/// # Errors
/// Not even one can be made.
pub(super) fn set_up(stated: Option<usize>) -> Result<(), Error> {
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|n| n.parse::<usize>().ok()).filter(|n| *n > 0);
    let wanted = stated.or(asked).unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    if wanted > MOST_THREADS && stated.or(asked).is_some() {
        output::stderr(&format!("note: RAYON_NUM_THREADS is {wanted}, and {MOST_THREADS} threads are the most"));
    }
    let room = free_address_space();
    let wanted = wanted.min(MOST_THREADS).min((room / BYTES_A_THREAD).max(1));
    let refused = |why: String| {
        let rule = format!("no thread can be made: {why}");
        Error::new(
            "this system",
            rule,
            "allow more processes (`ulimit -u`) or more memory (`ulimit -v`), or end others",
        )
    };
    let possible = possible_threads((wanted + SPARE_THREADS).min(room / BYTES_TO_BEGIN));
    // Where threads are short, so is memory: half of them leave some to work with.
    let threads = if possible == wanted + SPARE_THREADS { wanted } else { possible / 2 };
    if threads == 0 {
        return Err(refused(format!("it gives {possible}, and two are the fewest")));
    }
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(|error| refused(error.to_string()))
}

/// How many bytes the limit of the address space leaves, where there is one: at its very end the C library ends the program
/// without a sentence, so that it is not to be tried out.
fn free_address_space() -> usize {
    let number = |path: &str, key: &str| {
        let text = std::fs::read_to_string(path).ok()?;
        text.lines().find_map(|line| line.strip_prefix(key)?.split_whitespace().next()?.parse::<usize>().ok())
    };
    let Some(limit) = number("/proc/self/limits", "Max address space") else { return usize::MAX };
    let taken_kib = number("/proc/self/status", "VmSize:").unwrap_or(0);
    limit.saturating_sub(taken_kib * 1024)
}

/// How many threads of `wanted` can be there at a time.
fn possible_threads(wanted: usize) -> usize {
    let gate = Mutex::new(());
    let (started, heard) = channel();
    scope(|scope| {
        let shut = gate.lock();
        let mut made = 0;
        while made < wanted {
            let started = started.clone();
            let waiting = || {
                let started = started;
                let _ = started.send(());
                drop(gate.lock());
            };
            // The next one is made when this one has all the memory that it begins with.
            if Builder::new().spawn_scoped(scope, waiting).is_err() || heard.recv().is_err() {
                break;
            }
            made += 1;
        }
        drop(shut);
        made
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_counted_that_can_be_there_together() {
        assert_eq!(possible_threads(5), 5);
    }
}
