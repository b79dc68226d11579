//! What the verbs read and write alike.

use super::{identity, output};
use crate::error::Error;
use crate::io::exr::Channel;
use crate::io::{Notes, atomic, exr, inputs, png};
use crate::raster::Raster;
use crate::raster::transfer::Transfer;
use crate::render::{Film, Strip};
use crate::scene::{self, Encoding, PrismSpec, Scene};
use crate::system::System;
use glam::DVec2;
use std::iter::once;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The design paper's scene, which is also shipped as a file.
const PAPER: &str = include_str!("../../scenes/paper.toml");

/// What a path of standard input is called by the user, and in messages.
const STDIN: [&str; 2] = ["-", "stdin"];

/// Whether a path stands for standard input.
pub(super) fn is_stdin(path: &Path) -> bool {
    path == Path::new(STDIN[0])
}

/// How a scene's path is called in messages.
pub(super) fn shown(path: &Path) -> String {
    if is_stdin(path) { STDIN[1].to_owned() } else { path.display().to_string() }
}

/// The scene at `path`, or from standard input; then files that it names are looked for in the present folder.
pub(super) fn load(path: &Path) -> Result<Scene, Error> {
    if !is_stdin(path) {
        return scene::load(path);
    }
    note_stdin();
    scene::read(std::io::stdin().lock(), STDIN[1], Some(Path::new("")))
}

/// A file that comes through standard input is read as well.
pub(super) fn note_stdin() {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd;
        if let Ok(copy) = std::io::stdin().as_fd().try_clone_to_owned() {
            // Where it tells nothing of itself there is nothing to be kept.
            let _ = inputs::note(Path::new(STDIN[0]), &std::fs::File::from(copy));
        }
    }
}

/// The scene at `path`, or the paper's.
pub(super) fn scene(path: Option<&Path>) -> Result<Scene, Error> {
    match path {
        Some(path) => load(path),
        None => scene::parse(PAPER, "scenes/paper.toml (embedded)", None),
    }
}

/// The instrument of the scene in `path`.
pub(super) fn build(scene: &Scene, path: &Path) -> Result<System, Error> {
    named(path, crate::system::build(scene))
}

/// What was made of the scene in `path`, or what is wrong and in which file.
pub(super) fn named<T>(path: &Path, made: Result<T, Error>) -> Result<T, Error> {
    made.map_err(|problem| Error { place: format!("{}: {}", shown(path), problem.place), ..problem })
}

/// The folder, made if need be.
pub(super) fn folder(path: &Path) -> Result<(), Error> {
    if path.as_os_str().is_empty() {
        return Ok(());
    }
    std::fs::create_dir_all(path).map_err(|error| {
        let rule = format!("the folder cannot be made: {error}");
        Error::new(path.display(), rule, "name a folder that you may write to, with --out")
    })
}

/// The files of these names in a folder, none of which may be one that was read; the folder is made if need be.
pub(super) fn outputs(folder: &Path, names: &[&str]) -> Result<Vec<PathBuf>, Error> {
    let paths: Vec<PathBuf> = names.iter().map(|name| folder.join(name)).collect();
    inputs::check_outputs(&paths)?;
    self::folder(folder)?;
    Ok(paths)
}

/// Writes `text` to `path`, whole or not at all.
pub(super) fn text(path: &Path, text: &str) -> Result<(), Error> {
    atomic::write_bytes(path, text.as_bytes())
}

/// The name's ending in lower case.
fn ending(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Refuses a name for a picture that [`picture`] could not write, before anything is rendered.
pub(super) fn picture_name(path: &Path) -> Result<(), Error> {
    match ending(path).as_str() {
        "png" | "exr" => Ok(()),
        _ => Err(Error::new(
            path.display(),
            "a picture's name ends in neither .png nor .exr",
            "give --out a name that ends in .png or .exr",
        )),
    }
}

/// Writes the picture as its name's ending asks: .png holds the radiance, .exr also the ground truth.
pub(super) fn picture(path: &Path, scene: &Scene, system: &System, film: &Film) -> Result<(), Error> {
    strips(path, scene, system, once(Arc::new(Strip::from(film))))
}

/// Writes a picture that comes in strips, one below the other, as [`picture`].
pub(super) fn strips(
    path: &Path,
    scene: &Scene,
    system: &System,
    strips: impl Iterator<Item = Arc<Strip>>,
) -> Result<(), Error> {
    let mut what = serde_json::json!({
        "scene": scene.name,
        "prism": prism_name(&scene.prism),
        "instrument": identity::parts(scene, system),
        "pixel_centre": "(i + 0.5, j + 0.5)",
        "radiance": "mean over the pixel, of full scale 1",
        "board.U, board.V": "position on the board that the pixel's centre sees, mm in the board's frame, f32",
        "P": "the same in the world, mm",
        "class": ["left", "right", "missed", "total_reflection", "not_converged", "past_board"],
    });
    if system.clips()
        && let Some(classes) = what["class"].as_array_mut()
    {
        classes.push("clipped".into());
    }
    let mut strips = strips.peekable();
    if strips.peek().is_some_and(|first| first.noise.is_some()) {
        what["Y.error"] = "standard error of Y, from the spread of random sets of samples".into();
    }
    let json = what.to_string();
    let notes = Notes { json: &json, pitch_mm: Some(scene.camera.pitch_mm) };
    let size = (scene.camera.width_px, scene.camera.height_px);
    match ending(path).as_str() {
        "png" => {
            let transfer = match scene.encoding {
                Encoding::Linear => Transfer::Linear,
                Encoding::Srgb => Transfer::Srgb,
            };
            let coloured = strips.peek().is_some_and(|first| first.colour.is_some());
            let clamped = if coloured {
                let colours = strips.filter_map(|strip| strip.colour.clone());
                png::write_rgb16_strips(path, size, colours, transfer, &notes)?
            } else {
                let greys = strips.map(|strip| strip.radiance.clone());
                png::write_grey16_strips(path, size, greys, transfer, &notes)?
            };
            if clamped > 0 {
                output::stderr(&format!(
                    "{}: {clamped} pixels were brighter than full scale and are clamped",
                    path.display()
                ));
            }
            Ok(())
        }
        "exr" => exr::write_strips(path, size.1, strips.map(|strip| channels(system, &strip)), &notes),
        _ => picture_name(path),
    }
}

/// The name of a prism in a report: its kind in the scene.
pub(super) fn prism_name(prism: &PrismSpec) -> &'static str {
    match prism {
        PrismSpec::None => "none",
        PrismSpec::Flat(_) => "flat",
        PrismSpec::Freeform(..) => "freeform",
        PrismSpec::Polynomial(_) => "polynomial",
        PrismSpec::PointCloud(_) => "point_cloud",
        PrismSpec::Mesh(_) => "mesh",
    }
}

/// Radiance and, for each pixel's centre, what it sees through the prism.
fn channels(system: &System, strip: &Strip) -> Vec<Channel> {
    let truth = |value: &dyn Fn([f32; 2]) -> f64| {
        let pixels = strip.board_mm.data().iter().zip(strip.class.data());
        let data =
            pixels.map(|(&mm, &class)| if class.side().is_some() { value(mm) as f32 } else { f32::NAN }).collect();
        Raster::from_data(strip.board_mm.width(), strip.board_mm.height(), data)
    };
    let world = |axis: usize| truth(&|mm| system.board.world(DVec2::new(f64::from(mm[0]), f64::from(mm[1])))[axis]);
    let mut channels = vec![
        Channel::f32("Y", strip.radiance.clone()),
        Channel::f32("board.U", truth(&|mm| f64::from(mm[0]))),
        Channel::f32("board.V", truth(&|mm| f64::from(mm[1]))),
        Channel::f32("P.X", world(0)),
        Channel::f32("P.Y", world(1)),
        Channel::f32("P.Z", world(2)),
        Channel::u32("class", strip.class.map(|class| class as u32)),
    ];
    if let Some(colour) = &strip.colour {
        for (k, name) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push(Channel::f32(name, colour.map(|pixel| pixel[k])));
        }
    }
    if let Some(noise) = &strip.noise {
        channels.push(Channel::f32("Y.error", noise.clone()));
    }
    channels
}
