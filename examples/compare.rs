//! Judges a flat prism against the freeform prism designed from it: `cargo run --release --example compare [SCENE]`.
//!
//! Each is rendered at every depth of the scene's analysis; corners are found in the pictures alone, and their exact places
//! come from the inverse trace, so that every figure is printed measured and true.

use biprism::{Error, compare, scene};
use std::path::Path;

fn run() -> Result<(), Error> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "scenes/paper.toml".to_owned());
    let scene = scene::load(Path::new(&path))?;
    let comparison = compare(&scene, &())?;

    // Print some figures of each prism; a figure that cannot be had is a dash.
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.5}"));
    for design in &comparison.designs {
        let judgement = &design.judgement;
        let figures = [
            ("vertical disparity, RMS", judgement.vertical_disparity_rms_px()),
            ("corners from the designed pinhole, RMS", judgement.designed_corners_rms_px()),
            ("corners from the best pinhole, RMS", judgement.fitted_rms_px()),
        ];
        for (name, figure) in figures {
            let (measured, exact) = (number(figure.measured), number(figure.exact));
            println!("{:9} {name:40} {measured:>9} px measured {exact:>9} px true", design.name);
        }
    }
    Ok(())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(2);
    }
}
