//! Judges a flat prism against the freeform prism designed from it: `cargo run --release --example compare`.
//!
//! Each is rendered at every depth of the scene's analysis; corners are found in the pictures alone, and their exact places
//! come from the inverse trace, so that every figure is printed measured and true.

use biprism::analysis::judge::judge;
use biprism::scene::{self, PrismSpec};
use biprism::{Error, Scene, system};
use std::path::Path;

fn run() -> Result<(), Error> {
    let scene = scene::load(Path::new("scenes/paper.toml"))?;
    let PrismSpec::Freeform(flat, design) = &scene.prism else {
        return Err(Error::new("scenes/paper.toml", "the prism is not freeform", "take the scene as it is shipped"));
    };
    let prisms = [("flat", PrismSpec::Flat(*flat)), ("freeform", PrismSpec::Freeform(*flat, *design))];
    for (name, prism) in prisms {
        let scene = Scene { prism, ..scene.clone() };
        let system = system::build(&scene)?;
        let (_, judgement) = judge(&scene, &system, &mut |_| (), &|_| ());

        // Vertical disparity of the raw halves, from the corners that were found and from the exact ones.
        let disparity = &judgement.stereo.disparity;
        for (kind, figure) in [("measured", &disparity.measured), ("true", &disparity.exact)] {
            match figure {
                Some(Ok(d)) => println!("{name:9} {kind:9} {:.5} px RMS over {} pairs", d.vertical_rms_px, d.n),
                Some(Err(why)) => println!("{name:9} {kind:9} {why}"),
                None => println!("{name:9} {kind:9} not known"),
            }
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
