//! The command, run as a user runs it.

use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A file of this repository.
pub(crate) fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// What the command does with some arguments in a folder.
pub(crate) fn biprism(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_biprism")).current_dir(folder).args(args).output().expect("it runs")
}

/// [`biprism`] with text on stdin.
pub(crate) fn with_input(folder: &Path, args: &[&str], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_biprism"))
        .current_dir(folder)
        .args(args)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it runs");
    child.stdin.take().expect("a pipe").write_all(input.as_bytes()).expect("written");
    child.wait_with_output().expect("it ends")
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// The JSON on the stdout of a command that succeeded.
pub(crate) fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON on stdout and nothing else")
}

/// The paper's scene on a sensor of 480 x 270 px, in a file of `folder`.
pub(crate) fn small_scene(folder: &Path, change: impl Fn(String) -> String) -> PathBuf {
    let paper = fs::read_to_string(repository("scenes/paper.toml")).expect("the scene is there");
    let small = paper
        .replace("width_px = 1920", "width_px = 480")
        .replace("height_px = 1080", "height_px = 270")
        .replace("pixel_pitch_um = 5.5", "pixel_pitch_um = 22.0")
        .replace("depths_mm = [500.0, 1000.0, 2000.0]", "depths_mm = [500.0, 700.0, 1000.0]");
    let path = folder.join("scene.toml");
    fs::write(&path, change(small)).expect("written");
    path
}

/// [`small_scene`] at a quarter of the pixels, with squares twice as large and one depth: some 100 corners.
pub(crate) fn tiny_scene(folder: &Path, change: impl Fn(String) -> String) -> PathBuf {
    small_scene(folder, |text| {
        let tiny = text
            .replace("width_px = 480", "width_px = 240")
            .replace("height_px = 270", "height_px = 135")
            .replace("pixel_pitch_um = 22.0", "pixel_pitch_um = 44.0")
            .replace("columns = 41\nrows = 41\nsquare_mm = 10.0", "columns = 21\nrows = 21\nsquare_mm = 20.0")
            .replace("depths_mm = [500.0, 700.0, 1000.0]", "depths_mm = [1000.0]");
        change(tiny)
    })
}

pub(crate) fn as_is(text: String) -> String {
    text
}

/// The middle of a [`tiny_scene`], of a quarter of its pixels.
pub(crate) fn quarter(text: String) -> String {
    text.replace("width_px = 240", "width_px = 120").replace("height_px = 135", "height_px = 68")
}
