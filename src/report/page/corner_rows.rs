//! The corners of a picture as rows of numbers for a page.

use crate::analysis::judge::Judgement;
use crate::analysis::view::HalfView;
use crate::report::json::{CornerBudget, ErrorBudget};
use crate::vision::half::Half;
use glam::DVec2;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The steps of a budget that a page tells of each corner, by name.
pub(super) const BUDGET_STEPS: [&str; 5] = ["optics", "fit", "detector", "effects", "sampling"];

/// The found corners of both halves, a row each: half (0 left, 1 right), column, row, found position in the whole picture, found
/// less true and found less ideal position, standard deviations along x and y, correlation, and the steps of [`BUDGET_STEPS`] where
/// a budget was made; all in px, along x and y in turn, `null` where it is not known.
pub(super) fn corner_rows(judgement: &Judgement, budget: Option<&ErrorBudget>) -> Vec<Value> {
    let of_half = |(half, view): (Half, &HalfView)| {
        let steps: BTreeMap<[i32; 2], &CornerBudget> =
            budget.iter().flat_map(|b| &b.corners).filter(|c| c.half == half.name()).map(|c| (c.index, c)).collect();
        rows(judgement, half, view, &steps)
    };
    Half::BOTH.into_iter().zip(&judgement.view.halves).flat_map(of_half).collect()
}

fn rows(judgement: &Judgement, half: Half, view: &HalfView, steps: &BTreeMap<[i32; 2], &CornerBudget>) -> Vec<Value> {
    let board = &judgement.view.board;
    let row = |found: &crate::analysis::board_indexing::Found| {
        // Where it is, and where it should be.
        let [column, line] = found.index.map(f64::from);
        let truth = view.truth.as_ref().and_then(|truth| truth.get(&found.index)).map(|t| t.position_px);
        let ideal = view.ideal_px(board.world(board.corner_at(column, line)));
        let place = view.frame.full(found.position_px);

        // How well it is known, and what made its error.
        let spread = found.covariance_px2.map(|c| [libm::sqrt(c.x_axis.x), libm::sqrt(c.y_axis.y), c.x_axis.y]);
        let spread = spread.map(|[x, y, xy]| [short(x), short(y), short(xy / (x * y))]);
        let mut values = vec![
            json!(half as usize),
            json!(found.index[0]),
            json!(found.index[1]),
            json!(fixed(place.x)),
            json!(fixed(place.y)),
        ];
        for from in [truth, ideal] {
            values.extend(pair(from.map(|from| found.position_px - from)));
        }
        values.extend(spread.map_or_else(|| vec![Value::Null; 3], |s| s.map(|v| json!(v)).to_vec()));
        if !steps.is_empty() {
            let own = steps.get(&found.index);
            let each =
                own.map(|c| [Some(c.optics_px), c.fit_px, Some(c.detector_px), c.effects_px, Some(c.sampling_px)]);
            let each = each.unwrap_or_default();
            values.extend(each.into_iter().flat_map(|step| pair(step.map(DVec2::from_array))));
        }
        Value::Array(values)
    };
    view.found.iter().map(row).collect()
}

/// Two numbers, or twice nothing.
fn pair(vector: Option<DVec2>) -> [Value; 2] {
    vector.map_or([Value::Null, Value::Null], |v| [json!(short(v.x)), json!(short(v.y))])
}

/// To a ten-thousandth.
fn fixed(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// To four significant digits.
pub(super) fn short(value: f64) -> f64 {
    significant(value, 3)
}

/// To `behind` digits behind the first.
pub(super) fn significant(value: f64, behind: usize) -> f64 {
    format!("{value:.behind$e}").parse().unwrap_or(value)
}
