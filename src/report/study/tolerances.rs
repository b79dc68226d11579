//! Sensitivities as sheets and figures.

use super::document::StudyFigure;
use crate::analysis::tolerance::probe::Criterion;
use crate::analysis::tolerance::sensitivity::{Budgeted, OperandSensitivity};
use crate::plot::axis::significant;
use crate::plot::tornado::{self, TornadoBar, TornadoPanel};
use crate::report::sheet::{Cell, StudySheet};

/// The sensitivities of a prism.
#[derive(Debug, Clone)]
pub struct NamedSensitivities {
    /// The prism's name.
    pub prism: String,
    /// For each criterion, without errors.
    pub right: Vec<f64>,
    /// Error by error.
    pub errors: Vec<OperandSensitivity>,
}

/// The sheets, of what was `asked`.
pub fn sheets(all: &[NamedSensitivities], asked: &[Criterion], budgets: &[Budgeted]) -> Vec<StudySheet> {
    let mut sheets = vec![worse(all, asked), both_ways(all, asked).detailed(), sums(all, asked)];
    if !budgets.is_empty() {
        sheets.push(inverse(all, asked, budgets));
    }
    sheets
}

/// The criterion of number `k` with an error and with its opposite, where they have figures.
fn ends(error: &OperandSensitivity, k: usize) -> [Option<f64>; 2] {
    error.figures.each_ref().map(|found| found.as_ref().ok().map(|figures| figures[k]))
}

/// The larger of them.
fn worst(error: &OperandSensitivity, k: usize) -> f64 {
    ends(error, k).into_iter().flatten().fold(f64::NAN, f64::max)
}

/// One error at a time, both ways.
fn both_ways(all: &[NamedSensitivities], asked: &[Criterion]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "sensitivity",
        "One error at a time, both ways",
        &[
            ("prism", "the prism's name"),
            ("error", "the error"),
            ("amount", "how large it is"),
            ("unit", "the unit of that"),
            ("criterion", "the criterion with its unit; spots are those of the right half"),
            ("plus", "the criterion with the error"),
            ("minus", "with the opposite error"),
            ("change", "the larger of the two less the criterion without errors"),
        ],
    );
    for one in all {
        for (k, criterion) in asked.iter().enumerate() {
            for error in &one.errors {
                let [plus, minus] = ends(error, k).map(Cell::from);
                let change = (worst(error, k) - one.right[k]).into();
                let operand = error.operand;
                let lead: [Cell; 4] =
                    [one.prism.as_str().into(), operand.name().into(), error.amount.into(), operand.unit().into()];
                sheet.push(lead.into_iter().chain([criterion.key().into(), plus, minus, change]).collect());
            }
        }
    }
    sheet
}

/// How large each error alone may be.
fn inverse(all: &[NamedSensitivities], asked: &[Criterion], budgets: &[Budgeted]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "inverse",
        "How large each error alone may be",
        &[
            ("prism", "the prism's name"),
            ("error", "the error"),
            ("criterion", "the criterion with its unit"),
            ("budget", "the largest that is good"),
            (
                "allowed",
                "the largest error, of either sign, that keeps it, to a thousandth; nothing where 1024 times the amount is not too large",
            ),
            ("unit", "the unit of that"),
        ],
    );
    for one in all {
        for (k, criterion) in asked.iter().enumerate() {
            let Some(budget) = budgets.iter().find(|b| b.criterion == *criterion) else { continue };
            for error in &one.errors {
                let lead: [Cell; 3] = [one.prism.as_str().into(), error.operand.name().into(), criterion.key().into()];
                let rest: [Cell; 3] = [budget.most.into(), error.allowed[k].into(), error.operand.unit().into()];
                sheet.push(lead.into_iter().chain(rest).collect());
            }
        }
    }
    sheet
}

/// All errors together, as if they were small and independent.
fn sums(all: &[NamedSensitivities], asked: &[Criterion]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "sum",
        "All of them, as independent small errors",
        &[
            ("prism", "the prism's name"),
            ("criterion", "the criterion with its unit"),
            ("none", "without errors"),
            (
                "all",
                "the root of the sum of its square and those that the errors add, each the worse of its two signs; --trials has no need to take them as small",
            ),
        ],
    );
    for one in all {
        for (k, criterion) in asked.iter().enumerate() {
            let right = one.right[k];
            let added = |error: &OperandSensitivity| {
                let worst = worst(error, k);
                if worst > right { worst * worst - right * right } else { 0.0 }
            };
            let square = right * right + one.errors.iter().map(added).sum::<f64>();
            sheet.push(vec![one.prism.as_str().into(), criterion.key().into(), right.into(), square.sqrt().into()]);
        }
    }
    sheet
}

/// One error at a time in short: a column a criterion.
fn worse(all: &[NamedSensitivities], asked: &[Criterion]) -> StudySheet {
    let lead = [
        ("prism", "the prism's name"),
        ("error", "the error"),
        ("amount", "how large it is"),
        ("unit", "the unit of that"),
    ];
    let columns = asked.iter().map(|criterion| (criterion.key(), "the criterion with the error, of the worse sign"));
    let columns: Vec<_> = lead.into_iter().chain(columns).collect();
    let mut sheet = StudySheet::new("worse", "One error at a time, the worse of both signs", &columns);
    for one in all {
        let right: [Cell; 4] = [one.prism.as_str().into(), "none".into(), Cell::Nothing, "-".into()];
        sheet.push(right.into_iter().chain(one.right.iter().map(|figure| (*figure).into())).collect());
        for error in &one.errors {
            let of = |k: usize| worst(error, k).into();
            let lead: [Cell; 4] = [
                one.prism.as_str().into(),
                error.operand.name().into(),
                error.amount.into(),
                error.operand.unit().into(),
            ];
            sheet.push(lead.into_iter().chain((0..asked.len()).map(of)).collect());
        }
    }
    sheet
}

/// A tornado chart a criterion, a panel a prism.
pub fn figures(all: &[NamedSensitivities], asked: &[Criterion]) -> Vec<StudyFigure> {
    let one = |(k, criterion): (usize, &Criterion)| {
        let panel = |one: &NamedSensitivities| {
            let bar = |error: &OperandSensitivity| TornadoBar {
                name: format!(
                    "{} ±{} {}",
                    error.operand.name(),
                    significant(error.amount, 3),
                    unit(error.operand.unit())
                ),
                ends: ends(error, k),
            };
            TornadoPanel { name: one.prism.clone(), middle: one.right[k], bars: one.errors.iter().map(bar).collect() }
        };
        let title = format!("One error at a time: {}", criterion.key());
        let panels: Vec<TornadoPanel> = all.iter().map(panel).collect();
        let name = format!("tolerance_{}", criterion.key());
        StudyFigure { name, drawing: tornado::draw(&title, &panels, 1100), title }
    };
    asked.iter().enumerate().map(one).collect()
}

fn unit(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}
