//! Sensitivities: each error alone, both ways, and how large it may be.

use super::operand::Operand;
use super::probe::{Criterion, NoFigure, Probe};
use rayon::prelude::*;

/// Steps of the search for the largest error that a budget allows.
const MOST_STEPS: usize = 60;
/// How well the end is found, as a share of itself.
const ALLOWED_TO: f64 = 1e-3;
/// The search gives up beyond this many times the amount that was tried.
const FARTHEST: f64 = 1024.0;

/// What an error does to each criterion.
#[derive(Debug, Clone, PartialEq)]
pub struct OperandSensitivity {
    /// The error.
    pub operand: Operand,
    /// Its size, in the operand's unit.
    pub amount: f64,
    /// For each criterion, with + and - that size, or why there is no figure.
    pub figures: [Result<Vec<f64>, NoFigure>; 2],
    /// For each criterion the largest size, of either sign, that keeps it within its budget; `None` where none was given or the search
    /// found no end.
    pub allowed: Vec<Option<f64>>,
}

/// A budget: what a criterion may become.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budgeted {
    /// The criterion.
    pub criterion: Criterion,
    /// Its largest value that is still good.
    pub most: f64,
}

/// The sensitivities of `operands`, with their amounts, to the criteria `asked`; errors that the prism cannot have are left out.
///
/// `done` hears of every operand that is finished.
pub fn sensitivities(
    probe: &Probe,
    operands: &[(Operand, f64)],
    asked: &[Criterion],
    budgets: &[Budgeted],
    done: &(dyn Fn() + Sync),
) -> Vec<OperandSensitivity> {
    let acting: Vec<(Operand, f64)> =
        operands.iter().copied().filter(|(operand, _)| operand.acts_on(&probe.scene.prism)).collect();
    let one = |&(operand, amount): &(Operand, f64)| {
        let figures = [amount, -amount].map(|amount| with(probe, operand, amount, asked));
        let allowed = asked.iter().map(|criterion| {
            let budget = budgets.iter().find(|budget| budget.criterion == *criterion)?;
            allowed(probe, operand, amount, budget)
        });
        let found = OperandSensitivity { operand, amount, figures, allowed: allowed.collect() };
        done();
        found
    };
    acting.par_iter().map(one).collect()
}

fn with(probe: &Probe, operand: Operand, amount: f64, asked: &[Criterion]) -> Result<Vec<f64>, NoFigure> {
    let scene = operand.put_into(&probe.scene, amount).map_err(|problem| NoFigure(problem.to_string()))?;
    probe.figures(&scene, asked)
}

/// The largest size, of the worse sign, that keeps a criterion within its budget, to [`ALLOWED_TO`] of itself: doubled until it does not,
/// then searched in between by the rule of false position, Illinois' variant (M. Dowell, P. Jarratt, BIT 11, 1971, 168). An error without a
/// figure is beyond every budget.
fn allowed(probe: &Probe, operand: Operand, amount: f64, budget: &Budgeted) -> Option<f64> {
    let one =
        |amount: f64| with(probe, operand, amount, &[budget.criterion]).map_or(f64::INFINITY, |figures| figures[0]);
    let over = |size: f64| one(size).max(one(-size)) - budget.most;
    let (mut low, mut below) = (0.0, over(0.0));
    if below > 0.0 {
        return Some(0.0);
    }

    // Find a size that is too large.
    let mut high = amount.abs();
    let mut above = over(high);
    while above <= 0.0 {
        (low, below) = (high, above);
        high *= 2.0;
        if high > FARTHEST * amount.abs() {
            return None;
        }
        above = over(high);
    }

    // Close in on the end.
    for _ in 0..MOST_STEPS {
        if high - low <= ALLOWED_TO * high {
            break;
        }
        let secant = low - below * (high - low) / (above - below);
        let between = if above.is_finite() && low < secant && secant < high { secant } else { 0.5 * (low + high) };
        let found = over(between);
        if found <= 0.0 {
            (low, below, above) = (between, found, 0.5 * above);
        } else {
            (high, above, below) = (between, found, 0.5 * below);
        }
    }
    Some(low)
}
