//! Residuals of a golden record: a number, or the reason why there is none.

use crate::analysis::half_image::virtual_camera;
use crate::analysis::truth::TrueCorners;
use crate::analysis::view::HalfView;
use crate::metrics::{MeasuredAndTrue, Unmeasurable};
use crate::system::System;
use serde_json::{Value, json};

/// Why residuals of a half may not exist.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Reasons {
    /// Against a pinhole, neither measured nor true.
    pinhole: Option<String>,
    /// Measured.
    measured: Option<String>,
    /// True.
    exact: Option<String>,
}

impl Reasons {
    /// Those of a half; `random` says that its corners depend on random numbers.
    pub(super) fn of(system: &System, view: &HalfView, random: bool) -> Self {
        let pinhole = virtual_camera(system, &view.frame).err().map(|why| format!("no pinhole: {why}"));
        let exact = view.truth.is_none().then(|| "more corners are seen than could be told apart".to_owned());
        let measured = match (random, view.found.is_empty(), view.detected.wrong) {
            (true, ..) => Some("drawn at random: the noise is judged region by region".to_owned()),
            (_, true, Some(1..)) => Some("no corner is known by its place on the board".to_owned()),
            (_, true, _) => Some(match view.truth.as_ref().and_then(square_px) {
                Some(side) => format!("no corner was found: the squares are {side:.1} px wide"),
                None => "no corner was found".to_owned(),
            }),
            (_, false, _) => None,
        };
        Self { pinhole, measured, exact }
    }

    /// The same for what needs no pinhole.
    pub(super) fn without_pinhole(&self) -> Self {
        Self { pinhole: None, ..self.clone() }
    }

    /// Those of a pair of halves: of either.
    pub(super) fn or(self, other: &Self) -> Self {
        Self {
            pinhole: self.pinhole.or(other.pinhole.clone()),
            measured: self.measured.or(other.measured.clone()),
            exact: self.exact.or(other.exact.clone()),
        }
    }
}

/// The smallest distance of a corner from the next one in its row, in px.
fn square_px(truth: &TrueCorners) -> Option<f64> {
    let step = |(index, corner): (&[i32; 2], &crate::analysis::truth::TrueCorner)| {
        Some(truth.get(&[index[0] + 1, index[1]])?.position_px.distance(corner.position_px))
    };
    truth.iter().filter_map(step).min_by(f64::total_cmp)
}

/// Both sides of a residual.
pub(super) fn residual<T>(figure: &MeasuredAndTrue<T>, reasons: &Reasons, pick: impl Fn(&T) -> f64) -> Value {
    let (pinhole, Reasons { measured, exact, .. }) = (&reasons.pinhole, reasons);
    json!({
        "measured": side(&figure.measured, pinhole.as_ref().or(measured.as_ref()), &pick),
        "true": side(&figure.exact, pinhole.as_ref().or(exact.as_ref()), &pick),
    })
}

/// The side of a residual that is traced.
pub(super) fn traced<T>(figure: &MeasuredAndTrue<T>, reasons: &Reasons, pick: impl Fn(&T) -> f64) -> Value {
    side(&figure.exact, reasons.pinhole.as_ref().or(reasons.exact.as_ref()), &pick)
}

fn side<T>(result: &Option<Result<T, Unmeasurable>>, reason: Option<&String>, pick: &impl Fn(&T) -> f64) -> Value {
    match (reason, result) {
        (Some(reason), _) => json!(reason),
        (None, Some(Ok(value))) => json!(pick(value)),
        (None, Some(Err(why))) => json!(why.to_string()),
        (None, None) => json!("it was not asked for"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Residuals are what goldens are for: none is missing without a word.
    #[test]
    fn every_golden_holds_its_residuals_or_says_why_not() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden");
        let mut numbers = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|ending| ending != "json") {
                continue;
            }
            let record: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
            let mut leaves = vec![&record["residuals"]["vertical_disparity_rms_px"]];
            for half in ["left", "right"] {
                let residuals = &record[half]["residuals"];
                leaves.extend([&residuals["designed_rms_px"], &residuals["straightness_rms_px"]]);
            }
            for side in leaves.iter().flat_map(|leaf| [&leaf["measured"], &leaf["true"]]) {
                let told = side.is_f64() || side.as_str().is_some_and(|why| !why.is_empty());
                assert!(told, "{}: {side}", path.display());
                numbers += usize::from(side.is_f64());
            }
        }
        // Of 27 cases with 10 sides each; telecentric, random, tiny, too fine and unpaired views lack some.
        assert!(numbers >= 242, "{numbers}");
    }
}
