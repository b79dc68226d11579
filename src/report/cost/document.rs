//! A study of cost with what is needed to read it.

use crate::accuracy::Level;
use crate::analysis::cost::{CostStudy, Setting};
use serde::Serialize;

/// The machine on which times were taken.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Machine {
    /// The processor's name.
    pub processor: String,
    /// Threads that it runs at once.
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
    /// The widest vectors that were found: `AVX-512`, `AVX2` or `baseline`.
    pub vectors: &'static str,
}

impl std::fmt::Display for Machine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, {} threads, {}, {}", self.processor, self.threads, self.vectors, self.system)
    }
}

/// A study of cost with what is needed to read it.
#[derive(Debug, Clone, Serialize)]
pub struct CostReport<'a> {
    /// Always `biprism-cost/1`.
    pub schema: &'static str,
    /// The scene's name.
    pub scene: &'a str,
    /// Where the times were taken.
    pub machine: &'a Machine,
    /// What the figures mean.
    pub words: Words,
    /// The figures.
    #[serde(flatten)]
    pub study: &'a CostStudy,
    /// The settings that no other beats: less time and a smaller error than any that is as good in the other.
    pub pareto_front: Vec<Name>,
}

/// Definitions that a reader of the numbers needs.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Words {
    /// Of `time_ms`.
    pub time: &'static str,
    /// Of `yardsticks`.
    pub yardsticks: &'static str,
    /// Of `lines_px`.
    pub lines: &'static str,
    /// Of `corners_px`.
    pub corners: &'static str,
    /// Of `measured`.
    pub measured: &'static str,
    /// Of `effects`.
    pub effects: &'static str,
}

/// One setting by its name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Name {
    /// What was turned.
    pub knob: &'static str,
    /// To what.
    pub value: String,
}

impl<'a> CostReport<'a> {
    /// The report of a study.
    pub fn new(scene: &'a str, machine: &'a Machine, study: &'a CostStudy) -> Self {
        let words = Words {
            time: "CPU time of one picture (of one design) on one thread, ms; all settings in one interleaved run",
            yardsticks: "time of a picture over that of a fixed f64 kernel that traces one ray a pixel, run right before",
            lines: "shift of every line of the board across a row or column of pixels against the reference, from the \
                    pixels alone: integral of the difference over the contrast, px",
            corners: "distance of what a corner's exact position is said to see from the corner, px",
            effects: "a thin lens (f/4, in focus at 0.6 of the board's distance), a telecentric one, and the prism as triangles, \
                      each against a finer picture with the same effect",
            measured: "what the corner detector finds in the picture; shifts against what it finds in the reference, px",
        };
        let pareto_front =
            front(&study.pictures).into_iter().map(|s| Name { knob: s.knob, value: s.value.clone() }).collect();
        Self { schema: "biprism-cost/1", scene, machine, words, study, pareto_front }
    }

    /// As JSON: indented, a newline at the end.
    pub(crate) fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("a study holds only strings, numbers and lists");
        text.push('\n');
        text
    }
}

/// The error that a setting is judged by: the largest shift of a line of the board, in px; of the reference, what it says
/// of itself; not a number where no line was crossed.
pub fn error_px(setting: &Setting) -> f64 {
    match (setting.account, setting.lines_px) {
        (Some(account), _) if account.level == Level::Reference => account.achieved_px(),
        (_, Some(lines)) => lines.max,
        _ => f64::NAN,
    }
}

/// Settings to which no other is better in time or error and at least as good in the other, fastest first.
pub fn front(settings: &[Setting]) -> Vec<&Setting> {
    let mut placed: Vec<&Setting> = settings.iter().collect();
    let time = |s: &Setting| s.time_ms.median;
    placed.sort_by(|a, b| time(a).total_cmp(&time(b)).then(error_px(a).total_cmp(&error_px(b))));
    let mut best = f64::INFINITY;
    placed.retain(|s| {
        let better = error_px(s) < best;
        best = best.min(error_px(s));
        better
    });
    placed
}
