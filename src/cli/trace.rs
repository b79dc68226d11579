//! `biprism trace`: pixel positions to the board and back, at full precision.

use super::args::TraceArgs;
use super::field_lines::{each_line, number};
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, output};
use crate::effect::EffectId;
use crate::effect::dispersion::Wavelength;
use crate::error::Error;
use crate::optics::fate::Fate;
use crate::progress::Observer;
use crate::scene::Scene;
use crate::system::aim::Aimer;
use crate::system::in_light::light_name;
use crate::system::{InLight, Side, System};
use glam::{DVec2, DVec3};
use serde_json::json;
use std::fmt::Write as _;
use std::io::IsTerminal;

/// What is to be traced for a line.
enum Asked {
    /// Where this pixel position leads.
    Pixel(DVec2),
    /// Which pixel position sees this board point through this side.
    Board(Side, DVec2),
}

/// Most lines that are read: 240 MB in memory.
const MAX_POINTS: usize = 10_000_000;
/// Answers are written in pieces of this many.
const PIECE: usize = 4096;

pub(super) fn run(args: &TraceArgs) -> Result<Outcome, Error> {
    if files::is_stdin(&args.scene) && files::is_stdin(&args.points) {
        let rule = "scene and points are both to come from stdin";
        return Err(Error::new("stdin", rule, "give the points as a file, with --points"));
    }
    let scene = files::load(&args.scene)?;
    let progress = Progress::new(0);
    progress.begin(&scene.name, "design");
    let built = files::build(&scene, &args.scene)?;
    drop(progress);
    let system = match args.wavelength_nm {
        Some(nm) => at_line(&built, &scene, nm)?,
        None => built,
    };
    if !scene.objects.is_empty() {
        output::stderr(
            "note: places are on the board's plane, also behind an `[[object]]`; `biprism render` tells what hides it",
        );
    }
    // Every line is read before the first is answered, so that a bad one leaves no half of an answer.
    let mut asked = Vec::new();
    each_line(&args.points, &HEADINGS, |place, fields| {
        if asked.len() == MAX_POINTS {
            let rule = format!("there are more than {MAX_POINTS} points");
            return Err(Error::new(place, rule, "split the file"));
        }
        asked.push(if args.back { parse_board(place, fields)? } else { parse_pixel(place, fields)? });
        Ok(())
    })?;
    let (light, aimer) = (InLight::new(&system), Aimer::new(&system));
    let answer = |asked: &Asked| match *asked {
        Asked::Pixel(px) => forth(&light, args.json, px),
        Asked::Board(side, mm) => back(&aimer, args.json, side, mm),
    };
    let (head, between, tail) = if args.json {
        ("[\n".to_owned(), ",\n", "\n]\n")
    } else {
        (format!("{}\n", if args.back { BACK_COLUMNS } else { COLUMNS }), "\n", "\n")
    };
    output::stdout(&head)?;
    // Rows show how far it is where they go to the terminal; elsewhere the bar does.
    let progress = Progress::new(0);
    let watch = progress.watch(&scene.name);
    if !std::io::stdout().is_terminal() {
        watch.stage_of("trace", asked.len());
    }
    for (k, piece) in asked.chunks(PIECE).enumerate() {
        let lines: Vec<String> = piece.iter().map(answer).collect();
        output::stdout(&format!("{}{}", if k == 0 { "" } else { between }, lines.join(between)))?;
        watch.pixels(piece.len());
    }
    drop(progress);
    output::stdout(if asked.is_empty() && !args.json { "" } else { tail })?;
    match args.wavelength_nm {
        Some(nm) => output::stderr(&format!("traced in light of {nm} nm")),
        None if system.effects().acting().any(|row| row.id == EffectId::Dispersion) => {
            output::stderr(&format!("traced in {}", light_name(&scene, &system)));
        }
        None => {}
    }
    Ok(Outcome::Done)
}

/// The instrument of `scene` in light of one wavelength, in nm.
fn at_line(system: &System, scene: &Scene, wavelength_nm: f64) -> Result<System, Error> {
    let refused = |rule: String| {
        Error::new(
            "--wavelength-nm",
            rule,
            "give `prism.glass` a name of docs/effects.md, or leave --wavelength-nm out",
        )
    };
    let Some(body) = scene.prism.body() else {
        return Err(refused(format!("scene \"{}\" has no glass that a wavelength could change", scene.name)));
    };
    let Some(glass) = body.glass else {
        return Err(refused(format!(
            "`prism.index` of scene \"{}\" is a number, which says nothing of {wavelength_nm} nm",
            scene.name
        )));
    };
    let index = |nm: f64| glass.index(nm).map_err(|error| refused(error.to_string()));
    let index_shift = index(wavelength_nm)? - index(body.wavelength_nm)?;
    Ok(system.at_wavelength(&Wavelength { wavelength_nm, index_shift, weights: [1.0; 3] }))
}

/// First columns of the headings that a file may have.
const HEADINGS: [&str; 3] = ["x_px", "x", "side"];

const COLUMNS: &str = "x_px,y_px,side,fate,u_mm,v_mm,world_x_mm,world_y_mm,world_z_mm,\
front_x_mm,front_y_mm,front_z_mm,inner_dx,inner_dy,inner_dz,back_x_mm,back_y_mm,back_z_mm,exit_dx,exit_dy,exit_dz";

const BACK_COLUMNS: &str = "side,u_mm,v_mm,fate,x_px,y_px,seen";

fn side_name(side: Side) -> &'static str {
    if side == Side::Left { "left" } else { "right" }
}

fn parse_pixel(place: &str, fields: &[&str]) -> Result<Asked, Error> {
    let [x, y] = fields else {
        let rule = format!("the line has {} fields, and must have 2", fields.len());
        return Err(Error::new(place, rule, "write x_px,y_px, as in 960.5,540.5"));
    };
    Ok(Asked::Pixel(DVec2::new(number(place, "x_px", x)?, number(place, "y_px", y)?)))
}

fn parse_board(place: &str, fields: &[&str]) -> Result<Asked, Error> {
    let [side, u, v] = fields else {
        let rule = format!("the line has {} fields, and must have 3", fields.len());
        return Err(Error::new(place, rule, "write side,u_mm,v_mm, as in left,12.5,-3"));
    };
    let side = match *side {
        "left" => Side::Left,
        "right" => Side::Right,
        other => {
            let rule = format!("`side` is {other:?}, and must be left or right");
            return Err(Error::new(place, rule, "write side,u_mm,v_mm, as in left,12.5,-3"));
        }
    };
    Ok(Asked::Board(side, DVec2::new(number(place, "u_mm", u)?, number(place, "v_mm", v)?)))
}

/// A pixel position to the board, with every point on the way. All points and directions are in the world.
fn forth(light: &InLight<'_>, as_json: bool, px: DVec2) -> String {
    let system = light.main();
    let (path, end) = light.path(px);
    let landed = match light.lights() {
        [_] => end.and_then(|(ray, side)| system.board().intersect(&ray).map(|(mm, _)| (mm, side))),
        // On a tilted board the mean of positions is not where the mean ray lands.
        _ => light.trace(px).map(|hit| (hit.board_mm, hit.side)),
    };
    // A ray that ended in the glass came in through the side of its first point.
    let entered = || Some(system.prism()?.side_at(*path.points.first()?));
    let (fate, side) = match (&landed, &end) {
        (Ok((_, side)), _) => ("board", Some(*side)),
        (Err(fate), Ok((_, side))) => (fate.name(), Some(*side)),
        (Err(fate), Err(_)) => (fate.name(), entered()),
    };
    let reflected_at = match path.points.len() {
        n if landed != Err(Fate::TotalReflection) || n == path.directions.len() => None,
        1 => Some("front"),
        _ => Some("back"),
    };
    let board = landed.ok().map(|(mm, _)| mm);
    let world = board.map(|mm| system.board().world(mm));
    let point = |k: usize| path.points.get(k).copied();
    let direction = |k: usize| path.directions.get(k).copied();
    if as_json {
        let array = |v: Option<DVec3>| v.map(|v| v.to_array());
        return json!({
            "pixel_px": px.to_array(), "side": side.map(side_name), "fate": fate, "reflected_at": reflected_at,
            "board_mm": board.map(|mm| mm.to_array()), "world_mm": array(world),
            "front_mm": array(point(0)), "inner_direction": array(direction(0)),
            "back_mm": array(point(1)), "exit_direction": array(end.ok().map(|(ray, _)| ray.direction)),
        })
        .to_string();
    }
    let mut line = format!("{:?},{:?},{},{fate}", px.x, px.y, side.map_or("", side_name));
    let _ = match board {
        Some(mm) => write!(line, ",{:?},{:?}", mm.x, mm.y),
        None => write!(line, ",,"),
    };
    for v in [world, point(0), direction(0), point(1), end.ok().map(|(ray, _)| ray.direction)] {
        let _ = match v {
            Some(v) => write!(line, ",{:?},{:?},{:?}", v.x, v.y, v.z),
            None => write!(line, ",,,"),
        };
    }
    line
}

/// A board point to the pixel position that sees it through one side. `seen` says whether that is on the sensor and on
/// the side's own part of it.
fn back(aimer: &Aimer<'_>, as_json: bool, side: Side, mm: DVec2) -> String {
    let aimed: Result<(DVec2, bool), Fate> = aimer.aim(mm, side).map(|px| (px, aimer.sees(px, side)));
    let name = side_name(side);
    let fate = aimed.map_or_else(Fate::name, |_| "board");
    if as_json {
        let px = aimed.ok().map(|(px, _)| px.to_array());
        let seen = aimed.ok().map(|(_, seen)| seen);
        return json!({ "side": name, "board_mm": mm.to_array(), "fate": fate, "pixel_px": px, "seen": seen })
            .to_string();
    }
    match aimed {
        Ok((px, seen)) => format!("{name},{:?},{:?},{fate},{:?},{:?},{seen}", mm.x, mm.y, px.x, px.y),
        Err(_) => format!("{name},{:?},{:?},{fate},,,", mm.x, mm.y),
    }
}
