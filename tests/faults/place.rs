//! A folder of its own for each test, and the command run in it.

use std::fs;
use std::io::{ErrorKind, Write};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::Duration;

/// A small paper: every verb takes some 10 to 100 ms on it.
pub(crate) const SCENE: &str = "name = \"small\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 240\nheight_px = 135\n\
    pixel_pitch_um = 44.0\n[prism]\nkind = \"freeform\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n\
    [prism.design]\nstep_px = 4.0\n[board]\ncolumns = 21\nrows = 21\nsquare_mm = 20.0\nposition_mm = [0.0, 0.0, 1000.0]\n\
    [analysis]\ndepths_mm = [1000.0]\n";

/// What an old file holds.
pub(crate) const OLD: &[u8] = b"an old file, whole";

pub(crate) struct Place {
    pub(crate) folder: tempfile::TempDir,
}

impl Place {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join("scene.toml"), SCENE).expect("it is written");
        Self { folder }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn command(&self, args: &[&str]) -> Command {
        let mut command = if ignores_interrupts() {
            // A child inherits that a signal is ignored; `env` becomes the command, with the same process number.
            let mut command = Command::new("env");
            command.args(["--default-signal=INT", env!("CARGO_BIN_EXE_biprism")]);
            command
        } else {
            Command::new(env!("CARGO_BIN_EXE_biprism"))
        };
        command.current_dir(self.folder.path()).args(args).stdin(Stdio::null());
        command
    }

    /// What a user who may not write everywhere gets, where the one who runs the tests may: by user and group 65534
    /// (nobody), with the command where that one can reach it.
    pub(crate) fn output_as_nobody(&self, args: &[&str]) -> Output {
        let here = self.path("biprism");
        if !here.exists() {
            fs::copy(env!("CARGO_BIN_EXE_biprism"), &here).expect("it is copied");
            for open in [self.folder.path(), &self.path("picture.png")] {
                fs::set_permissions(open, fs::Permissions::from_mode(0o755)).expect("it is ours");
            }
        }
        let mut command = Command::new(here);
        command.current_dir(self.folder.path()).args(args).stdin(Stdio::null());
        command.uid(65534).gid(65534);
        // A command that another test starts just now holds the copy open for writing until it runs.
        loop {
            match command.output() {
                Err(busy) if busy.kind() == ErrorKind::ExecutableFileBusy => thread::sleep(Duration::from_millis(10)),
                done => return done.expect("the command starts"),
            }
        }
    }

    pub(crate) fn output(&self, args: &[&str]) -> Output {
        self.command(args).output().expect("the command starts")
    }
}

/// The verbs that write, with the files that each writes.
pub(crate) const WRITERS: [(&[&str], &[&str]); 5] = [
    (&["render", "scene.toml", "--out", "out/a.png", "--out", "out/a.exr"], &["a.png", "a.exr"]),
    (
        &["design", "scene.toml", "--cloud", "csv,ply", "--out", "out"],
        &["prism.toml", "cloud.csv", "front.ply", "back.ply"],
    ),
    (&["export", "scene.toml", "--format", "zemax-grid", "--out", "out"], &["front.dat", "back.dat", "prism.toml"]),
    (&["corners", "picture.png", "--out", "out/corners.csv"], &["corners.csv"]),
    (
        &["compare", "scene.toml", "--pictures", "all", "--out", "out"],
        &[
            "flat.png",
            "flat.exr",
            "freeform.png",
            "freeform.exr",
            "comparison.png",
            "comparison.svg",
            "overview.png",
            "overview.svg",
            "report.html",
            "report.json",
            "cameras.yml",
            "corners.csv",
        ],
    ),
];

pub(crate) fn no_panic(output: &Output) {
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(!words.contains("panicked"), "{words}");
    assert_ne!(output.status.code(), Some(101), "{words}");
}

/// Says that something was not asked, past the capture of tests that pass.
pub(crate) fn skipped(what: &str) {
    let _ = writeln!(std::io::stderr(), "skipped: {what}");
}

/// Whether SIGINT does nothing here, as in a job that a script put into the background.
pub(crate) fn ignores_interrupts() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> 1 & 1 == 1)
}
