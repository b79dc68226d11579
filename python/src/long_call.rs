//! Calls that may take long: the lock of the interpreter is released, and Ctrl-C ends them.

use crate::failure::failure;
use biprism::Error;
use biprism::progress::Observer;
use pyo3::exceptions::PyRuntimeError;
use pyo3::panic::PanicException;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread::Builder;
use std::time::Duration;

/// How long the interpreter hears nothing of its signals.
const POLL: Duration = Duration::from_millis(20);

/// Ends the work that it observes once nobody waits for it any more.
pub(crate) struct Stopper(Arc<AtomicBool>);

/// What work is ended with.
struct Stopped;

impl Stopper {
    fn look(&self) {
        if self.0.load(Ordering::Relaxed) {
            // Goes through all threads that work, without a word: nobody waits.
            resume_unwind(Box::new(Stopped));
        }
    }
}

impl Observer for Stopper {
    fn stage(&self, _: &'static str) {
        self.look();
    }
    fn stage_of(&self, _: &'static str, _: usize) {
        self.look();
    }
    fn pixels(&self, _: usize) {
        self.look();
    }
}

/// What `work` makes, on threads of its own, while the interpreter goes on. Where a signal raises, that is raised at once, and the work
/// ends when its observer is told next; its designs and studies of rays tell it nothing, and end by themselves.
pub(crate) fn long_call<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Stopper) -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    not_forked()?;
    aside(py, work)
}

/// The same of work that needs no threads but its own, and so goes on in a process that was forked.
pub(crate) fn aside<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Stopper) -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    let stopped = Arc::new(AtomicBool::new(false));
    let stopper = Stopper(Arc::clone(&stopped));
    let (tell, mut told) = sync_channel(1);
    let job = move || {
        // Where nobody waits any more, nobody hears how it ended.
        let _ = tell.send(catch_unwind(AssertUnwindSafe(|| work(&stopper))));
    };
    Builder::new()
        .name("biprism".to_owned())
        .spawn(job)
        .map_err(|error| PyRuntimeError::new_err(format!("no thread can be made: {error}")))?;
    loop {
        let (heard, back) = py.detach(move || (told.recv_timeout(POLL), told));
        told = back;
        match heard {
            Ok(Ok(made)) => return made.map_err(|error| failure(py, &error)),
            Ok(Err(panic)) => return Err(PanicException::new_err(words(panic.as_ref()))),
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals().inspect_err(|_| stopped.store(true, Ordering::Relaxed))?
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("the work ended without a word"));
            }
        }
    }
}

/// Refuses work in a process that was forked from one that has worked: its threads are not there, and it would wait for ever.
fn not_forked() -> PyResult<()> {
    static PROCESS: OnceLock<u32> = OnceLock::new();
    if *PROCESS.get_or_init(std::process::id) == std::process::id() {
        return Ok(());
    }
    Err(PyRuntimeError::new_err(
        "this process was forked from one in which biprism has worked, and has none of its threads: start processes anew, by \
         multiprocessing.set_start_method(\"spawn\")",
    ))
}

fn words(panic: &(dyn Any + Send)) -> String {
    let word = panic.downcast_ref::<&str>().map(|word| (*word).to_owned());
    word.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "the program failed".to_owned())
}
