//! `biprism design`: the freeform prism of a scene, as scene text and as points.

use super::args::DesignArgs;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, output};
use crate::analysis::cutter::{self, CutterSheet, Floor};
use crate::design::{self, DesignInput, FreeformDesign, text};
use crate::error::Error;
use crate::io::atomic::write_atomically;
use crate::io::point_grid::{write_csv, write_ply};
use crate::plot::svg;
use crate::report::cutter::{CutterReport, law_json};
use crate::report::figures;
use crate::scene::{DESIGN_DEGREE, DesignSettings, GlassSpec, MarchOrder, PrismLaw, Scene};
use crate::surface::face::Face;
use crate::system::with_room_for;
use glam::DVec2;
use std::path::Path;

pub(super) fn run(args: &DesignArgs) -> Result<Outcome, Error> {
    let scene = files::load(&args.scene)?;
    let mut input = DesignInput::of(&scene).ok_or_else(|| {
        Error::new(
            files::shown(&args.scene),
            "`prism.kind` must be \"flat\" or \"freeform\" for a prism to be designed",
            "state index, ridge_distance_mm and thickness_mm, with kind = \"freeform\"",
        )
    })?;
    input.settings.objective = args.objective.map_or(input.settings.objective, Into::into);
    input.settings.degree = args.degree.map_or(input.settings.degree, |degree| degree as usize);
    if args.y_then_x {
        input.settings.order = MarchOrder::YThenX;
    }
    let paths = files::outputs(&args.out, &["prism.toml", "cloud.csv", "front.ply", "back.ply"])?;
    args.figure.as_deref().map_or(Ok(()), checked)?;
    let progress = Progress::new(0);
    progress.begin(&scene.name, "design");
    let designed = design::freeform(&input)?;
    progress.begin(&scene.name, "write");
    let cloud = &designed.cloud;
    // As large as the rays of the scene need it, not those of the design alone.
    let law = input.prism.body.law.unwrap_or_else(|| designed.law());
    progress.begin(&scene.name, "measure");
    let looked = looked_at(&scene, &input, &designed);
    let body = GlassSpec { law: Some(law), ..input.prism.body };
    let exported = with_room_for(designed.prism(body), &input.prism, &scene.camera, &scene.effects);
    let text = text::scene_prism(&exported.front, &exported.back, &body);
    files::text(&paths[0], &text)?;
    write_atomically(&paths[1], |out| write_csv(cloud.points(), out))?;
    for (path, face) in [(&paths[2], Face::Front), (&paths[3], Face::Back)] {
        let size = [cloud.columns(), cloud.rows()];
        write_atomically(path, |out| write_ply(size, cloud.points(), face, out))?;
    }
    drop(progress);
    let words =
        if args.json { json(&designed, &law, looked.as_ref()) } else { words(&designed, &law, looked.as_ref()) };
    output::stdout(&words)?;
    if let (Some(path), Some((sheet, _))) = (&args.figure, &looked) {
        figure(path, &scene, sheet)?;
        output::stderr(&format!("wrote {}", path.display()));
    }
    paths.iter().for_each(|path| output::stderr(&format!("wrote {}", path.display())));
    output::stderr("prism.toml is the [prism] part of a scene: put it beside a camera and a board");
    Ok(Outcome::Done)
}

/// What a cutter asks of the design, and whether two degrees more would leave less; nothing, and why, where its rays do not tell.
fn looked_at(scene: &Scene, input: &DesignInput, designed: &FreeformDesign) -> Option<(CutterSheet, Option<Floor>)> {
    let of = |designed: &FreeformDesign| cutter::of_design(scene, &input.prism, designed);
    let sheet = match cutter::sheet(&of(designed), cutter::Z_MIN_MM) {
        Ok(sheet) => sheet,
        Err(why) => {
            output::stderr(&format!("note: what a cutter asks is not known: {}", why.rule));
            return None;
        }
    };
    let degree = input.settings.degree + 2;
    let settings = DesignSettings { degree, ..input.settings };
    let next = (degree <= DESIGN_DEGREE).then(|| design::freeform(&DesignInput { settings, ..*input }).ok()).flatten();
    let next = next.and_then(|next| cutter::residuals(&of(&next), cutter::Z_MIN_MM).ok());
    let floor = next.map(|next| Floor::of(degree, sheet.rms_px(), &next));
    Some((sheet, floor))
}

fn json(designed: &FreeformDesign, law: &PrismLaw, looked: Option<&(CutterSheet, Option<Floor>)>) -> String {
    let (camera, front, back) = (&designed.camera, &designed.front, &designed.back);
    let cutter = looked.map(|(sheet, floor)| CutterReport { law, sheet, floor: *floor }.to_json());
    let figures = serde_json::json!({
        "facet_angle_deg": camera.alpha_rad.to_degrees(),
        "half_angle_deg": camera.delta_rad.to_degrees(),
        "baseline_mm": camera.baseline_mm(),
        "virtual_camera_mm": camera.centre_mm.to_array(),
        "law": law_json(law),
        "points": designed.cloud.len(),
        "optical_path_spread_mm": designed.optical_path_spread_mm,
        "front": {"rms_mm": front.rms_mm, "max_mm": front.max_mm, "condition": front.condition},
        "back": {"rms_mm": back.rms_mm, "max_mm": back.max_mm, "condition": back.condition},
        "cutter": cutter,
    });
    format!("{figures:#}\n")
}

fn words(designed: &FreeformDesign, law: &PrismLaw, looked: Option<&(CutterSheet, Option<Floor>)>) -> String {
    let (camera, front, back) = (&designed.camera, &designed.front, &designed.back);
    let rows = [
        ("facet angle", format!("{:.5} deg", camera.alpha_rad.to_degrees())),
        ("baseline", format!("{:.4} mm", camera.baseline_mm())),
        ("points", designed.cloud.len().to_string()),
        ("optical path, spread", format!("{:.1e} mm", designed.optical_path_spread_mm)),
        ("front fit, RMS and max", format!("{:.2e}, {:.2e} mm", front.rms_mm, front.max_mm)),
        ("rear fit, RMS and max", format!("{:.2e}, {:.2e} mm", back.rms_mm, back.max_mm)),
    ];
    let text: String = rows.iter().map(|(label, value)| format!("{label:32}  {value}\n")).collect();
    let cutter = looked.map(|(sheet, floor)| CutterReport { law, sheet, floor: *floor }.to_text());
    text + &cutter.unwrap_or_default()
}

/// Draws the design into a PNG or an SVG, by the ending of `path`.
fn figure(path: &Path, scene: &Scene, sheet: &CutterSheet) -> Result<(), Error> {
    let half_px = DVec2::new(0.5 * scene.camera.width_px as f64, scene.camera.height_px as f64);
    let drawing = figures::cutter::draw(sheet, half_px);
    match ending(path).as_deref() {
        Some("svg") => files::text(path, &svg::write(&drawing, &figures::cutter::title(&scene.name))),
        _ => files::drawing(path, &drawing),
    }
}

fn ending(path: &Path) -> Option<String> {
    path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase())
}

/// That the figure may be written.
fn checked(figure: &Path) -> Result<(), Error> {
    if !matches!(ending(figure).as_deref(), Some("png" | "svg")) {
        let rule = format!("`{}` ends in neither .png nor .svg", figure.display());
        return Err(Error::new("--figure", rule, "name a .png or a .svg"));
    }
    let name = figure.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    files::outputs(figure.parent().unwrap_or(Path::new("")), &[&name]).map(drop)
}
