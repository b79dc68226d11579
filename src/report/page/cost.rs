//! The page of what accuracy costs: error over time, each kind of error on an axis of its own.

use super::origin::PageOrigin;
use super::shell::{self, Scripts};
use crate::analysis::cost::{CostStudy, Setting};
use crate::report::cost::{Machine, error_px, front, table};
use crate::report::number::number;
use serde::Serialize;
use serde_json::{Value, json};

/// What fills the template.
#[derive(Serialize)]
struct CostContext<'a> {
    title: &'a str,
    verdict: String,
    machine: String,
    table: String,
    charts: usize,
    origin: &'a PageOrigin,
}

/// A mark of a chart: time in ms, error, and what it is.
type Mark = (f64, f64, String);
/// The marks of one knob.
type KnobMarks<'a> = (&'a str, Vec<Mark>);
/// A chart: title, words of both axes, marks by knob, and the front that no other beats.
type CostChart<'a> = (&'a str, &'a str, &'a str, Vec<KnobMarks<'a>>, Vec<Mark>);

/// The page of `study`, which was taken on `machine`; `title` names the scene.
pub fn page(title: &str, scene: &str, machine: &Machine, study: &CostStudy, origin: &PageOrigin) -> String {
    let charts = charts(study);
    let context = CostContext {
        title,
        verdict: verdict(study),
        machine: machine.to_string(),
        table: table::text(scene, machine, study),
        charts: charts.len(),
        origin,
    };
    shell::page("cost.html", Scripts::Cost, &json!({ "charts": charts }).to_string(), &context)
}

/// The cheapest settings that keep to a tenth, a thousandth .. of a px, each with the finest of these that it keeps to.
fn verdict(study: &CostStudy) -> String {
    let front = front(&study.pictures);
    let mut told: Vec<(&Setting, f64)> = Vec::new();
    for px in [1e-1, 1e-3, 1e-5, 1e-7] {
        let Some(cheapest) = front.iter().copied().find(|setting| error_px(setting) <= px) else { continue };
        match told.last_mut() {
            Some(last) if std::ptr::eq(last.0, cheapest) => last.1 = px,
            _ => told.push((cheapest, px)),
        }
    }
    let words = |(setting, px): &(&Setting, f64)| {
        format!("{px} px: {} {} in {} ms", setting.knob, setting.value, number(Some(setting.time_ms.median)))
    };
    if told.is_empty() {
        return "No setting has lines of the board to judge it by.".to_owned();
    }
    format!(
        "The cheapest setting whose lines are right to {}.",
        told.iter().map(words).collect::<Vec<_>>().join("; to ")
    )
}

fn charts(study: &CostStudy) -> Vec<Value> {
    // Pictures: what no setting beats, and all settings by knob.
    let mut knobs: Vec<KnobMarks<'_>> = Vec::new();
    for setting in &study.pictures {
        let mark = (setting.time_ms.median, error_px(setting), format!("{} {}", setting.knob, setting.value));
        push(&mut knobs, setting.knob, mark);
    }
    let best: Vec<Mark> =
        front(&study.pictures).iter().map(|s| (s.time_ms.median, error_px(s), String::new())).collect();

    // Meshes, whose corners are judged; and designs.
    let (mut meshes, mut designs) = (Vec::new(), Vec::new());
    for mesh in &study.meshes {
        if let Some(corners) = mesh.corners_px {
            let mark = (mesh.time_ms.median, corners.max, format!("{} triangles, {}", mesh.triangles, mesh.normals));
            push(&mut meshes, mesh.normals, mark);
        }
    }
    for design in &study.designs {
        let mark = (design.time_ms.median, design.optical_path_spread_mm, format!("{} {}", design.knob, design.value));
        push(&mut designs, design.knob, mark);
    }
    let mut effects = Vec::new();
    for setting in &study.effects {
        let mark = (setting.time_ms.median, setting.rmse, format!("{} {}", setting.knob, setting.value));
        push(&mut effects, setting.effect, mark);
    }
    let charts: [CostChart<'_>; 4] = [
        ("A picture", "CPU time of a picture on one thread, ms", "largest shift of lines, px", knobs, best),
        ("A mesh prism, one ray a pixel", "CPU time, ms", "largest shift of corners, px", meshes, Vec::new()),
        ("A design", "CPU time of a design, ms", "spread of the optical path, mm", designs, Vec::new()),
        ("Lenses and triangles", "CPU time of a picture, ms", "RMSE, of full scale 1", effects, Vec::new()),
    ];
    let chart = |(title, x, y, series, front): CostChart<'_>| json!({ "title": title, "x": x, "y": y, "series": series, "front": front });
    charts.into_iter().filter(|chart| !chart.3.is_empty()).map(chart).collect()
}

/// Adds a mark that both axes can show to the series of that name.
fn push<'a>(series: &mut Vec<KnobMarks<'a>>, name: &'a str, mark: Mark) {
    if !(mark.0 > 0.0 && mark.1 > 0.0 && mark.1.is_finite()) {
        return;
    }
    match series.iter_mut().find(|(known, _)| *known == name) {
        Some((_, marks)) => marks.push(mark),
        None => series.push((name, vec![mark])),
    }
}
