//! Trials: prisms with all errors at once, drawn at random (Monte Carlo).

use super::operand::Operand;
use super::probe::{Criterion, NoFigure, Probe};
use crate::num::deviates::Stream;
use crate::num::stats::{normal_beyond, quantile};
use rayon::prelude::*;

/// How the size of an error is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distribution {
    /// Normal, with the amount as two standard deviations.
    Normal,
    /// Uniform between minus and plus the amount.
    Uniform,
}

impl Distribution {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Uniform => "uniform",
        }
    }
}

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialPlan {
    /// The errors with their amounts.
    pub operands: Vec<(Operand, f64)>,
    /// How each is drawn.
    pub distribution: Distribution,
    /// Of the random numbers.
    pub seed: u64,
    /// What is asked of every prism.
    pub asked: Vec<Criterion>,
}

/// A prism that was made at random, and judged.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedTrial {
    /// Which: from 0 on.
    pub number: u32,
    /// For each criterion that was asked its figure, or why there is none.
    pub figures: Result<Vec<f64>, NoFigure>,
}

/// The purpose of a trial's random numbers.
const PURPOSE: u32 = 0x746f_6c31;

/// The prism of one trial, judged; the same whatever other trials are made.
///
/// # Errors
/// Where it lets rays no longer pass, or nothing fits.
pub(super) fn trial(probe: &Probe, plan: &TrialPlan, number: u32) -> Result<Vec<f64>, NoFigure> {
    let mut stream = Stream::new(plan.seed, PURPOSE, 0, number);
    let mut scene = probe.scene.clone();
    for &(operand, amount) in &plan.operands {
        // Every operand draws, so that leaving one out changes no other's draw only by its place in the list.
        let share = match plan.distribution {
            Distribution::Normal => 0.5 * stream.normals()[0],
            Distribution::Uniform => 2.0 * stream.uniform() - 1.0,
        };
        if operand.acts_on(&scene.prism) {
            scene = operand.put_into(&scene, share * amount).map_err(|problem| NoFigure(problem.to_string()))?;
        }
    }
    probe.figures(&scene, &plan.asked)
}

/// The trials of these numbers, in their order.
pub fn trials(probe: &Probe, plan: &TrialPlan, numbers: &[u32]) -> Vec<JudgedTrial> {
    numbers.par_iter().map(|&number| JudgedTrial { number, figures: trial(probe, plan, number) }).collect()
}

/// A quantile of the trials with its interval of confidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialQuantile {
    /// Which: 0.5 is the median.
    pub share: f64,
    /// Its estimate.
    pub value: f64,
    /// An interval that holds the true one in 95 of 100 cases; an end is `None` where the trials are too few for it.
    pub interval: [Option<f64>; 2],
}

/// The quantiles of `values`, which need not be in order.
///
/// The interval is that of order statistics: the count of values below the true quantile is binomial, here taken as normal (J. D. Gibbons, S.
/// Chakraborti, Nonparametric Statistical Inference, 5.2).
pub fn quantiles(values: &[f64], shares: &[f64]) -> Vec<TrialQuantile> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len() as f64;
    let z = normal_beyond(0.025);
    let of = |&share: &f64| {
        let value = quantile(&sorted, share)?;
        let (middle, spread) = (count * share, z * (count * share * (1.0 - share)).sqrt());
        let at = |rank: f64| (rank >= 0.0 && rank < count).then(|| sorted[rank as usize]);
        let interval = [at((middle - spread).floor() - 1.0), at((middle + spread).ceil())];
        Some(TrialQuantile { share, value, interval })
    };
    shares.iter().filter_map(of).collect()
}

/// The share of trials that keep a budget, with its interval of 95 of 100 cases (Wilson's).
pub(crate) fn yield_of(good: usize, trials: usize) -> [f64; 3] {
    let (n, p, z) = (trials as f64, good as f64 / trials.max(1) as f64, normal_beyond(0.025));
    let middle = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let spread = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    [p, (middle - spread).max(0.0), (middle + spread).min(1.0)]
}
