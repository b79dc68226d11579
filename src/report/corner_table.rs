//! `corners.csv` of a comparison: every corner of every judged prism, as measured, as it truly is, and as an ideal pinhole
//! would see it.

use crate::analysis::compare::JudgedDesign;
use crate::analysis::view::HalfView;
use crate::vision::half::Half;
use glam::DVec2;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The convention of the positions, and the columns.
const HEAD: &str = "# px of the whole picture; pixel (i, j) has its centre at (i + 0.5, j + 0.5)\n\
    design,half,column,row,measured_x_px,measured_y_px,true_x_px,true_y_px,ideal_x_px,ideal_y_px,\
    measured_minus_true_x_px,measured_minus_true_y_px,measured_minus_ideal_x_px,measured_minus_ideal_y_px\n";

/// The table as text. A corner that was not found has no measured position, one of a photograph no true one, and one of a half
/// without a virtual camera no ideal one: these are left empty.
pub fn text(judged: &[JudgedDesign]) -> String {
    let mut text = HEAD.to_owned();
    for design in judged {
        for (half, view) in Half::BOTH.into_iter().zip(&design.judgement.view.halves) {
            rows(&mut text, design, half, view);
        }
    }
    text
}

fn rows(text: &mut String, design: &JudgedDesign, half: Half, view: &HalfView) {
    let board = &design.judgement.view.board;
    let measured: BTreeMap<[i32; 2], DVec2> = view.found.iter().map(|f| (f.index, f.position_px)).collect();
    let truth = |index: &[i32; 2]| Some(view.truth.as_ref()?.get(index)?.position_px);
    let ideal = |[column, row]: [i32; 2]| {
        let corner = board.corner_at(f64::from(column), f64::from(row));
        view.ideal_px(board.world(corner))
    };
    let known: BTreeSet<[i32; 2]> =
        measured.keys().copied().chain(view.truth.iter().flat_map(|truth| truth.keys().copied())).collect();
    for index in known {
        let [measured, exact, ideal] = [measured.get(&index).copied(), truth(&index), ideal(index)];
        let minus = |from: Option<DVec2>| Some(measured? - from?);
        let places = [measured, exact, ideal].map(|px| px.map(|px| view.frame.full(px)));
        // Writing to a String cannot fail.
        let _ = write!(text, "{},{},{},{}", design.name, half.name(), index[0], index[1]);
        for pair in places.into_iter().chain([minus(exact), minus(ideal)]) {
            let _ = match pair {
                Some(v) => write!(text, ",{:?},{:?}", v.x, v.y),
                None => write!(text, ",,"),
            };
        }
        text.push('\n');
    }
}
