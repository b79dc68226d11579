//! The text of trials: a line that says what was drawn, and a line of JSON a trial.

use crate::analysis::tolerance::operand::Operand;
use crate::analysis::tolerance::probe::Criterion;
use crate::analysis::tolerance::trials::JudgedTrial;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The form of these texts.
pub const TRIALS_SCHEMA: &str = "biprism-trials/1";

/// What was drawn: the first line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialRun {
    /// [`TRIALS_SCHEMA`].
    pub schema: String,
    /// The prisms, in the order of their numbers in the lines.
    pub prisms: Vec<RunPrism>,
    /// The errors by name, with their amounts.
    pub operands: Vec<(String, f64)>,
    /// How each is drawn.
    pub distribution: String,
    /// Of the random numbers; as text, for JSON's numbers do not hold it.
    pub seed: String,
    /// How many, of each prism.
    pub trials: u32,
    /// The keys of the criteria, in the order of the figures.
    pub criteria: Vec<String>,
    /// The relay lens of the spots.
    pub lens: Map<String, Value>,
    /// Which part of how many the file holds; all where it says nothing.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub shard: Option<[u32; 2]>,
}

/// A prism of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunPrism {
    /// Its name.
    pub name: String,
    /// The checksums of its instrument's parts.
    pub instrument: Map<String, Value>,
}

/// A trial: every other line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialLine {
    /// The prism's number, from 0 on.
    pub prism: usize,
    /// The trial's number, from 0 on.
    pub trial: u32,
    /// A figure for each criterion, where there are any.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub figures: Option<Vec<f64>>,
    /// Why there are none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub none: Option<String>,
}

impl TrialRun {
    /// Whether a file of this version can hold it.
    pub(crate) fn is_known(&self) -> bool {
        let operands = self.operands.iter().all(|(name, _)| Operand::named(name).is_some());
        let criteria = self.criteria.iter().all(|key| Criterion::named(key).is_some());
        self.schema == TRIALS_SCHEMA && operands && criteria && self.shard.is_none_or(|[i, n]| 1 <= i && i <= n)
    }

    /// What of it is other in `found`, by its key.
    pub fn difference(&self, found: &Self) -> Option<String> {
        let keys = |run: &Self| serde_json::to_value(run).ok().and_then(|value| value.as_object().cloned());
        let (own, found) = (keys(self)?, keys(found)?);
        let other = own.iter().find(|(key, value)| found.get(*key) != Some(value)).map(|(key, _)| key.clone());
        other.or_else(|| found.keys().find(|key| !own.contains_key(*key)).cloned())
    }

    /// Whether its part holds the trial of this number.
    pub fn holds(&self, trial: u32) -> bool {
        trial < self.trials && self.shard.is_none_or(|[i, n]| trial % n == i - 1)
    }

    /// The numbers of its trials.
    pub fn numbers(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.trials).filter(|trial| self.holds(*trial))
    }

    /// Whether `line` is one of its trials, with a figure for each criterion or none.
    pub fn fits(&self, line: &TrialLine) -> bool {
        let figures = match (&line.figures, &line.none) {
            (Some(figures), None) => figures.len() == self.criteria.len(),
            (None, Some(_)) => true,
            _ => false,
        };
        figures && line.prism < self.prisms.len() && self.holds(line.trial)
    }
}

impl TrialLine {
    /// The line of a trial of the prism of this number.
    pub fn new(prism: usize, judged: JudgedTrial) -> Self {
        let (figures, none) = match judged.figures {
            Ok(figures) => (Some(figures), None),
            Err(why) => (None, Some(why.0)),
        };
        Self { prism, trial: judged.number, figures, none }
    }
}

/// `value` as a line of text.
pub fn line<T: Serialize>(value: &T) -> String {
    // Neither keys nor values can fail to be JSON: figures are finite.
    serde_json::to_string(value).unwrap_or_default() + "\n"
}
