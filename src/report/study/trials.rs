//! Trials as sheets and figures.

use super::document::{StudyDocument, StudyFigure};
use super::trial_lines::{TrialLine, TrialRun};
use crate::analysis::tolerance::sensitivity::Budgeted;
use crate::analysis::tolerance::trials::{quantiles, yield_of};
use crate::num::stats::mean;
use crate::plot::axis::Scale;
use crate::plot::chart::{self, AxisInput, ChartInput, ChartSeries, Front, Look, Point};
use crate::report::sheet::{Cell, StudySheet};
use serde_json::{Map, json};

/// The quantiles that are told.
const SHARES: [f64; 5] = [0.1, 0.5, 0.9, 0.95, 0.99];
/// Points of a curve.
const POINTS: usize = 200;

/// The figures of a prism by one criterion, in the order of the trials.
fn column(lines: &[TrialLine], prism: usize, criterion: usize) -> Vec<f64> {
    let own = lines.iter().filter(|line| line.prism == prism);
    own.filter_map(|line| line.figures.as_ref().and_then(|figures| figures.get(criterion).copied())).collect()
}

/// The document of all trials of a run.
pub fn document(run: &TrialRun, lines: &[TrialLine], budgets: &[Budgeted]) -> StudyDocument {
    let mut settings: Map<_, _> = run.lens.clone();
    let kept: Map<_, _> = budgets.iter().map(|b| (b.criterion.key().to_owned(), json!(b.most))).collect();
    let own = [
        ("operands", json!(run.operands)),
        ("distribution", json!(run.distribution)),
        ("seed", json!(run.seed)),
        ("trials", json!(run.trials)),
        ("budgets", json!(kept)),
    ];
    settings.extend(own.map(|(key, value)| (key.to_owned(), value)));
    let sheets = vec![yields(run, lines, budgets), spread(run, lines)];
    StudyDocument { name: "tolerance_trials", settings, sheets, figures: figures(run, lines, budgets) }
}

/// How many prisms keep what.
fn yields(run: &TrialRun, lines: &[TrialLine], budgets: &[Budgeted]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "yield",
        "Prisms with all errors at once",
        &[
            ("prism", "the prism's name"),
            ("criterion", "the criterion with its unit; all: every budget at once"),
            ("trials", "how many prisms were made"),
            ("without_figure", "how many of them let rays not pass, so that they have no figure and keep no budget"),
            ("mean", "the mean of the others' figures"),
            ("worst", "the largest of them"),
            ("budget", "the largest that is good"),
            ("yield", "the share of all trials that keep it"),
            ("yield_low", "lower end of the interval that holds the true share in 95 of 100 cases (Wilson)"),
            ("yield_high", "its upper end"),
        ],
    );
    for (k, prism) in run.prisms.iter().enumerate() {
        let own: Vec<&TrialLine> = lines.iter().filter(|line| line.prism == k).collect();
        let without = own.iter().filter(|line| line.figures.is_none()).count();
        let share = |good: usize| yield_of(good, own.len()).map(Cell::from);
        for (c, key) in run.criteria.iter().enumerate() {
            let values = column(lines, k, c);
            let most = budgets.iter().find(|b| b.criterion.key() == key).map(|b| b.most);
            let shares = most.map_or([const { Cell::Nothing }; 3], |most| {
                share(values.iter().filter(|value| **value <= most).count())
            });
            let worst = values.iter().copied().fold(f64::NAN, f64::max);
            let mean = if values.is_empty() { f64::NAN } else { mean(&values) };
            let lead: [Cell; 2] = [prism.name.as_str().into(), key.as_str().into()];
            let rest: [Cell; 5] = [own.len().into(), without.into(), mean.into(), worst.into(), most.into()];
            sheet.push(lead.into_iter().chain(rest).chain(shares).collect());
        }
        if budgets.len() > 1 {
            let keeps = |figures: &Vec<f64>| {
                let of = |b: &Budgeted| run.criteria.iter().position(|key| key == b.criterion.key());
                budgets.iter().all(|b| of(b).is_some_and(|c| figures[c] <= b.most))
            };
            let good = own.iter().filter(|line| line.figures.as_ref().is_some_and(keeps)).count();
            let lead: [Cell; 4] = [prism.name.as_str().into(), "all".into(), own.len().into(), without.into()];
            sheet.push(lead.into_iter().chain([const { Cell::Nothing }; 3]).chain(share(good)).collect());
        }
    }
    sheet
}

/// The quantiles.
fn spread(run: &TrialRun, lines: &[TrialLine]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "quantiles",
        "Quantiles",
        &[
            ("prism", "the prism's name"),
            ("criterion", "the criterion with its unit"),
            ("share", "the share of the prisms with figures that are at most so bad"),
            ("value", "how bad"),
            ("low", "lower end of the interval that holds the true quantile in 95 of 100 cases (order statistics)"),
            ("high", "its upper end; nothing where the trials are too few for it"),
        ],
    );
    for (k, prism) in run.prisms.iter().enumerate() {
        for (c, key) in run.criteria.iter().enumerate() {
            for found in quantiles(&column(lines, k, c), &SHARES) {
                let lead: [Cell; 2] = [prism.name.as_str().into(), key.as_str().into()];
                let [low, high] = found.interval.map(Cell::from);
                sheet.push(lead.into_iter().chain([found.share.into(), found.value.into(), low, high]).collect());
            }
        }
    }
    sheet
}

/// For each criterion the share of prisms that are at most so bad.
fn figures(run: &TrialRun, lines: &[TrialLine], budgets: &[Budgeted]) -> Vec<StudyFigure> {
    let shares: Vec<f64> = (0..=POINTS).map(|k| k as f64 / POINTS as f64).collect();
    let one = |(c, key): (usize, &String)| {
        let curve = |(k, prism): (usize, &super::trial_lines::RunPrism)| ChartSeries {
            name: prism.name.clone(),
            look: Look::Line,
            points: quantiles(&column(lines, k, c), &shares).iter().map(|q| Point::new(q.value, q.share)).collect(),
            labels: Vec::new(),
        };
        let mut series: Vec<ChartSeries> = run.prisms.iter().enumerate().map(curve).collect();
        if let Some(budget) = budgets.iter().find(|b| b.criterion.key() == key) {
            let points = vec![Point::new(budget.most, 0.0), Point::new(budget.most, 1.0)];
            series.push(ChartSeries { name: "budget".to_owned(), look: Look::DashedLine, points, labels: Vec::new() });
        }
        let title = format!("{} prisms with all errors at once: {key}", run.trials);
        let drawing = chart::draw(&ChartInput {
            title: title.clone(),
            note: String::new(),
            x: AxisInput { name: key.clone(), scale: Scale::Log, range: None },
            y: AxisInput { name: "share of the prisms".to_owned(), scale: Scale::Linear, range: Some([0.0, 1.0]) },
            series,
            front: Front::None,
            size_px: [1400, 800],
        });
        StudyFigure { name: format!("tolerance_trials_{key}"), title, drawing }
    };
    run.criteria.iter().enumerate().map(one).collect()
}
