//! Input and output files that the verbs share.

use super::set_args::SetArgs;
use super::{origin, output};
use crate::error::Error;
use crate::io::{Notes, atomic, inputs, png};
use crate::plot::canvas;
use crate::plot::drawing::Drawing;
use crate::plot::svg;
use crate::raster::Raster;
use crate::scene::{self, Scene};
use crate::system::System;
use std::path::{Path, PathBuf};

/// The design paper's scene, which is also shipped as a file.
const PAPER: &str = include_str!("../../scenes/paper.toml");

/// The same instrument with the exact prism, shipped beside it.
const EXACT: &str = include_str!("../../scenes/exact.toml");

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

/// The scene at `path` with `values` in place of its own, or from standard input; then files that it names are looked for in the
/// present folder.
pub(super) fn load(path: &Path, values: &SetArgs) -> Result<Scene, Error> {
    load_with_text(path, values).map(|(scene, _)| scene)
}

/// The same, with its text.
pub(super) fn load_with_text(path: &Path, values: &SetArgs) -> Result<(Scene, String), Error> {
    let SceneSource { text, folder } = source(path)?;
    let scene = scene::parse_with(&text, &shown(path), folder.as_deref(), &values.set)?;
    Ok((scene, scene::text_with(&text, &shown(path), &values.set)?))
}

/// The text of a scene, and the folder in which the files that it names are looked for.
pub(super) struct SceneSource {
    pub(super) text: String,
    pub(super) folder: Option<PathBuf>,
}

/// The text of the scene at `path`, or from standard input.
pub(super) fn source(path: &Path) -> Result<SceneSource, Error> {
    let (text, folder) = if is_stdin(path) {
        note_stdin();
        (scene::text_of(std::io::stdin().lock(), STDIN[1])?, Some(PathBuf::new()))
    } else {
        (scene::text(path)?, path.parent().map(Path::to_owned))
    };
    origin::note(&shown(path), &text);
    Ok(SceneSource { text, folder })
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

/// The scene at `path`, or the paper's, with `values` in place of its own.
pub(super) fn scene(path: Option<&Path>, values: &SetArgs) -> Result<Scene, Error> {
    match path {
        Some(path) => load(path, values),
        None => embedded("scenes/paper.toml (embedded)", PAPER, values),
    }
}

/// The scene of the exact prism.
pub(super) fn exact_scene(values: &SetArgs) -> Result<Scene, Error> {
    embedded("scenes/exact.toml (embedded)", EXACT, values)
}

fn embedded(name: &str, text: &str, values: &SetArgs) -> Result<Scene, Error> {
    origin::note(name, text);
    scene::parse_with(text, name, None, &values.set)
}

/// Refuses the scene in `path` where its board has no checkerboard, whose corners are looked for.
pub(super) fn checkerboard(scene: &Scene, path: &Path) -> Result<(), Error> {
    let Some(texture) = &scene.texture else { return Ok(()) };
    let rule = format!(
        "`board.texture` is {}, and corners are looked for on a checkerboard, which the board of this scene is not",
        texture.words()
    );
    let help = "take `texture` out of `[board]`, or use `biprism render` and `biprism trace`, which need no corners";
    Err(Error::new(shown(path), rule, help))
}

/// The instrument of the scene in `path`.
pub(super) fn build(scene: &Scene, path: &Path) -> Result<System, Error> {
    named(path, crate::system::build(scene))
}

/// The result for the scene in `path`, or what is wrong and in which file.
pub(super) fn named<T>(path: &Path, made: Result<T, Error>) -> Result<T, Error> {
    made.map_err(|problem| Error { place: format!("{}: {}", shown(path), problem.place), ..problem })
}

/// The folder, created if need be.
pub(super) fn folder(path: &Path) -> Result<(), Error> {
    if path.as_os_str().is_empty() {
        return Ok(());
    }
    std::fs::create_dir_all(path).map_err(|error| {
        let rule = format!("the folder cannot be made: {error}");
        Error::new(path.display(), rule, "name a folder that you may write to, with --out")
    })
}

/// The folder of a file, created if need be.
pub(super) fn folder_of(path: &Path) -> Result<(), Error> {
    folder(path.parent().unwrap_or(Path::new("")))
}

/// The files of these names in a folder, none of which may be one that was read; the folder is made if need be.
pub(super) fn outputs(folder: &Path, names: &[&str]) -> Result<Vec<PathBuf>, Error> {
    let paths: Vec<PathBuf> = names.iter().map(|name| folder.join(name)).collect();
    inputs::check_outputs(&paths)?;
    self::folder(folder)?;
    Ok(paths)
}

/// Refuses a picture at `path` that is not of the scene's size.
pub(super) fn check_size(path: &Path, picture: &Raster<f32>, scene: &Scene) -> Result<(), Error> {
    let (size, [width, height]) =
        ([picture.width(), picture.height()], [scene.camera.width_px, scene.camera.height_px]);
    if size == [width, height] {
        return Ok(());
    }
    let rule =
        format!("the picture is {} x {}, and the scene's camera has {width} x {height} pixels", size[0], size[1]);
    Err(Error::new(path.display(), rule, "name the scene that the picture belongs to with --scene"))
}

/// Writes `text` to `path`, whole or not at all.
pub(super) fn text(path: &Path, text: &str) -> Result<(), Error> {
    atomic::write_bytes(path, text.as_bytes())
}

/// Draws `drawing` into a PNG at `path`.
pub(super) fn drawing(path: &Path, drawing: &Drawing) -> Result<(), Error> {
    png::write_rgb(path, &canvas::raster(drawing), &Notes::default())
}

/// Writes a figure into a folder, as PNG and as SVG.
pub(super) fn figure(folder: &Path, name: &str, drawing: &Drawing, title: &str) -> Result<[PathBuf; 2], Error> {
    let paths = ["png", "svg"].map(|ending| folder.join(format!("{name}.{ending}")));
    let (png, svg) = rayon::join(|| self::drawing(&paths[0], drawing), || text(&paths[1], &svg::write(drawing, title)));
    png.and(svg).map(|()| paths)
}

/// Says how many pixels of the picture at `path` were clamped, where some were.
pub(super) fn print_clamped(path: &Path, pixels: usize) {
    if pixels > 0 {
        output::stderr(&format!("{}: {pixels} pixels were brighter than full scale and are clamped", path.display()));
    }
}
