//! `biprism design`: the freeform prism of a scene, as scene text, as points and as a body.

use super::args::DesignArgs;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, output};
use crate::design::{self, DesignInput, FreeformDesign, text};
use crate::error::Error;
use crate::io::atomic::write_atomically;
use crate::io::inputs::check_outputs;
use crate::io::point_grid::{write_csv, write_ply};
use crate::io::solid;
use crate::scene::{DesignedSurface, MarchOrder, PrismSpec, Scene};
use crate::surface::face::Face;
use crate::system::crossing::Crossing;
use crate::system::{self, System, revolved_with_room, with_room_for};
use std::path::{Path, PathBuf};

/// How a body is written.
#[derive(Clone, Copy)]
enum BodyFormat {
    Stl,
    Ply,
}

pub(super) fn run(args: &DesignArgs) -> Result<Outcome, Error> {
    let scene = files::load(&args.scene)?;
    let input = asked(&scene, args)?;
    let scene = Scene { prism: PrismSpec::Freeform(input.prism, input.settings), ..scene };
    scene.check()?;
    let body = match args.solid.as_deref() {
        Some(path) => Some((path, body_format(path)?)),
        None => None,
    };
    let revolved = input.settings.surface == DesignedSurface::Revolved;
    let more: &[&str] = if revolved { &["prism_polynomial.toml"] } else { &[] };
    let mut paths = files::outputs(&args.out, &[&["prism.toml", "cloud.csv", "front.ply", "back.ply"], more].concat())?;
    let all: Vec<PathBuf> = paths.iter().cloned().chain(args.solid.clone()).collect();
    check_outputs(&all)?;

    // Design.
    let progress = Progress::new(0);
    progress.begin(&scene.name, "design");
    let designed = design::freeform(&input)?;
    let texts = texts(&scene, &input, &designed)?;

    // Write what was designed.
    progress.begin(&scene.name, "write");
    for (path, (text, _)) in paths.iter().take(1).chain(paths.get(4)).zip(&texts) {
        files::text(path, text)?;
    }
    let cloud = &designed.cloud;
    write_atomically(&paths[1], |out| write_csv(cloud.points(), out))?;
    for (path, face) in [(&paths[2], Face::Front), (&paths[3], Face::Back)] {
        let size = [cloud.columns(), cloud.rows()];
        write_atomically(path, |out| write_ply(size, cloud.points(), face, out))?;
    }
    let prism = texts.into_iter().next().map_or(PrismSpec::None, |(_, prism)| prism);
    let made = system::ideal(&Scene { prism, ..scene })?;
    if let Some((path, format)) = body {
        write_body(&made, path, format)?;
        paths.push(path.to_owned());
    }
    drop(progress);
    tell(args, &designed, &made)?;
    paths.iter().for_each(|path| output::stderr(&format!("wrote {}", path.display())));
    output::stderr("prism.toml is the [prism] part of a scene: put it beside a camera and a board");
    Ok(Outcome::Done)
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
    settings.degree = args.degree.map_or(settings.degree, |degree| degree as usize);
    if args.y_then_x {
        settings.order = MarchOrder::YThenX;
    }
    Ok(input)
}

/// The prisms of a design and their texts, as large as the rays of the scene need them, not those of the design alone: the one
/// that it becomes, and of surfaces of revolution the polynomials through them.
fn texts(scene: &Scene, input: &DesignInput, designed: &FreeformDesign) -> Result<Vec<(String, PrismSpec)>, Error> {
    let is_solid = scene.prism.is_solid();
    let mut body = input.prism.body;
    body.solid = body.solid.or(is_solid.then_some(true));
    let polynomials = with_room_for(designed.prism(body), &input.prism, &scene.camera, &scene.effects);
    let text = text::scene_prism(&polynomials.front, &polynomials.back, &body);
    let polynomials = (text, PrismSpec::Polynomial(polynomials));
    if input.settings.surface == DesignedSurface::Polynomial {
        return Ok(vec![polynomials]);
    }
    let mut revolved = revolved_with_room(input, &scene.effects)?;
    revolved.body.solid = Some(is_solid);
    Ok(vec![(text::scene_revolved(&revolved), PrismSpec::Revolved(revolved)), polynomials])
}

fn body_format(path: &Path) -> Result<BodyFormat, Error> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "stl" => Ok(BodyFormat::Stl),
        "ply" => Ok(BodyFormat::Ply),
        _ => Err(Error::new(
            path.display(),
            format!("the extension is {extension:?}, and a body's must be stl or ply"),
            "write --solid body.ply, whose numbers are f64, or body.stl, whose numbers are f32",
        )),
    }
}

fn write_body(system: &System, path: &Path, format: BodyFormat) -> Result<(), Error> {
    let body = system::solid::solid(system, system::solid::CELLS)?;
    write_atomically(path, |out| match format {
        BodyFormat::Stl => solid::write_stl(&body, out),
        BodyFormat::Ply => solid::write_ply(&body, out),
    })
}

/// Prints the figures of a design.
fn tell(args: &DesignArgs, designed: &FreeformDesign, made: &System) -> Result<(), Error> {
    let (camera, front, back, cloud) = (&designed.camera, &designed.front, &designed.back, &designed.cloud);
    let crossing = Crossing::of(made);
    if args.json {
        let figures = serde_json::json!({
            "facet_angle_deg": camera.alpha_rad.to_degrees(),
            "half_angle_deg": camera.delta_rad.to_degrees(),
            "baseline_mm": camera.baseline_mm(),
            "virtual_camera_mm": camera.centre_mm.to_array(),
            "points": cloud.len(),
            "optical_path_spread_mm": designed.optical_path_spread_mm,
            "front": {"rms_mm": front.rms_mm, "max_mm": front.max_mm, "condition": front.condition},
            "back": {"rms_mm": back.rms_mm, "max_mm": back.max_mm, "condition": back.condition},
            "columns_through_other_half": crossing.map(|crossing| crossing.columns),
            "solid": crossing.map(|crossing| crossing.solid || crossing.harmless),
        });
        return output::stdout(&format!("{figures:#}\n"));
    }
    let mut lines = vec![
        format!("facet angle             {:.5} deg", camera.alpha_rad.to_degrees()),
        format!("baseline                {:.4} mm", camera.baseline_mm()),
        format!("points                  {}", cloud.len()),
        format!("optical path, spread    {:.1e} mm", designed.optical_path_spread_mm),
        format!("front fit, RMS and max  {:.2e}, {:.2e} mm", front.rms_mm, front.max_mm),
        format!("back fit, RMS and max   {:.2e}, {:.2e} mm", back.rms_mm, back.max_mm),
    ];
    lines
        .extend(crossing.and_then(|crossing| crossing.words()).map(|words| format!("one piece of glass      {words}")));
    output::stdout(&(lines.join("\n") + "\n"))
}
