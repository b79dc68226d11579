//! Input and output files that the verbs share.

use super::output;
use crate::error::Error;
use crate::io::atomic;
use crate::io::{Notes, png};
use crate::plot::canvas;
use crate::plot::drawing::Drawing;
use crate::scene::{self, Scene};
use crate::system::System;
use std::path::Path;

/// The design paper's scene, which is also shipped as a file.
const PAPER: &str = include_str!("../../scenes/paper.toml");

/// The scene at `path`, or the paper's.
pub(super) fn scene(path: Option<&Path>) -> Result<Scene, Error> {
    match path {
        Some(path) => scene::load(path),
        None => scene::parse(PAPER, "scenes/paper.toml (embedded)", None),
    }
}

/// The instrument of the scene in `path`.
pub(super) fn build(scene: &Scene, path: &Path) -> Result<System, Error> {
    named(path, crate::system::build(scene))
}

/// The result for the scene in `path`, or what is wrong and in which file.
pub(super) fn named<T>(path: &Path, made: Result<T, Error>) -> Result<T, Error> {
    made.map_err(|problem| Error { place: format!("{}: {}", path.display(), problem.place), ..problem })
}

/// The folder, created if need be.
pub(super) fn folder(path: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(path).map_err(|error| {
        let rule = format!("the folder cannot be made: {error}");
        Error::new(path.display(), rule, "name a folder that you may write to, with --out")
    })
}

/// Writes `text` to `path`, whole or not at all.
pub(super) fn text(path: &Path, text: &str) -> Result<(), Error> {
    atomic::write_bytes(path, text.as_bytes())
}

/// Draws `drawing` into a PNG at `path`.
pub(super) fn drawing(path: &Path, drawing: &Drawing) -> Result<(), Error> {
    png::write_rgb(path, &canvas::raster(drawing), &Notes::default())
}

/// Says how many pixels of the picture at `path` were clamped, where some were.
pub(super) fn print_clamped(path: &Path, pixels: usize) {
    if pixels > 0 {
        output::stderr(&format!("{}: {pixels} pixels were brighter than full scale and are clamped", path.display()));
    }
}
