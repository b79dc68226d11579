//! The error budget of corners in the report.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the error of a corner comes from: steps from where an ideal pinhole sees it to where it was measured,
/// optics + fit + detector + effects + sampling = measured - ideal, in px of the half image (x, y).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErrorBudget {
    /// Where the designed, marched surfaces put the corner, less where the designed virtual camera sees it: what the
    /// design leaves. Where the prism is not designed from points, where the plain instrument (without effects) puts it,
    /// less that.
    pub optics: BudgetTerm,
    /// Where the plain instrument, of polynomials fitted to the marched points, puts it, less where those points do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit: Option<BudgetTerm>,
    /// Found in the plain instrument's picture (every pixel traced), less where that instrument puts it: the detector's
    /// own error.
    pub detector: BudgetTerm,
    /// Found under the scene's effects but the sensor's, errors of manufacture among them, less found in the plain
    /// picture; absent without such effects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effects: Option<BudgetTerm>,
    /// Found in the judged picture, less found before that: what the level, the sensor and the file add.
    pub sampling: BudgetTerm,
    /// Measured less ideal.
    pub total: BudgetTerm,
    /// The longest vector that the steps leave of a total, in px: rounding.
    pub remainder_max_px: f64,
    /// Measured corners without a budget: not found in one of the other pictures, or seen by no ray.
    pub left_out: u64,
    /// Each corner, left half first, by column, then by row.
    pub corners: Vec<CornerBudget>,
}

/// Vectors of a step over all corners.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BudgetTerm {
    /// sqrt(sum |e|^2 / N); 0 of none.
    pub rms_px: f64,
    /// The longest.
    pub max_px: f64,
    /// The mean vector.
    pub mean_px: [f64; 2],
}

/// The budget of one corner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CornerBudget {
    /// `left` or `right`.
    pub half: String,
    /// Column and row on the board.
    pub index: [i32; 2],
    /// Where it was measured, from the half's own origin (pixel-edge convention).
    pub measured_px: [f64; 2],
    /// Where the designed virtual camera sees it.
    pub ideal_px: [f64; 2],
    /// See [`ErrorBudget::optics`].
    pub optics_px: [f64; 2],
    /// See [`ErrorBudget::fit`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit_px: Option<[f64; 2]>,
    /// See [`ErrorBudget::detector`].
    pub detector_px: [f64; 2],
    /// See [`ErrorBudget::effects`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effects_px: Option<[f64; 2]>,
    /// See [`ErrorBudget::sampling`].
    pub sampling_px: [f64; 2],
}
