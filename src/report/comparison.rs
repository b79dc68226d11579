//! A comparison of prisms as entries of a report, and as a figure.

use super::figures::comparison::{self, ComparisonInput, CornerMark, FigureRow, Panel};
use super::json::{self, Design};
use super::{budget, design, fit, table};
use crate::analysis::board_indexing::Found;
use crate::analysis::compare::{Comparison, JudgedDesign};
use crate::analysis::fates::fates;
use crate::analysis::fit_shift::fit_shifts;
use crate::analysis::judge::Judgement;
use crate::analysis::view::HalfView;
use crate::plot::drawing::Drawing;
use crate::scene::Scene;
use std::collections::BTreeMap;

/// The report of a comparison, without times.
pub fn report(scene: &Scene, comparison: &Comparison) -> json::Report {
    let designs = comparison.designs.iter().map(|judged| entry(judged, BTreeMap::new())).collect();
    json::Report { schema: json::SchemaName::V1, scene: scene.name.clone(), designs }
}

/// The entry of a judged prism, with the seconds that each step took.
pub fn entry(judged: &JudgedDesign, timing_s: BTreeMap<String, f64>) -> Design {
    let JudgedDesign { name, scene, system, film, judgement, .. } = judged;
    let own = design::entry(
        name,
        judgement,
        &film.class.as_ref().map(fates).unwrap_or_default(),
        timing_s,
        scene.camera.pitch_mm,
    );
    Design {
        accuracy: Some(design::accuracy(&film.account, &film.counts)),
        error_budget: judged.budget.as_ref().map(budget::entry),
        surface_fits: fit_shifts(scene, system).map(|fits| fit::entry(&fits)),
        ..design::of_own_picture(own, scene, system)
    }
}

/// `comparison.png`: two prisms side by side, with their `entries` in the report and the sentence that judges them.
pub fn figure(scene: &Scene, judged: [&JudgedDesign; 2], entries: &[Design], verdict: &str) -> Drawing {
    let marks = judged.map(|design| corner_marks(&design.judgement));
    let panels = [0, 1].map(|k| Panel {
        name: format!("{} prism", judged[k].name),
        picture: &judged[k].film.radiance,
        corners: &marks[k],
    });
    let seam_px = 0.5 * scene.camera.width_px as f64;
    let rows = table::rows(entries).into_iter();
    let rows =
        rows.map(|row| FigureRow { label: row.short_label, values: [row.short[0].clone(), row.short[1].clone()] });
    comparison::draw(&ComparisonInput {
        title: format!(
            "{}: {} mm squares at {} mm, seen through two prisms",
            scene.name,
            table::rounded(scene.board.square_mm),
            table::rounded(scene.board.world_from_board.translation_mm.z - scene.camera.position_mm.z)
        ),
        arrow_gain: comparison::suitable_gain(&panels, seam_px),
        panels,
        seam_px,
        figures: rows.collect(),
        verdict: match table::depths(entries) {
            Some(depths) => format!("{verdict} ({depths}.)"),
            None => verdict.to_owned(),
        },
        width_px: 2000,
    })
}

/// Detected corners of both halves with their deviation from the designed virtual camera.
fn corner_marks(judgement: &Judgement) -> Vec<CornerMark> {
    let board = &judgement.view.board;
    let of_half = |half: &HalfView| {
        let Ok(camera) = half.camera else { return Vec::new() };
        let mark = |f: &Found| {
            let [column, row] = f.index.map(f64::from);
            let ideal = camera.project(board.world(board.corner_at(column, row)))?;
            Some(CornerMark {
                index: f.index,
                position_px: half.frame.full(f.position_px),
                error_px: f.position_px - ideal,
            })
        };
        half.found.iter().filter_map(mark).collect()
    };
    judgement.view.halves.iter().flat_map(of_half).collect()
}
