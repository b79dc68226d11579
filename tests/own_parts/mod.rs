//! What users bring as surfaces: point clouds, meshes and closed bodies, right or refused with the next step.

#![allow(clippy::unwrap_used, reason = "a test fails by a panic")]

mod bodies;
mod clouds;
mod creases;
mod doubts;

use biprism::io::mesh::{MeshFormat, parse_mesh};
use biprism::render::render;
use biprism::scene::{self, Scene};
use biprism::system::{self, System};
use glam::{DVec2, DVec3};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The front of the tests: a facet with a little of every power, odd ones of y included where `odd` is not 0.
fn front(x: f64, y: f64, odd: f64) -> f64 {
    40.0 + 0.2 * x - 2e-3 * x * x + 1e-3 * y * y + 3e-5 * x * x * x - 2e-6 * x * y * y * y * y
        + odd * y * (1.0 + 0.01 * x)
}

fn back(x: f64, y: f64) -> f64 {
    46.0 + 1e-3 * x + 2e-4 * y * y
}

/// Points of a surface over x in `xs`, y in -12..12, as CSV.
fn csv(xs: [f64; 2], z: impl Fn(f64, f64) -> f64) -> String {
    points(xs)
        .map(|p| (p.x, p.y, z(p.x, p.y)))
        .fold("x,y,z\n".to_owned(), |text, (x, y, z)| text + &format!("{x:?},{y:?},{z:?}\n"))
}

fn points([low, high]: [f64; 2]) -> impl Iterator<Item = DVec2> {
    let along = |k: usize, low: f64, high: f64, n: usize| low + (high - low) * k as f64 / (n - 1) as f64;
    (0..23 * 19).map(move |k| DVec2::new(along(k % 23, low, high, 23), along(k / 23, -12.0, 12.0, 19)))
}

const RIGHT: [f64; 2] = [-1.0, 16.0];

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// A scene with this `[prism]` table, on a sensor of 96 x 80 px.
    fn scene(&self, prism: &str) -> PathBuf {
        self.scene_with(prism, "")
    }

    fn scene_with(&self, prism: &str, more: &str) -> PathBuf {
        let text = format!(
            "name = \"own\"\n[camera]\nfocal_length_mm = 25.0\nwidth_px = 96\nheight_px = 80\npixel_pitch_um = 88.0\n\
             [prism]\nindex = 1.5168\n{prism}\n[board]\ncolumns = 21\nrows = 15\nsquare_mm = 12.0\n\
             position_mm = [0.0, 0.0, 600.0]\n{more}\n"
        );
        let path = self.path().join("scene.toml");
        fs::write(&path, text).unwrap();
        path
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path().join(name), bytes).unwrap();
    }

    fn run(&self, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_biprism")).current_dir(self.path()).args(args).output().unwrap()
    }

    /// The instrument of a prism, and what `check` says of it in words.
    fn built(&self, prism: &str) -> System {
        built(&scene::load(&self.scene(prism)).unwrap_or_else(|problem| panic!("{problem}")))
    }

    /// The doubts of a prism that can be.
    fn doubts(&self, prism: &str) -> Vec<String> {
        let scene = scene::load(&self.scene(prism)).unwrap_or_else(|problem| panic!("{problem}"));
        system::doubts(&scene, &built(&scene))
    }

    /// What is said of a prism that cannot be.
    fn refused(&self, prism: &str) -> String {
        let problem = scene::load(&self.scene(prism)).and_then(|scene| system::build(&scene).map(|_| ()));
        let words = problem.expect_err(prism).to_string();
        let out = self.run(&["check", "scene.toml"]);
        assert_eq!(out.status.code(), Some(2), "{}", said(&out.stderr));
        words
    }
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn built(scene: &Scene) -> System {
    system::build(scene).unwrap_or_else(|problem| panic!("{problem}"))
}

fn clouds(front: &str, back: &str) -> String {
    format!("kind = \"point_cloud\"\nfront = {{ {front} }}\nback = {{ {back} }}")
}

const FRONT: &str = "file = \"front.csv\", degree = 5";
const BACK: &str = "file = \"back.csv\", degree = 2";

/// A place with the two clouds of the tests.
fn good() -> Place {
    let place = Place::new();
    place.write("front.csv", csv(RIGHT, |x, y| front(x, y, 0.0)));
    place.write("back.csv", csv(RIGHT, back));
    place
}

/// The farthest that what the two instruments see is apart, in mm on the board.
fn apart_mm(a: &System, b: &System) -> f64 {
    let places = (0..300).map(|k| {
        DVec2::new(96.0 * (f64::from(k) * 0.754_877_666).fract(), 80.0 * (f64::from(k) * 0.569_840_291).fract())
    });
    places.fold(0.0, |worst: f64, px| {
        let [a, b] = [a, b].map(|s| s.trace(px).unwrap_or_else(|fate| panic!("{px}: {fate:?}")));
        assert_eq!(a.side, b.side);
        worst.max(a.board_mm.distance(b.board_mm))
    })
}
