//! `biprism analyse`: studies that print what they find.

use super::outcome::Outcome;
use super::output::stdout;
use super::progress::Progress;
use super::study::{design, paper, relay, stereo, tolerance};
use super::study_args::{AnalyseArgs, StabilityArgs, Study};
use crate::analysis::stability::{self, Case};
use crate::error::Error;
use crate::progress::Observer;
use serde_json::json;
use std::fmt::Write;
use std::time::Instant;

pub(super) fn run(args: &AnalyseArgs) -> Result<Outcome, Error> {
    match &args.study {
        Study::Stability(args) => stability(args),
        Study::Spot(args) => relay::spot(args),
        Study::FieldCurvature(args) => relay::field_curvature(args),
        Study::Mtf(args) => relay::mtf(args),
        Study::Reprojection(args) => design::reprojection(args),
        Study::Convergence(args) => design::convergence(args),
        Study::Tolerance(args) => tolerance::run(args),
        Study::Surface(args) => design::surface(args),
        Study::Paper(args) => paper::paper(args),
        Study::Stereo(args) => stereo::stereo(args),
        Study::Layout(args) => design::layout(args),
    }
}

/// A case that was run.
struct CaseRow {
    case: &'static Case,
    outcome: stability::CaseOutcome,
    seconds: f64,
}

/// Runs the catalogue of hard cases, one after the other so that each has its own time.
fn stability(args: &StabilityArgs) -> Result<Outcome, Error> {
    let named =
        |case: &&Case| args.only.as_ref().is_none_or(|word| case.name.contains(word) || case.group.contains(word));
    let cases: Vec<&Case> = stability::catalogue().filter(named).collect();
    let progress = Progress::new(0);
    let watch = progress.watch("stability");
    watch.stage_of("cases", cases.len());
    let rows: Vec<CaseRow> = cases
        .into_iter()
        .map(|case| {
            let started = Instant::now();
            let outcome = (case.run)();
            watch.pixels(1);
            CaseRow { case, outcome, seconds: started.elapsed().as_secs_f64() }
        })
        .collect();
    drop(progress);
    if rows.is_empty() {
        let word = args.only.as_deref().unwrap_or_default();
        let rule = format!("no case or chapter has {word:?} in its name");
        return Err(Error::new("--only", rule, "leave it out to see every name"));
    }
    if args.json {
        let entries: Vec<_> = rows.iter().map(entry).collect();
        stdout(&format!("{:#}\n", json!({ "cases": entries })))?;
    } else {
        stdout(&table(&rows))?;
    }
    let all = rows.iter().all(|row| row.case.holds(&row.outcome));
    if !all {
        super::output::unmet("some cases do not keep to their bounds");
    }
    Ok(if all { Outcome::Done } else { Outcome::Unmet })
}

fn entry(row: &CaseRow) -> serde_json::Value {
    let CaseRow { case, outcome, seconds } = row;
    json!({
        "group": case.group, "name": case.name, "hard": case.hard, "property": case.property,
        "unit": case.unit, "bound": case.bound, "why": case.why, "holds": case.holds(outcome),
        "checked": outcome.checked, "worst": outcome.worst, "worst_at": outcome.worst_at,
        "residual_mm": outcome.residual_mm, "fates": outcome.fates, "broken": outcome.broken,
        "seconds": seconds,
    })
}

fn table(rows: &[CaseRow]) -> String {
    let width = |of: fn(&CaseRow) -> usize| rows.iter().map(of).max().unwrap_or(0);
    let (group, name) = (width(|r| r.case.group.len()).max(7), width(|r| r.case.name.len()).max(4));
    let mut text = format!(
        "{:group$}  {:name$}  {:>7}  {:>8}  {:>8}  {:9}  {:>8}  {:>6}  fates\n",
        "chapter", "case", "checks", "worst", "bound", "unit", "residual", "s"
    );
    for row in rows {
        let CaseRow { case, outcome, seconds } = row;
        let residual = outcome.residual_mm.map_or("-".to_owned(), |mm| format!("{mm:.1e}"));
        let fates: Vec<String> = outcome.fates.iter().map(|(name, n)| format!("{n} {name}")).collect();
        let _ = writeln!(
            text,
            "{:group$}  {:name$}  {:>7}  {:>8.1e}  {:>8.1e}  {:9}  {residual:>8}  {seconds:>6.2}  {}{}",
            case.group,
            case.name,
            outcome.checked,
            outcome.worst,
            case.bound,
            case.unit.name(),
            if fates.is_empty() { "-".to_owned() } else { fates.join(", ") },
            if case.holds(outcome) { "" } else { "  NOT KEPT" },
        );
        if !case.holds(outcome) {
            let _ = writeln!(text, "    worst at {}", outcome.worst_at);
        }
        for broken in &outcome.broken {
            let _ = writeln!(text, "    {broken}");
        }
    }
    text.push_str("\nWhat is hard, what is held against what, and where each bound comes from: --json.\n");
    text
}
