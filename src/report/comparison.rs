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

/// `overview.png`: prisms side by side, and what a matcher would see of them, without a table.
pub fn overview(judged: &[JudgedDesign]) -> Drawing {
    drawn(judged, Vec::new(), String::new())
}

/// `comparison.png`: the same with the table of the `entries` in the report and the sentence that judges them.
pub fn figure(judged: &[JudgedDesign], entries: &[Design], verdict: &str) -> Drawing {
    let row = |row: table::Shown| FigureRow { label: row.short_label, values: row.short };
    let verdict = match table::depths(entries) {
        Some(depths) => format!("{verdict} ({depths}.)"),
        None => verdict.to_owned(),
    };
    drawn(judged, table::rows(entries).into_iter().map(row).collect(), verdict)
}

fn drawn(judged: &[JudgedDesign], figures: Vec<FigureRow>, verdict: String) -> Drawing {
    let marks: Vec<Vec<CornerMark>> = judged.iter().map(|design| corner_marks(&design.judgement)).collect();
    let panels = judged.iter().zip(&marks).map(|(design, corners)| Panel {
        name: format!("{} prism", design.name),
        picture: &design.film.radiance,
        corners,
        seam_px: 0.5 * design.scene.camera.width_px as f64,
        found: design.judgement.view.halves.iter().map(|half| half.found.len()).sum(),
    });
    let panels: Vec<Panel> = panels.collect();
    comparison::draw(&ComparisonInput {
        title: title(judged),
        arrow_gain: comparison::suitable_gain(&panels),
        panels,
        figures,
        verdict,
        width_px: 2000,
    })
}

/// What a comparison shows: the scene where it is one, the board where it is one, and how many prisms.
pub fn title(judged: &[JudgedDesign]) -> String {
    let one = |of: &dyn Fn(&Scene) -> String| {
        let mut all: Vec<String> = judged.iter().map(|design| of(&design.scene)).collect();
        all.dedup();
        if all.len() == 1 { all.pop() } else { None }
    };
    let board = |scene: &Scene| {
        let square = table::rounded(scene.board.square_mm);
        let depth = scene.board.world_from_board.translation_mm.z - scene.camera.position_mm.z;
        format!("{square} mm squares at {} mm", table::rounded(depth))
    };
    let name = one(&|scene| scene.name.clone()).map_or_else(String::new, |name| format!("{name}: "));
    let board = one(&board).unwrap_or_else(|| "a board each".to_owned());
    let prisms = match judged.len() {
        1 => "a prism".to_owned(),
        2 => "two prisms".to_owned(),
        3 => "three prisms".to_owned(),
        n => format!("{n} prisms"),
    };
    format!("{name}{board}, seen through {prisms}")
}

/// Detected corners of both halves with their deviation from the designed virtual camera.
fn corner_marks(judgement: &Judgement) -> Vec<CornerMark> {
    let board = &judgement.view.board;
    let of_half = |half: &HalfView| {
        let mark = |f: &Found| {
            let [column, row] = f.index.map(f64::from);
            let ideal = half.ideal_px(board.world(board.corner_at(column, row)))?;
            Some(CornerMark {
                index: f.index,
                position_px: half.frame.full(f.position_px),
                error_px: f.position_px - ideal,
            })
        };
        half.found.iter().filter_map(mark).collect::<Vec<_>>()
    };
    judgement.view.halves.iter().flat_map(of_half).collect()
}
