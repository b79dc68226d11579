//! A progress bar on a terminal, nothing in a pipe; and the time of each step.

use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::time::Instant;

/// The bar and the clock of one job.
pub(super) struct Progress {
    bar: ProgressBar,
    started: Option<(&'static str, Instant)>,
    seconds: BTreeMap<String, f64>,
}

impl Progress {
    /// A bar for `total` pixels. It is drawn on stderr and only on a terminal.
    pub(super) fn new(total: u64) -> Self {
        let bar = ProgressBar::new(total);
        let style = ProgressStyle::with_template("{msg:28} {wide_bar} {percent:>3} %");
        bar.set_style(style.expect("the template is well formed"));
        Self { bar, started: None, seconds: BTreeMap::new() }
    }

    /// A handle that may be told of pixels done, from any thread.
    pub(super) fn handle(&self) -> impl Fn(usize) + Sync + use<> {
        let bar = self.bar.clone();
        move |pixels| bar.inc(pixels as u64)
    }

    /// The step `name` begins, and the one before it ends.
    pub(super) fn begin(&mut self, what: &str, name: &'static str) {
        self.end();
        self.bar.set_message(format!("{what}: {name}"));
        self.started = Some((name, Instant::now()));
    }

    /// The step `name` of `total` parts begins, with the bar at its start.
    pub(super) fn begin_anew(&mut self, what: &str, name: &'static str, total: usize) {
        self.bar.set_length(total as u64);
        self.bar.set_position(0);
        self.begin(what, name);
    }

    fn end(&mut self) {
        if let Some((name, at)) = self.started.take() {
            *self.seconds.entry(name.to_owned()).or_insert(0.0) += at.elapsed().as_secs_f64();
        }
    }

    /// Seconds by step since the last call.
    pub(super) fn take_seconds(&mut self) -> BTreeMap<String, f64> {
        self.end();
        std::mem::take(&mut self.seconds)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
