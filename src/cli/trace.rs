//! `biprism trace`: pixel positions to the board and back, at full precision.

use super::args::TraceArgs;
use super::field_lines::{LinePlace, each_line, number};
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, output};
use crate::effect::EffectId;
use crate::error::Error;
use crate::io::inputs::check_outputs;
use crate::io::npy;
use crate::io::npy_table::read_table;
use crate::progress::Observer;
use crate::render::WayTracer;
use crate::report::traced::{AimedPoint, TracedRay};
use crate::system::aim::Aimer;
use crate::system::in_light::{in_light_of, light_name};
use crate::system::{InLight, Side};
use glam::DVec2;
use rayon::prelude::*;
use std::io::IsTerminal;
use std::path::Path;

/// What is to be traced for a line.
#[derive(Clone, Copy)]
enum Asked {
    /// Where this pixel position leads.
    Pixel(DVec2),
    /// Which pixel position sees this board point through this side.
    Board(Side, DVec2),
}

/// Most points that are read: 240 MB in memory.
const MAX_POINTS: usize = 10_000_000;
/// Answers that a thread makes at once, and their number before they are written.
const PIECE: usize = 4096;
const AT_ONCE: usize = 16 * PIECE;

pub(super) fn run(args: &TraceArgs) -> Result<Outcome, Error> {
    if files::is_stdin(&args.scene) && files::is_stdin(&args.points) {
        let rule = "scene and points are both to come from stdin";
        return Err(Error::new("stdin", rule, "give the points as a file, with --points"));
    }
    if let Some(path) = &args.out {
        if !is_npy(path) {
            let rule = format!("`{}` does not end in .npy", path.display());
            return Err(Error::new("--out", rule, "name a .npy, or leave --out out for text"));
        }
        check_outputs(std::slice::from_ref(path))?;
    }
    let scene = files::load(&args.scene, &args.values)?;
    let progress = Progress::new(0);
    progress.begin(&scene.name, "design");
    let built = files::build(&scene, &args.scene)?;
    drop(progress);
    let system = match args.wavelength_nm {
        Some(nm) => in_light_of(&built, &scene, nm)?,
        None => built,
    };
    if !scene.objects.is_empty() {
        output::stderr(
            "note: places are on the board's plane, also behind an `[[object]]`; `biprism render` tells what hides it",
        );
    }

    // Read every point before the first is answered, so that a bad one leaves no half of an answer.
    let asked = read(args)?;

    // Answer them, and say in which light.
    let light = InLight::new(&system);
    let tracer = Tracer { light: &light, ways: WayTracer::new(light.main()), aimer: Aimer::new(&system) };
    match &args.out {
        Some(path) => tracer.table(path, args.back, &scene.name, &asked)?,
        None => tracer.print(args, &scene.name, &asked)?,
    }
    match args.wavelength_nm {
        Some(nm) => output::stderr(&format!("traced in light of {nm} nm")),
        None if system.effects().acting().any(|row| row.id == EffectId::Dispersion) => {
            output::stderr(&format!("traced in {}", light_name(&scene, &system)));
        }
        None => {}
    }
    Ok(Outcome::Done)
}

/// What answers.
struct Tracer<'a> {
    light: &'a InLight<'a>,
    ways: WayTracer<'a>,
    aimer: Aimer<'a>,
}

impl Tracer<'_> {
    /// Prints the answers as CSV or as JSON.
    fn print(&self, args: &TraceArgs, name: &str, asked: &[Asked]) -> Result<(), Error> {
        let (head, between, tail) = if args.json {
            ("[\n".to_owned(), ",\n", "\n]\n")
        } else {
            (format!("{}\n", if args.back { AimedPoint::COLUMNS } else { TracedRay::COLUMNS }), "\n", "\n")
        };
        output::stdout(&head)?;
        let answer = |piece: &[Asked]| {
            let mut text = String::with_capacity(piece.len() * 512);
            for (k, asked) in piece.iter().enumerate() {
                text.push_str(if k == 0 { "" } else { between });
                match (*asked, args.json) {
                    (Asked::Pixel(px), true) => TracedRay::new(self.light, px).json(&mut text),
                    (Asked::Pixel(px), false) => TracedRay::new(self.light, px).text(&mut text),
                    (Asked::Board(side, mm), true) => AimedPoint::new(&self.aimer, side, mm).json(&mut text),
                    (Asked::Board(side, mm), false) => AimedPoint::new(&self.aimer, side, mm).text(&mut text),
                }
            }
            text
        };
        // Rows show how far it is where they go to the terminal; elsewhere the bar does.
        let progress = Progress::new(0);
        let watch = progress.watch(name);
        if !std::io::stdout().is_terminal() {
            watch.stage_of("trace", asked.len());
        }
        let mut first = true;
        for some in asked.chunks(AT_ONCE) {
            let pieces: Vec<String> = some.par_chunks(PIECE).map(answer).collect();
            for piece in pieces {
                output::numbers(if first { "" } else { between })?;
                output::numbers(&piece)?;
                first = false;
            }
            watch.pixels(some.len());
        }
        drop(progress);
        output::stdout(if asked.is_empty() && !args.json { "" } else { tail })
    }

    /// Writes the answers as a table of records.
    fn table(&self, path: &Path, back: bool, name: &str, asked: &[Asked]) -> Result<(), Error> {
        let fields = if back { &AimedPoint::FIELDS[..] } else { &TracedRay::FIELDS };
        let record: usize = fields.iter().map(|field| field.bytes()).sum();
        let answer = |piece: &[Asked]| {
            let mut bytes = Vec::with_capacity(record * piece.len());
            // All are of one kind.
            let mut places = Vec::with_capacity(piece.len());
            for asked in piece {
                match *asked {
                    Asked::Pixel(px) => places.push(px),
                    Asked::Board(side, mm) => AimedPoint::new(&self.aimer, side, mm).record(&mut bytes),
                }
            }
            bytes.resize(record * piece.len(), 0);
            let mut one = Vec::with_capacity(record);
            TracedRay::each(self.light, &self.ways, &places, |k, ray| {
                one.clear();
                ray.record(&mut one);
                bytes[k * record..(k + 1) * record].copy_from_slice(&one);
            });
            bytes
        };
        let progress = Progress::new(0);
        let watch = progress.watch(name);
        watch.stage_of("trace", asked.len());
        let pieces = asked.chunks(AT_ONCE).flat_map(|some| {
            let pieces: Vec<Vec<u8>> = some.par_chunks(PIECE).map(answer).collect();
            watch.pixels(some.len());
            pieces
        });
        npy::write_parts(path, fields, &[asked.len()], pieces)?;
        drop(progress);
        output::stderr(&format!("wrote {}", path.display()));
        Ok(())
    }
}

fn is_npy(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npy"))
}

/// The points that are asked for, in their order.
fn read(args: &TraceArgs) -> Result<Vec<Asked>, Error> {
    if is_npy(&args.points) {
        return table(&args.points, args.back);
    }
    let mut asked = Vec::new();
    each_line(&args.points, &HEADINGS, |place, fields| {
        if asked.len() == MAX_POINTS {
            let rule = format!("there are more than {MAX_POINTS} points");
            return Err(Error::new(place, rule, "split the file"));
        }
        asked.push(if args.back { parse_board(place, fields)? } else { parse_pixel(place, fields)? });
        Ok(())
    })?;
    Ok(asked)
}

/// The points of an NPY table: `x_px, y_px`, or `side, u_mm, v_mm` with 0 for left and 1 for right.
fn table(path: &Path, back: bool) -> Result<Vec<Asked>, Error> {
    if !back {
        let values = read_table(path, 2, MAX_POINTS)?;
        return Ok(values.as_chunks::<2>().0.iter().map(|px| Asked::Pixel(DVec2::from_array(*px))).collect());
    }
    let values = read_table(path, 3, MAX_POINTS)?;
    let one = |(row, &[side, u, v]): (usize, &[f64; 3])| match side {
        0.0 => Ok(Asked::Board(Side::Left, DVec2::new(u, v))),
        1.0 => Ok(Asked::Board(Side::Right, DVec2::new(u, v))),
        _ => {
            let rule = format!("[{row}, 0], the side, is {side}, and must be 0 (left) or 1 (right)");
            Err(Error::new(path.display(), rule, "write rows of side, u_mm, v_mm"))
        }
    };
    values.as_chunks::<3>().0.iter().enumerate().map(one).collect()
}

/// First columns of the headings that a file may have.
const HEADINGS: [&str; 3] = ["x_px", "x", "side"];

fn parse_pixel(place: LinePlace<'_>, fields: &[&str]) -> Result<Asked, Error> {
    let [x, y] = fields else {
        let rule = format!("the line has {} fields, and must have 2", fields.len());
        return Err(Error::new(place, rule, "write x_px,y_px, as in 960.5,540.5"));
    };
    Ok(Asked::Pixel(DVec2::new(number(place, "x_px", x)?, number(place, "y_px", y)?)))
}

fn parse_board(place: LinePlace<'_>, fields: &[&str]) -> Result<Asked, Error> {
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
