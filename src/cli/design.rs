//! `biprism design`: the freeform prism of a scene, as scene text, as points and as a body, with what a cutter asks.

use super::design_args::{CloudArg, DesignArgs};
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, output};
use crate::analysis::cutter::{self, CutterSheet, Floor};
use crate::design::{self, DesignInput, FreeformDesign, text};
use crate::error::Error;
use crate::io::atomic::write_atomically;
use crate::io::inputs::check_outputs;
use crate::io::point_grid::{write_csv, write_ply};
use crate::io::solid::SolidFormat;
use crate::plot::svg;
use crate::report::cutter::{CutterReport, law_json};
use crate::report::figures;
use crate::scene::{DESIGN_DEGREE, DesignSettings, DesignedSurface, GlassSpec, MarchOrder, PrismLaw, PrismSpec, Scene};
use crate::surface::face::Face;
use crate::system::crossing::Crossing;
use crate::system::{self, System, revolved_with_room, with_room_for};
use glam::DVec2;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// What a cutter asks of a design, and whether two degrees more would leave less.
type Looked = (CutterSheet, Option<Floor>);

pub(super) fn run(args: &DesignArgs) -> Result<Outcome, Error> {
    let scene = files::load(&args.scene, &args.values)?;
    let input = asked(&scene, args)?;
    let scene = Scene { prism: PrismSpec::Freeform(input.prism, input.settings), ..scene };
    scene.check()?;
    let body = match args.solid.as_deref() {
        Some(path) => Some((path, SolidFormat::of(path)?)),
        None => None,
    };
    let revolved = input.settings.surface == DesignedSurface::Revolved;
    let texts_of: &[&str] = if revolved { &["prism.toml", "prism_polynomial.toml"] } else { &["prism.toml"] };
    let clouds = clouds(args);
    let cloud_names: Vec<&str> = clouds.iter().map(|(name, _)| *name).collect();
    let mut paths = files::outputs(&args.out, &[texts_of, &cloud_names].concat())?;
    let all: Vec<PathBuf> = paths.iter().cloned().chain(args.solid.clone()).collect();
    check_outputs(&all)?;
    args.figure.as_deref().map_or(Ok(()), checked)?;

    // Design.
    let progress = Progress::new(0);
    let made = made(&scene, &input, &|stage| progress.begin(&scene.name, stage))?;
    if let Err(why) = &made.looked {
        output::stderr(&format!("note: what a cutter asks is not known: {}", why.rule));
    }

    // Write what was designed.
    progress.begin(&scene.name, "write");
    for (path, (text, _)) in paths.iter().zip(&made.texts) {
        files::text(path, text)?;
    }
    let points = &made.designed.cloud;
    for (path, (_, face)) in paths[texts_of.len()..].iter().zip(&clouds) {
        write_atomically(path, |out| match face {
            Some(face) => write_ply([points.columns(), points.rows()], points.points(), *face, out),
            None => write_csv(points.points(), out),
        })?;
    }
    if let Some((path, format)) = body {
        format.write(path, &system::solid::solid(&made.system, system::solid::CELLS)?)?;
        paths.push(path.to_owned());
    }
    if let (Some(path), Ok((sheet, _))) = (&args.figure, &made.looked) {
        figure(path, &scene.name, sheet, half_px(&scene))?;
        paths.push(path.clone());
    }
    drop(progress);
    output::stdout(&if args.json { format!("{:#}\n", made.json()) } else { made.words() })?;
    paths.iter().for_each(|path| output::stderr(&format!("wrote {}", path.display())));
    output::stderr("prism.toml is the [prism] part of a scene: put it beside a camera and a board");
    Ok(Outcome::Done)
}

/// The figures of the design of `scene`, as `--json` prints them, and the text of `prism.toml`.
pub(super) fn figures_and_prism(scene: Scene, args: &DesignArgs) -> Result<(Value, String), Error> {
    let input = asked(&scene, args)?;
    let scene = Scene { prism: PrismSpec::Freeform(input.prism, input.settings), ..scene };
    scene.check()?;
    let made = made(&scene, &input, &|_| ())?;
    let prism = made.texts.first().map(|(text, _)| text.clone()).unwrap_or_default();
    Ok((made.json(), prism))
}

/// A design, and what is known of it.
struct MadeDesign {
    designed: FreeformDesign,
    law: PrismLaw,
    /// The prisms that it becomes, with their texts.
    texts: Vec<(String, PrismSpec)>,
    looked: Result<Looked, Error>,
    /// The instrument with the first of these.
    system: System,
    crossing: Option<Crossing>,
}

/// Designs what is asked of `scene`; `stage` hears what is done next.
fn made(scene: &Scene, input: &DesignInput, stage: &dyn Fn(&'static str)) -> Result<MadeDesign, Error> {
    stage("design");
    let designed = design::freeform(input)?;
    let law = input.prism.body.law.unwrap_or_else(|| designed.law());
    let texts = texts(scene, input, &designed, law)?;
    stage("measure");
    let looked = looked_at(scene, input, &designed);
    let prism = texts.first().map_or(PrismSpec::None, |(_, prism)| prism.clone());
    let system = system::ideal(&Scene { prism, ..scene.clone() })?;
    let crossing = Crossing::of(&system);
    Ok(MadeDesign { designed, law, texts, looked, system, crossing })
}

/// The names of the files of points that are asked for, each with the one face that it has or both.
fn clouds(args: &DesignArgs) -> Vec<(&'static str, Option<Face>)> {
    let asked = |format| args.cloud.contains(&format);
    let csv = [("cloud.csv", None)].into_iter().filter(|_| asked(CloudArg::Csv));
    let ply = [("front.ply", Some(Face::Front)), ("back.ply", Some(Face::Back))];
    csv.chain(ply.into_iter().filter(|_| asked(CloudArg::Ply))).collect()
}

/// What is designed: what the scene says, or the arguments instead.
fn asked(scene: &Scene, args: &DesignArgs) -> Result<DesignInput, Error> {
    let mut input = DesignInput::of(scene).ok_or_else(|| {
        Error::new(
            files::shown(&args.scene),
            "`prism.kind` must be \"flat\" or \"freeform\" for a prism to be designed",
            "state index, ridge_distance_mm and thickness_mm, with kind = \"freeform\"",
        )
    })?;
    let settings = &mut input.settings;
    settings.objective = args.objective.map_or(settings.objective, Into::into);
    settings.surface = args.surface.map_or(settings.surface, Into::into);
    settings.goal.rear = args.rear.map_or(settings.goal.rear, Into::into);
    settings.degree = args.degree.map_or(settings.degree, |degree| degree as usize);
    settings.step_px = args.step_px.unwrap_or(settings.step_px);
    if args.y_then_x {
        settings.order = MarchOrder::YThenX;
    }
    Ok(input)
}

/// The prisms of a design and their texts, as large as the rays of the scene need them, not those of the design alone: the one
/// that it becomes, and of surfaces of revolution the polynomials through them.
fn texts(
    scene: &Scene,
    input: &DesignInput,
    designed: &FreeformDesign,
    law: PrismLaw,
) -> Result<Vec<(String, PrismSpec)>, Error> {
    let is_solid = scene.prism.is_solid();
    let stated = input.prism.body;
    let body = GlassSpec { solid: stated.solid.or(is_solid.then_some(true)), law: Some(law), ..stated };
    let polynomials = with_room_for(designed.prism(body), &input.prism, &scene.camera, &scene.effects);
    let text = text::scene_prism(&polynomials.front, &polynomials.back, &body);
    let polynomials = (text, PrismSpec::Polynomial(polynomials));
    if input.settings.surface == DesignedSurface::Polynomial {
        return Ok(vec![polynomials]);
    }
    let mut revolved = revolved_with_room(input, &scene.effects)?;
    revolved.body = GlassSpec { solid: Some(is_solid), ..body };
    Ok(vec![(text::scene_revolved(&revolved), PrismSpec::Revolved(revolved)), polynomials])
}

/// What a cutter asks of the design, and whether two degrees more would leave less; or why its rays do not tell.
fn looked_at(scene: &Scene, input: &DesignInput, designed: &FreeformDesign) -> Result<Looked, Error> {
    let of = |designed: &FreeformDesign| cutter::of_design(scene, &input.prism, designed);
    let sheet = cutter::sheet(&of(designed), cutter::Z_MIN_MM)?;
    let degree = input.settings.degree + 2;
    let settings = DesignSettings { degree, ..input.settings };
    let next = (degree <= DESIGN_DEGREE).then(|| design::freeform(&DesignInput { settings, ..*input }).ok()).flatten();
    let next = next.and_then(|next| cutter::residuals(&of(&next), cutter::Z_MIN_MM).ok());
    let floor = next.map(|next| Floor::of(degree, sheet.rms_px(), &next));
    Ok((sheet, floor))
}

impl MadeDesign {
    /// What a cutter asks, where it is known.
    fn cutter(&self) -> Option<CutterReport<'_>> {
        self.looked.as_ref().ok().map(|(sheet, floor)| CutterReport { law: &self.law, sheet, floor: *floor })
    }

    /// Its figures for a program.
    fn json(&self) -> Value {
        let Self { designed, law, crossing, .. } = self;
        let (camera, front, back) = (&designed.camera, &designed.front, &designed.back);
        serde_json::json!({
            "facet_angle_deg": camera.alpha_rad.to_degrees(),
            "half_angle_deg": camera.delta_rad.to_degrees(),
            "baseline_mm": camera.baseline_mm(),
            "virtual_camera_mm": camera.centre_mm.to_array(),
            "law": law_json(law),
            "points": designed.cloud.len(),
            "optical_path_spread_mm": designed.optical_path_spread_mm,
            "front": {"rms_mm": front.rms_mm, "max_mm": front.max_mm, "condition": front.condition},
            "back": {"rms_mm": back.rms_mm, "max_mm": back.max_mm, "condition": back.condition},
            "columns_through_other_half": crossing.map(|crossing| crossing.columns),
            "solid": crossing.map(|crossing| crossing.solid || crossing.harmless),
            "cutter": self.cutter().map(|cutter| cutter.to_json()),
        })
    }

    /// The same for a person.
    fn words(&self) -> String {
        let Self { designed, crossing, .. } = self;
        let (camera, front, back) = (&designed.camera, &designed.front, &designed.back);
        let mut rows = vec![
            ("facet angle", format!("{:.5} deg", camera.alpha_rad.to_degrees())),
            ("baseline", format!("{:.4} mm", camera.baseline_mm())),
            ("points", designed.cloud.len().to_string()),
            ("optical path, spread", format!("{:.1e} mm", designed.optical_path_spread_mm)),
            ("front fit, RMS and max", format!("{:.2e}, {:.2e} mm", front.rms_mm, front.max_mm)),
            ("back fit, RMS and max", format!("{:.2e}, {:.2e} mm", back.rms_mm, back.max_mm)),
        ];
        rows.extend(crossing.and_then(|crossing| crossing.words()).map(|words| ("one piece of glass", words)));
        let text: String = rows.iter().map(|(label, value)| format!("{label:32}  {value}\n")).collect();
        text + &self.cutter().map(|cutter| cutter.to_text()).unwrap_or_default()
    }
}

/// Columns and rows of a half image.
fn half_px(scene: &Scene) -> DVec2 {
    DVec2::new(0.5 * scene.camera.width_px as f64, scene.camera.height_px as f64)
}

/// Draws the design of the scene `name` into a PNG or an SVG, by the ending of `path`.
fn figure(path: &Path, name: &str, sheet: &CutterSheet, half_px: DVec2) -> Result<(), Error> {
    let drawing = figures::cutter::draw(sheet, half_px);
    match ending(path).as_deref() {
        Some("svg") => files::text(path, &svg::write(&drawing, &figures::cutter::title(name))),
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
