//! Golden tests (regression): pictures and numbers that were judged right once and must not move.
//!
//! Each case is a scene `<case>.toml`; its golden is `<case>.png` (16-bit grey, linear) and `<case>.json` (numbers) in
//! another folder. A case without a golden fails, and so does a golden without a case. A failing case leaves
//! `<case>.strip.png` (expected | difference | actual), or `<case>.actual.png` where there is no golden, and `<case>.diff.txt`
//! in a third folder.
//!
//! What is random is drawn in several frames of one specimen; the golden picture is then the mean, and means and
//! variances are judged region by region ([`noise`]). Everything else must be as it was.

pub mod noise;
pub mod record;

#[cfg(test)]
mod tests;
pub mod snapshot;
mod report;
mod cases;
mod run;
mod check;
mod residuals;

pub use cases::{PIXEL_TOLERANCE, case_names, orphans, run_case};
pub use check::{check, check_asked, check_case};
pub use report::{CaseResult, Folders, GoldenOutcome, GoldenOutput, GoldenReport, Mode, Tolerances};
pub use run::{GoldenRequest, run};
