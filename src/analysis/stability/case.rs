//! One hard case of the catalogue.

use super::tally::CaseOutcome;

/// What an error is counted in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorUnit {
    /// Pixels of the image.
    Px,
    /// Millimetres on a surface or on the board.
    Mm,
    /// A share of the value itself.
    Relative,
    /// Radiance, of full scale 1.
    Radiance,
    /// Orders of convergence.
    Order,
}

impl ErrorUnit {
    /// The name used in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Px => "px",
            Self::Mm => "mm",
            Self::Relative => "relative",
            Self::Radiance => "radiance",
            Self::Order => "order",
        }
    }
}

/// One hard case.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Its chapter of the catalogue.
    pub group: &'static str,
    /// Its name, unique in the catalogue.
    pub name: &'static str,
    /// What is hard about it.
    pub hard: &'static str,
    /// What is held against what.
    pub property: &'static str,
    /// What its error is counted in.
    pub unit: ErrorUnit,
    /// The largest error that it may show.
    pub bound: f64,
    /// Where the bound comes from.
    pub why: &'static str,
    /// Runs it.
    pub run: fn() -> CaseOutcome,
}

impl Case {
    /// Whether `outcome` keeps the case's promises: something was checked, every property held, and the largest error is
    /// a number within the bound.
    pub fn holds(&self, outcome: &CaseOutcome) -> bool {
        outcome.checked > 0 && outcome.broken.is_empty() && outcome.worst <= self.bound
    }
}
