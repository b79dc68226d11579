//! The study as one table of comma-separated values: a row per setting, whatever was turned.

use crate::analysis::cost::{CostStudy, DesignSetting, EffectSetting, Meshed, Setting, Shifts, Spread};

/// The columns. Times in ms, shifts in px; a field that does not apply is empty.
pub const HEADER: &str = "kind,knob,value,number,time_min_ms,time_median_ms,time_p90_ms,repetitions,yardsticks_median,\
    rays,edge_pixels,divided_pixels,cut_pixels,rmse,lines_rms_px,lines_p99_px,lines_max_px,corners_rms_px,\
    corners_p99_px,corners_max_px,found,found_p99_px,found_max_px,reprojection_rms_px,vertical_disparity_rms_px,\
    optical_path_spread_mm,fit_rms_mm,axis_mean_abs_mm";

/// [`HEADER`] and one line a setting. Every number reads back as the same f64.
pub fn text(study: &CostStudy) -> String {
    let mut lines = vec![HEADER.to_owned()];
    lines.extend(study.pictures.iter().map(picture));
    lines.extend(study.meshes.iter().map(mesh));
    lines.extend(study.designs.iter().map(design));
    lines.extend(study.effects.iter().map(effect));
    lines.join("\n") + "\n"
}

/// Some numbers and some that do not apply.
fn fields(values: &[Option<f64>]) -> String {
    values.iter().map(|v| v.map_or(String::new(), |v| v.to_string())).collect::<Vec<_>>().join(",")
}

fn start(kind: &str, knob: &str, value: &str, number: f64, time: Spread, yardsticks: Spread) -> String {
    // A knob's name may hold a comma.
    let Spread { min, median, p90, n } = time;
    format!("{kind},\"{knob}\",{value},{number},{min},{median},{p90},{n},{}", yardsticks.median)
}

fn shifts(shifts: Option<Shifts>) -> [Option<f64>; 3] {
    [shifts.map(|s| s.rms), shifts.map(|s| s.p99), shifts.map(|s| s.max)]
}

fn picture(s: &Setting) -> String {
    let counts = [s.counts.rays, s.counts.edge_pixels, s.counts.divided_pixels, s.counts.cut_pixels];
    let [_, p99, max] = shifts(s.measured.shifts_px);
    let mut values: Vec<Option<f64>> = counts.map(|n| Some(n as f64)).to_vec();
    values.push(Some(s.rmse));
    values.extend(shifts(s.lines_px));
    values.extend(shifts(s.corners_px));
    values.extend([Some(s.measured.corners as f64), p99, max]);
    values.extend([s.measured.reprojection_rms_px, s.measured.vertical_disparity_rms_px, None, None, None]);
    format!("{},{}", start("picture", s.knob, &s.value, s.number, s.time_ms, s.yardsticks), fields(&values))
}

fn mesh(m: &Meshed) -> String {
    let knob = format!("triangles, {} normals", m.normals);
    let mut values = vec![None; 8];
    values.extend(shifts(m.corners_px));
    values.extend([None, None, None, m.reprojection_rms_px, None, None, None, None]);
    let number = m.triangles as f64;
    format!("{},{}", start("mesh", &knob, &m.triangles.to_string(), number, m.time_ms, m.yardsticks), fields(&values))
}

fn effect(s: &EffectSetting) -> String {
    let mut values = vec![None; 4];
    values.push(Some(s.rmse));
    values.extend(shifts(s.lines_px));
    values.extend([None; 11]);
    let knob = format!("{}, {}", s.effect, s.knob);
    format!("{},{}", start("effect", &knob, &s.value, s.number, s.time_ms, s.yardsticks), fields(&values))
}

fn design(d: &DesignSetting) -> String {
    let mut values = vec![None; 14];
    values.extend([d.reprojection_rms_px, None, Some(d.optical_path_spread_mm), Some(d.fit_rms_mm)]);
    values.push(d.axis_mean_abs_mm);
    format!("{},{}", start("design", d.knob, &d.value, d.number, d.time_ms, d.yardsticks), fields(&values))
}
