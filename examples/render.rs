//! Renders what one camera sees through a prism: `cargo run --release --example render [SCENE]`.
//!
//! Writes `render.png`, and `render.exr` with what every pixel's centre sees through the prism, and says what the middle of
//! the right half sees, at full precision.

use biprism::glam::DVec2;
use biprism::report::picture;
use biprism::{Error, render, scene, system};
use std::path::Path;

fn run() -> Result<(), Error> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "scenes/paper.toml".to_owned());
    let scene = scene::load(Path::new(&path))?;

    // Build the instrument: a scene that asks for a designed prism gets it designed here.
    let system = system::build(&scene)?;

    // Take the picture; the closure hears how many more pixels are done.
    let film = render(&system, &());
    for path in ["render.png", "render.exr"] {
        picture::write(Path::new(path), &scene, &system, &film)?;
    }
    println!("wrote render.png and render.exr; {}", film.account);

    // Trace one pixel position: where it ends on the board, or why its ray ends before.
    let [width, height] = [scene.camera.width_px, scene.camera.height_px].map(|n| n as f64);
    match system.trace(DVec2::new(0.75 * width, 0.5 * height)) {
        Ok(hit) => {
            println!("the middle of the right half sees ({}, {}) mm of the board", hit.board_mm.x, hit.board_mm.y)
        }
        Err(fate) => println!("the ray of the middle of the right half ends: {}", fate.name()),
    }
    Ok(())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(2);
    }
}
