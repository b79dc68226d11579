//! The study as a table to read.

use super::document::{Machine, front};
use crate::analysis::cost::{CostStudy, Setting};
use std::fmt::Write;

/// The whole table.
pub fn text(scene: &str, machine: &Machine, study: &CostStudy) -> String {
    let [width, height] = study.size_px;
    let yard = study.yardstick_ns;
    let mut text = format!(
        "What accuracy costs: scene {scene}, {width} x {height} px, {} corners\n{machine}\n\
         CPU time on one thread, all settings in one interleaved run; yardsticks: time over that of a fixed f64 trace of one \
         ray a pixel, taken right before ({:.1} ns a ray, {:.1} .. {:.1})\n\
         The reference says of itself: {}\n",
        study.corners, yard.median, yard.min, yard.p90, study.reference
    );
    pictures(&mut text, study);
    meshes(&mut text, study);
    designs(&mut text, study);
    effects(&mut text, study);
    text
}

/// A number of three digits, or a dash.
fn short(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(v) if (1e-3..1e4).contains(&v.abs()) => {
            let decimals = if v.abs() < 1.0 { 5 } else { 3 };
            format!("{v:.decimals$}")
        }
        Some(v) => format!("{v:.1e}"),
    }
}

fn pictures(text: &mut String, study: &CostStudy) {
    let best = front(&study.pictures);
    let _ = writeln!(
        text,
        "\n{:21} {:>10}  {:>8} {:>8} {:>8} {:>10}  {:>9} {:>8} {:>8} {:>9} {:>8} {:>8} {:>8} {:>8}",
        "pictures",
        "",
        "ms",
        "to p90",
        "yardst.",
        "rays",
        "RMSE",
        "line p99",
        "line max",
        "corn. p99",
        "corner",
        "found",
        "reproj.",
        "v. disp."
    );
    let mut knob = "";
    for s in &study.pictures {
        let name = if s.knob == knob { "" } else { s.knob };
        knob = s.knob;
        let mark = if best.iter().any(|b| std::ptr::eq::<Setting>(*b, s)) { '*' } else { ' ' };
        let _ = writeln!(
            text,
            "{name:21} {:>10}{mark} {:>8} {:>8} {:>8} {:>10}  {:>9} {:>8} {:>8} {:>9} {:>8} {:>8} {:>8} {:>8}",
            s.value,
            short(Some(s.time_ms.median)),
            short(Some(s.time_ms.p90)),
            short(Some(s.yardsticks.median)),
            s.counts.rays,
            short(Some(s.rmse)),
            short(s.lines_px.map(|l| l.p99)),
            short(s.lines_px.map(|l| l.max)),
            short(s.corners_px.map(|c| c.p99)),
            short(s.corners_px.map(|c| c.max)),
            short(s.measured.shifts_px.map(|c| c.max)),
            short(s.measured.reprojection_rms_px),
            short(s.measured.vertical_disparity_rms_px),
        );
    }
    text.push_str(
        "* on the Pareto front of time and line max. px: line = shift of the board's lines, from the pixels; corner = largest \
         error of what a corner's\n  exact position sees; found = largest shift of a detected corner; reproj. = RMS of the \
         found corners from the designed virtual cameras\n",
    );
}

fn meshes(text: &mut String, study: &CostStudy) {
    if study.meshes.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "\n{:21} {:>10}  {:>8} {:>8} {:>8} {:>10}  {:>9} {:>8} {:>8} {:>6}",
        "the prism as a mesh",
        "triangles",
        "ms",
        "to p90",
        "yardst.",
        "build ms",
        "corn. p99",
        "corner",
        "reproj.",
        "lost"
    );
    for m in &study.meshes {
        let _ = writeln!(
            text,
            "{:21} {:>10}  {:>8} {:>8} {:>8} {:>10}  {:>9} {:>8} {:>8} {:>6}",
            format!("{} normals", m.normals),
            m.triangles,
            short(Some(m.time_ms.median)),
            short(Some(m.time_ms.p90)),
            short(Some(m.yardsticks.median)),
            short(Some(m.build_ms)),
            short(m.corners_px.map(|c| c.p99)),
            short(m.corners_px.map(|c| c.max)),
            short(m.reprojection_rms_px),
            m.lost
        );
    }
    text.push_str("one ray a pixel, from a sample of the right half; what orders the triangles is built once\n");
}

fn designs(text: &mut String, study: &CostStudy) {
    if study.designs.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "\n{:21} {:>10}  {:>8} {:>8} {:>8} {:>10}  {:>9} {:>8} {:>8} {:>8}",
        "designs", "", "ms", "to p90", "yardst.", "points", "path, mm", "fit, mm", "axis, mm", "reproj."
    );
    let mut knob = "";
    for d in &study.designs {
        let name = if d.knob == knob { "" } else { d.knob };
        knob = d.knob;
        let _ = writeln!(
            text,
            "{name:21} {:>10}  {:>8} {:>8} {:>8} {:>10}  {:>9} {:>8} {:>8} {:>8}",
            d.value,
            short(Some(d.time_ms.median)),
            short(Some(d.time_ms.p90)),
            short(Some(d.yardsticks.median)),
            d.points,
            short(Some(d.optical_path_spread_mm)),
            short(Some(d.fit_rms_mm)),
            short(d.axis_mean_abs_mm),
            short(d.reprojection_rms_px),
        );
    }
    text.push_str(
        "path = spread of the optical path, the error of the integration; axis = mean distance of the back-extended rays from \
         the virtual centre (Fig. 4b)\n",
    );
}

fn effects(text: &mut String, study: &CostStudy) {
    if study.effects.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "\n{:21} {:>10}  {:>8} {:>8} {:>8}  {:>9} {:>8} {:>8}",
        "effects", "", "ms", "to p90", "yardst.", "RMSE", "line p99", "line max"
    );
    let mut before = ("", "");
    for s in &study.effects {
        let of = (s.effect, s.knob);
        let name = if of == before { String::new() } else { format!("{}, {}", s.effect, s.knob) };
        before = of;
        let _ = writeln!(
            text,
            "{name:21} {:>10}  {:>8} {:>8} {:>8}  {:>9} {:>8} {:>8}",
            s.value,
            short(Some(s.time_ms.median)),
            short(Some(s.time_ms.p90)),
            short(Some(s.yardsticks.median)),
            short(Some(s.rmse)),
            short(s.lines_px.map(|l| l.p99)),
            short(s.lines_px.map(|l| l.max)),
        );
    }
    text.push_str("against a finer picture with the same effect: more points of the pupil, or the level reference\n");
}
