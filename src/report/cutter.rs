//! What a cutter asks of a prism, as a table and as JSON.

use super::number::{number, rounded};
use crate::analysis::cutter::{CutterSheet, ErrorSensitivity, Floor, LawResidual, SurfaceForm, recalibrated_rss_px};
use crate::scene::PrismLaw;
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// A sheet with what it belongs to.
#[derive(Debug, Clone, Copy)]
pub struct CutterReport<'a> {
    /// What the halves are meant to be.
    pub law: &'a PrismLaw,
    /// What is so.
    pub sheet: &'a CutterSheet,
    /// Whether more coefficients would leave less, where that was tried.
    pub floor: Option<Floor>,
}

/// The law by its keys.
pub fn law_json(law: &PrismLaw) -> Value {
    let focal = ("f_mm".to_owned(), json!(law.focal_mm));
    let others = law.keys().into_iter().map(|(key, value)| (key.to_owned(), json!(value)));
    Value::Object(std::iter::once(focal).chain(others).collect::<Map<_, _>>())
}

impl CutterReport<'_> {
    /// All numbers; `null` where a radius or a depth is infinite.
    pub fn to_json(&self) -> Value {
        let CutterSheet { residuals, surfaces: [front, back], glass, spot, sensitivities, .. } = self.sheet;
        json!({
            "residuals": residuals.iter().map(residual_json).collect::<Vec<_>>(),
            "floor": self.floor.map(|floor| {
                json!({"degree": floor.degree, "rms_px": floor.rms_px, "reached": floor.reached})
            }),
            "surfaces": {"front": surface_json(front), "back": surface_json(back)},
            "glass": {
                "centre_mm": glass.centre_mm,
                "edge_mm": glass.edge_mm,
                "crossing_columns": glass.crossing_columns,
                "one_back": glass.one_back,
            },
            "spot": {
                "f_number": spot.f_number,
                "stated": spot.stated,
                "depth_mm": spot.depth_mm,
                "rms_px": spot.rms_px,
                "best_rms_px": spot.best_rms_px,
                "refocus_dpt": spot.refocus_dpt,
            },
            "sensitivities": sensitivities.iter().map(sensitivity_json).collect::<Vec<_>>(),
            "recalibrated_rss_px": recalibrated_rss_px(sensitivities),
        })
    }

    /// The table.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let mut row = |label: &str, words: String| {
            let _ = writeln!(text, "{label:32}  {words}");
        };
        row("law", law_words(self.law));
        for residual in &self.sheet.residuals {
            row(&format!("left of the law {}", depth_words(residual.depth_mm)), residual_words(residual));
        }
        if let Some(floor) = self.floor {
            row("with two degrees more", floor_words(floor));
        }
        for (name, surface) in ["front", "rear"].into_iter().zip(&self.sheet.surfaces) {
            row(name, surface_words(surface));
        }
        let glass = &self.sheet.glass;
        row("glass at the centre, at the edge", format!("{:.3} mm, {:.3} mm", glass.centre_mm, glass.edge_mm));
        row("columns that cross x = 0", crossing_words(glass.crossing_columns, glass.one_back));
        row("spot", self.spot_words());
        text.push('\n');
        text + &sensitivity_table(&self.sheet.sensitivities)
    }

    fn spot_words(&self) -> String {
        let spot = &self.sheet.spot;
        let whose = if spot.stated { "the scene's lens" } else { "a thin lens, the scene states none" };
        format!(
            "RMS {} px at f/{} ({whose}) focused at {} mm, {} px refocused by {:+.2} dpt",
            number(Some(spot.rms_px)),
            rounded(spot.f_number),
            rounded(spot.depth_mm),
            number(Some(spot.best_rms_px)),
            spot.refocus_dpt
        )
    }
}

fn residual_json(residual: &LawResidual) -> Value {
    json!({
        "depth_mm": residual.depth_mm.is_finite().then_some(residual.depth_mm),
        "rms_u_px": residual.rms_px.x,
        "rms_v_px": residual.rms_px.y,
        "rms_px": residual.both_rms_px,
        "max_px": residual.max_px,
    })
}

fn surface_json(surface: &SurfaceForm) -> Value {
    json!({
        "departure_mm": surface.departure_mm,
        "from_sphere_mm": surface.from_sphere_mm,
        "slope_max_deg": surface.slope_max_deg,
        "radius_min_mm": surface.radius_min_mm,
    })
}

fn sensitivity_json(sensitivity: &ErrorSensitivity) -> Value {
    json!({
        "error": sensitivity.error,
        "raw_u_px": sensitivity.raw_px.x,
        "raw_v_px": sensitivity.raw_px.y,
        "vertical_px": sensitivity.vertical_px,
        "recalibrated_px": sensitivity.recalibrated_px,
    })
}

fn law_words(law: &PrismLaw) -> String {
    let [f_x, f_y] = law.focal_mm.map(rounded);
    let others = law.keys().into_iter().map(|(key, value)| format!(", {key} = {}", axis_number(value)));
    others.fold(format!("f_mm = [{f_x}, {f_y}]"), |words, other| words + &other)
}

/// A number without what it does not need.
fn axis_number(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { rounded(value) }
}

fn depth_words(depth_mm: f64) -> String {
    if depth_mm.is_finite() { format!("at {} mm", rounded(depth_mm)) } else { "at infinity".to_owned() }
}

fn residual_words(residual: &LawResidual) -> String {
    let [u, v, both, max] = [residual.rms_px.x, residual.rms_px.y, residual.both_rms_px, residual.max_px];
    format!(
        "RMS {} px (u {}, v {}), largest {} px",
        number(Some(both)),
        number(Some(u)),
        number(Some(v)),
        number(Some(max))
    )
}

fn floor_words(floor: Floor) -> String {
    let told = if floor.reached { "a floor is reached" } else { "no floor is reached" };
    format!("RMS {} px (degree {}): {told}", number(Some(floor.rms_px)), floor.degree)
}

fn surface_words(surface: &SurfaceForm) -> String {
    format!(
        "departs {:.4} mm from its best plane, {:.4} mm from its best sphere (highest less lowest); slope up to {:.2} deg; {}",
        surface.departure_mm,
        surface.from_sphere_mm,
        surface.slope_max_deg,
        surface.radius_min_mm.map_or_else(|| "flat".to_owned(), |mm| format!("smallest radius {} mm", rounded(mm)))
    )
}

fn crossing_words(columns: usize, one_back: bool) -> String {
    match (columns, one_back) {
        (0, _) => "none".to_owned(),
        (n, true) => format!("{n} of each half, harmless: both halves have one rear surface"),
        (n, false) => {
            format!("{n} of each half next to the ridge: in one piece of glass they look through the other half's rear")
        }
    }
}

/// The table of errors of manufacture.
fn sensitivity_table(all: &[ErrorSensitivity]) -> String {
    let mut text = format!(
        "{:32}  {:>10}  {:>10}  {:>10}  {:>14}",
        "error of manufacture, px RMS", "raw in u", "raw in v", "vertical", "recalibrated"
    );
    for one in all {
        let [u, v, vertical, left] = [one.raw_px.x, one.raw_px.y, one.vertical_px, one.recalibrated_px].map(short);
        let _ = write!(text, "\n{:32}  {u:>10}  {v:>10}  {vertical:>10}  {left:>14}", one.error);
    }
    let rss = short(recalibrated_rss_px(all));
    let _ = writeln!(text, "\n{:32}  {:>10}  {:>10}  {:>10}  {rss:>14}", "root of the sum of squares", "", "", "");
    text
}

/// A number of px in a table of these.
fn short(px: f64) -> String {
    if px < 1e-9 { "0".to_owned() } else { number(Some(px)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn what_crosses_is_told_by_what_it_meets() {
        assert_eq!(crossing_words(0, false), "none");
        assert!(crossing_words(31, true).contains("harmless") && !crossing_words(41, false).contains("harmless"));
    }

    #[test]
    fn a_floor_is_what_two_degrees_do_not_lower() {
        // What is exact falls a hundredfold, what is not stays.
        let left = |px: f64| {
            [px, 0.5 * px].map(|px| LawResidual {
                depth_mm: 300.0,
                rms_px: DVec2::splat(px),
                both_rms_px: px,
                max_px: px,
            })
        };
        assert!(!Floor::of(7, 3e-4, &left(3e-6)).reached && Floor::of(7, 0.81, &left(0.80)).reached);
        assert!(floor_words(Floor::of(7, 0.81, &left(0.80))).contains("a floor is reached"));
    }
}
