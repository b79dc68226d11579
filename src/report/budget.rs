//! Error budgets as the report's entries, in words, and as the rows of a figure.

use super::figures::budget::{BudgetInput, BudgetPanel, BudgetRow, Dot, draw};
use super::json::{BudgetTerm, CornerBudget, ErrorBudget};
use crate::analysis::budget::{Budget, CornerErrors as Found};
use crate::analysis::compare::JudgedDesign;
use crate::num::stats;
use crate::plot::drawing::Drawing;
use crate::scene::Scene;
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

/// `budget.png`: where the error of each corner of the judged prisms comes from; `None` where no prism was judged.
pub fn figure(scene: &Scene, judged: &[JudgedDesign]) -> Option<Drawing> {
    let budgets: Vec<(String, &Budget)> =
        judged.iter().filter_map(|design| Some((format!("{} prism", design.name), design.budget.as_ref()?))).collect();
    let first = judged.first()?;
    let full = |k: usize, px: DVec2| first.judgement.view.halves[k].frame.full(px);
    let camera = &scene.camera;
    Some(draw(&BudgetInput {
        title: format!("{}: where the error of a corner comes from", scene.name),
        picture_px: DVec2::new(camera.width_px as f64, camera.height_px as f64),
        seam_px: 0.5 * camera.width_px as f64,
        rows: rows(&budgets, full),
        width_px: 2000,
    }))
}

/// Rows of a figure: for each budget, by its name, a panel for each step that some budget has, and the total. `full` puts a
/// half's px into the whole picture.
fn rows(budgets: &[(String, &Budget)], full: impl Fn(usize, DVec2) -> DVec2) -> Vec<BudgetRow> {
    let has = |of: fn(&Found) -> Option<DVec2>| {
        budgets.iter().flat_map(|(_, b)| b.halves.iter().flatten()).any(|c| of(c).is_some())
    };
    let steps: Vec<Step> = STEPS.into_iter().filter(|(_, of)| has(*of)).collect();
    let panel = |budget: &Budget, (name, of): &Step| BudgetPanel {
        name: (*name).to_owned(),
        dots: (0..2)
            .flat_map(|k| budget.halves[k].iter().map(move |c| (k, c)))
            .filter_map(|(k, c)| Some(Dot { at: full(k, c.measured_px), size: of(c)?.length() }))
            .collect(),
    };
    let row = |(name, budget): &(String, &Budget)| BudgetRow {
        name: name.clone(),
        panels: steps.iter().map(|step| panel(budget, step)).collect(),
    };
    budgets.iter().map(row).collect()
}
