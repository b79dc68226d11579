//! A progress bar on a terminal, nothing in a pipe; and the time of each step.

use super::output;
use crate::progress::Observer;
use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How often the bar is drawn while nothing is heard.
const TICK: Duration = Duration::from_millis(200);

/// The bar and the clock of one job.
pub(super) struct Progress {
    bar: ProgressBar,
    clock: Arc<Mutex<Clock>>,
    /// What is worked on at once, with the stage of each.
    running: Mutex<BTreeMap<String, &'static str>>,
}

/// The stage that runs, and the seconds of those that have ended.
#[derive(Default)]
struct Clock {
    /// What it works on.
    what: String,
    started: Option<(&'static str, Instant)>,
    seconds: BTreeMap<String, f64>,
}

/// What hears of the stages and pixels of work on one thing.
pub(super) struct Watch<'a> {
    progress: &'a Progress,
    what: &'a str,
    clock: Arc<Mutex<Clock>>,
}

impl Watch<'_> {
    /// Seconds by stage since the last call; the work ends, or goes on with another stage.
    pub(super) fn take_seconds(&self) -> BTreeMap<String, f64> {
        self.progress.running().remove(self.what);
        self.progress.take_seconds_of(&self.clock)
    }
}

impl Observer for Watch<'_> {
    fn stage(&self, name: &'static str) {
        self.progress.begin_of(&self.clock, self.what, name);
    }

    fn stage_of(&self, name: &'static str, steps: usize) {
        self.progress.bar.set_style(style(Some("")));
        self.progress.bar.set_length(steps as u64);
        self.progress.bar.reset();
        self.stage(name);
    }

    fn pixels(&self, count: usize) {
        self.progress.bar.inc(count as u64);
    }
}

impl Progress {
    /// A bar for `total` pixels. It is drawn on stderr and only on a terminal.
    pub(super) fn new(total: u64) -> Self {
        let bar = if output::is_quiet() { ProgressBar::hidden() } else { ProgressBar::new(total) };
        bar.set_style(style(if total > 0 { Some("px") } else { None }));
        if !bar.is_hidden() {
            bar.enable_steady_tick(TICK);
        }
        Self { bar, clock: Arc::default(), running: Mutex::default() }
    }

    /// One that draws nothing.
    pub(super) fn silent() -> Self {
        Self { bar: ProgressBar::hidden(), clock: Arc::default(), running: Mutex::default() }
    }

    /// What hears of the work on `what`, from any thread.
    pub(super) fn watch<'a>(&'a self, what: &'a str) -> Watch<'a> {
        Watch { progress: self, what, clock: Arc::clone(&self.clock) }
    }

    /// The same of work that goes on beside other work, with a clock of its own.
    pub(super) fn watch_beside<'a>(&'a self, what: &'a str) -> Watch<'a> {
        Watch { progress: self, what, clock: Arc::default() }
    }

    /// The stage `name` begins, and the one before it ends.
    pub(super) fn begin(&self, what: &str, name: &'static str) {
        self.begin_of(&self.clock, what, name);
    }

    fn begin_of(&self, clock: &Mutex<Clock>, what: &str, name: &'static str) {
        let mut clock = locked(clock);
        self.tell(clock.end());
        let mut running = self.running();
        running.remove(&clock.what);
        running.insert(what.to_owned(), name);
        let told: Vec<String> = running.iter().map(|(what, name)| format!("{what}: {name}")).collect();
        self.bar.set_message(told.join(", "));
        clock.what = what.to_owned();
        clock.started = Some((name, Instant::now()));
    }

    /// Says how long a stage took, where the person wants to know.
    fn tell(&self, ended: Option<(String, f64)>) {
        if let Some((stage, seconds)) = ended.filter(|_| output::is_verbose()) {
            self.bar.suspend(|| output::stderr(&format!("{stage}: {seconds:.3} s")));
        }
    }

    /// Seconds by stage since the last call.
    pub(super) fn take_seconds(&self) -> BTreeMap<String, f64> {
        self.take_seconds_of(&self.clock)
    }

    fn take_seconds_of(&self, clock: &Mutex<Clock>) -> BTreeMap<String, f64> {
        let mut clock = locked(clock);
        self.tell(clock.end());
        std::mem::take(&mut clock.seconds)
    }

    fn running(&self) -> MutexGuard<'_, BTreeMap<String, &'static str>> {
        locked(&self.running)
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Clock {
    /// Ends the stage that runs: its name, and its seconds.
    fn end(&mut self) -> Option<(String, f64)> {
        let (name, at) = self.started.take()?;
        let seconds = at.elapsed().as_secs_f64();
        *self.seconds.entry(name.to_owned()).or_insert(0.0) += seconds;
        Some((format!("{}: {name}", self.what), seconds))
    }
}

/// The looks of a bar that counts in `unit`, with its rate and the time left; without one, of work whose end is not known.
fn style(unit: Option<&'static str>) -> ProgressStyle {
    let template = match unit {
        Some(_) => "{msg:28} {wide_bar} {percent:>3} %  {rate}  {eta} left",
        None => "{spinner} {msg:28} {elapsed}",
    };
    let rate = move |state: &ProgressState, out: &mut dyn std::fmt::Write| {
        let per_s = state.per_sec();
        let _ = match unit {
            Some("px") => write!(out, "{:.1} Mpx/s", per_s / 1e6),
            _ => write!(out, "{per_s:.1}/s"),
        };
    };
    ProgressStyle::with_template(template).expect("the template is well formed").with_key("rate", rate)
}

impl Drop for Progress {
    fn drop(&mut self) {
        let ended = locked(&self.clock).end();
        self.tell(ended);
        self.bar.finish_and_clear();
    }
}
