//! Error budgets as the report's entries, in words, and as the rows of a figure.

use super::figures::budget::{BudgetInput, BudgetPanel, BudgetRow, Dot, draw};
use super::json::{BudgetTerm, CornerBudget, ErrorBudget};
use crate::analysis::budget::{Budget, CornerErrors as Found};
use crate::analysis::compare::JudgedDesign;
use crate::num::stats;
use crate::plot::drawing::Drawing;
use crate::vision::half::Half;
use glam::DVec2;

/// The steps of a budget by name, and the total: the column of a figure, and the vector of a corner.
type Step = (&'static str, fn(&Found) -> Option<DVec2>);

const STEPS: [Step; 6] = [
    ("optics", |c| Some(c.optics_px)),
    ("fit", |c| c.fit_px),
    ("detector", |c| Some(c.detector_px)),
    ("effects", |c| c.effects_px),
    ("sampling", |c| Some(c.sampling_px)),
    ("measured − ideal", |c| Some(c.total_px())),
];

fn term(budget: &Budget, of: fn(&Found) -> Option<DVec2>) -> Option<BudgetTerm> {
    let vectors: Vec<DVec2> = budget.halves.iter().flatten().map(of).collect::<Option<_>>()?;
    let lengths: Vec<f64> = vectors.iter().map(|v| v.length()).collect();
    let mean = vectors.iter().sum::<DVec2>() / vectors.len().max(1) as f64;
    Some(BudgetTerm { rms_px: stats::rms(&lengths), max_px: stats::max_abs(&lengths), mean_px: mean.to_array() })
}

/// The entry of a budget.
pub fn entry(budget: &Budget) -> ErrorBudget {
    let [optics, fit, detector, effects, sampling, total] = STEPS.map(|(_, of)| term(budget, of));
    // Only fit and effects may be missing.
    let nothing = BudgetTerm { rms_px: 0.0, max_px: 0.0, mean_px: [0.0; 2] };
    let corner = |half: Half, c: &Found| CornerBudget {
        half: half.name().to_owned(),
        index: c.index,
        measured_px: c.measured_px.to_array(),
        ideal_px: c.ideal_px.to_array(),
        optics_px: c.optics_px.to_array(),
        fit_px: c.fit_px.map(|v| v.to_array()),
        detector_px: c.detector_px.to_array(),
        effects_px: c.effects_px.map(|v| v.to_array()),
        sampling_px: c.sampling_px.to_array(),
    };
    let all = || Half::BOTH.into_iter().zip(&budget.halves).flat_map(|(half, cs)| cs.iter().map(move |c| (half, c)));
    ErrorBudget {
        optics: optics.unwrap_or(nothing),
        fit: fit.filter(|_| all().next().is_some()),
        detector: detector.unwrap_or(nothing),
        effects: effects.filter(|_| all().next().is_some()),
        sampling: sampling.unwrap_or(nothing),
        total: total.unwrap_or(nothing),
        remainder_max_px: all().map(|(_, c)| c.remainder_px().length()).fold(0.0, f64::max),
        left_out: budget.left_out as u64,
        corners: all().map(|(half, c)| corner(half, c)).collect(),
    }
}

/// `budget.png`: where the error of each corner of the judged prisms comes from, under the heading `title`; `None` where no
/// prism was judged.
pub fn figure(title: String, judged: &[JudgedDesign]) -> Option<Drawing> {
    let has = |of: fn(&Found) -> Option<DVec2>| {
        let budgets = judged.iter().filter_map(|design| design.budget.as_ref());
        budgets.flat_map(|budget| budget.halves.iter().flatten()).any(|c| of(c).is_some())
    };
    let steps: Vec<Step> = STEPS.into_iter().filter(|(_, of)| has(*of)).collect();
    let rows: Vec<BudgetRow> = judged.iter().filter_map(|design| row(design, &steps)).collect();
    (!rows.is_empty()).then(|| draw(&BudgetInput { title, rows, width_px: 2000 }))
}

/// The row of a design: a panel for each step, the last of them the sum.
fn row(design: &JudgedDesign, steps: &[Step]) -> Option<BudgetRow> {
    let frames = design.judgement.view.halves.each_ref().map(|half| half.frame);
    let panels = panels(design.budget.as_ref()?, steps, |k, px| frames[k].full(px));
    let camera = &design.scene.camera;
    Some(BudgetRow {
        name: format!("{} prism", design.name),
        picture_px: DVec2::new(camera.width_px as f64, camera.height_px as f64),
        seam_px: 0.5 * camera.width_px as f64,
        panels,
    })
}

/// The panels of a budget. `full` puts a half's px into the whole picture.
fn panels(budget: &Budget, steps: &[Step], full: impl Fn(usize, DVec2) -> DVec2) -> Vec<BudgetPanel> {
    let panel = |(name, of): &Step| BudgetPanel {
        name: (*name).to_owned(),
        dots: (0..2)
            .flat_map(|k| budget.halves[k].iter().map(move |c| (k, c)))
            .filter_map(|(k, c)| Some(Dot { at: full(k, c.measured_px), size: of(c)?.length() }))
            .collect(),
    };
    steps.iter().map(panel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two corners whose steps have lengths of their own: 1 and 2 times 1, 2, 4, 8 and 16 px, along x.
    fn budget() -> Budget {
        let corner = |scale: f64| {
            let step = |k: i32| DVec2::new(scale * f64::from(1 << k), 0.0);
            Found {
                index: [3, 5],
                measured_px: DVec2::new(100.0 + scale * 31.0, 7.0),
                ideal_px: DVec2::new(100.0, 7.0),
                optics_px: step(0),
                fit_px: Some(step(1)),
                detector_px: step(2),
                effects_px: Some(step(3)),
                sampling_px: step(4),
            }
        };
        Budget { halves: [vec![corner(1.0)], vec![corner(2.0)]], left_out: 0 }
    }

    /// Each step under its own name, in the entry, in words, and in the figure.
    #[test]
    fn steps_keep_their_names() {
        let budget = budget();
        let entry = entry(&budget);
        let terms = [Some(entry.optics), entry.fit, Some(entry.detector), entry.effects, Some(entry.sampling)];
        for (term, size) in terms.iter().chain([&Some(entry.total)]).zip([1.0, 2.0, 4.0, 8.0, 16.0, 31.0]) {
            let term = term.unwrap();
            assert_eq!((term.max_px, term.mean_px), (2.0 * size, [1.5 * size, 0.0]));
            assert!((term.rms_px - size * 2.5f64.sqrt()).abs() < 1e-13);
        }
        assert_eq!(entry.remainder_max_px, 0.0);
        let corner = &entry.corners[1];
        assert_eq!((corner.half.as_str(), corner.index), ("right", [3, 5]));
        assert_eq!((corner.measured_px, corner.ideal_px), ([162.0, 7.0], [100.0, 7.0]));
        let steps = [
            Some(corner.optics_px),
            corner.fit_px,
            Some(corner.detector_px),
            corner.effects_px,
            Some(corner.sampling_px),
        ];
        assert_eq!(steps.map(|step| step.unwrap()[0]), [2.0, 4.0, 8.0, 16.0, 32.0]);
        let told = crate::report::table::budget_words("flat", &entry);
        let expected = "optics 1.581, fit 3.162, detector 6.325, effects 12.649, sampling 25.298; in all 49.015";
        assert!(told.contains(expected), "{told}");
        let panels = panels(&budget, &STEPS, |k, px| px + DVec2::new(1000.0 * k as f64, 0.0));
        let panels: Vec<(&str, f64, f64)> =
            panels.iter().map(|p| (p.name.as_str(), p.dots[0].size, p.dots[1].at.x)).collect();
        let names = ["optics", "fit", "detector", "effects", "sampling", "measured − ideal"];
        let sizes = [1.0, 2.0, 4.0, 8.0, 16.0, 31.0];
        assert_eq!(panels, [0, 1, 2, 3, 4, 5].map(|k| (names[k], sizes[k], 1162.0)));
    }
}
