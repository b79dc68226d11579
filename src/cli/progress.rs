//! A progress bar on a terminal, nothing in a pipe; and the time of each step.

use crate::progress::Observer;
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// The bar and the clock of one job.
pub(super) struct Progress {
    bar: ProgressBar,
    clock: Mutex<Clock>,
}

/// The stage that runs, and the seconds of those that have ended.
#[derive(Default)]
struct Clock {
    started: Option<(&'static str, Instant)>,
    seconds: BTreeMap<String, f64>,
}

/// What hears of the stages and pixels of work on one thing.
pub(super) struct Watch<'a> {
    progress: &'a Progress,
    what: &'a str,
}

impl Observer for Watch<'_> {
    fn stage(&self, name: &'static str) {
        self.progress.begin(self.what, name);
    }

    fn stage_of(&self, name: &'static str, steps: usize) {
        self.progress.bar.set_length(steps as u64);
        self.progress.bar.set_position(0);
        self.progress.begin(self.what, name);
    }

    fn pixels(&self, count: usize) {
        self.progress.bar.inc(count as u64);
    }
}

impl Progress {
    /// A bar for `total` pixels. It is drawn on stderr and only on a terminal.
    pub(super) fn new(total: u64) -> Self {
        let bar = ProgressBar::new(total);
        let style = ProgressStyle::with_template("{msg:28} {wide_bar} {percent:>3} %");
        bar.set_style(style.expect("the template is well formed"));
        Self { bar, clock: Mutex::default() }
    }

    /// What hears of the work on `what`, from any thread.
    pub(super) fn watch<'a>(&'a self, what: &'a str) -> Watch<'a> {
        Watch { progress: self, what }
    }

    /// The stage `name` begins, and the one before it ends.
    pub(super) fn begin(&self, what: &str, name: &'static str) {
        let mut clock = self.clock();
        clock.end();
        self.bar.set_message(format!("{what}: {name}"));
        clock.started = Some((name, Instant::now()));
    }

    /// Seconds by stage since the last call.
    pub(super) fn take_seconds(&self) -> BTreeMap<String, f64> {
        let mut clock = self.clock();
        clock.end();
        std::mem::take(&mut clock.seconds)
    }

    fn clock(&self) -> MutexGuard<'_, Clock> {
        self.clock.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Clock {
    fn end(&mut self) {
        if let Some((name, at)) = self.started.take() {
            *self.seconds.entry(name.to_owned()).or_insert(0.0) += at.elapsed().as_secs_f64();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
