//! Is it right through this program's own lenses: diffraction, and a lens out of focus?

use biprism::analysis::view::{Detected, see};
use biprism::render::render;
use biprism::{scene, system};

/// A board of squares of 29 px, turned and tilted, in both halves of a camera without glass.
const PLAIN: &str = "name = \"lenses\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 400\nheight_px = 160\npixel_pitch_um = 11.0\n\
    [prism]\nkind = \"none\"\n[board]\ncolumns = 31\nrows = 21\nsquare_mm = 9.0\nposition_mm = [1.7, -2.3, 1000.0]\n\
    tilt_deg = [6.0, -9.0, 7.0]\n";

fn seen(effect: &str) -> Vec<Detected> {
    let scene = scene::parse(&format!("{PLAIN}{effect}"), "lenses", None).unwrap_or_else(|problem| panic!("{problem}"));
    let system = system::build(&scene).unwrap_or_else(|problem| panic!("{problem}"));
    see(&system, &render(&system, &()).radiance, true, &()).halves.map(|half| half.detected).into()
}

/// Blurs of no Gaussian's shape move no corner by more than 0.002 px RMS, and cost none that the sharp picture shows.
#[test]
fn corners_are_as_right_through_a_lens_as_without() {
    let count = |halves: &[Detected]| halves.iter().map(|half| half.found).collect::<Vec<_>>();
    let plain = count(&seen(""));
    for (name, effect) in [
        ("diffraction, first dark ring at 1.3 px", "[effect.diffraction]\nf_number = 22.0\nwavelength_nm = 550.0\n"),
        ("diffraction, at 2.7 px", "[effect.diffraction]\nf_number = 45.0\nwavelength_nm = 550.0\n"),
        (
            "out of focus by a disc of 1.8 px",
            "[effect.thin_lens]\nf_number = 8.0\nfocus_mm = 800.0\n[quadrature]\npoints = 64\n",
        ),
    ] {
        let halves = seen(effect);
        assert_eq!(count(&halves), plain, "{name}");
        for half in &halves {
            let squares: f64 = half.errors_px.iter().map(|e| e.length_squared()).sum();
            let rms = (squares / half.errors_px.len() as f64).sqrt();
            println!("{name}: {} corners, rms {rms:.5} px, blur {:.3?}", half.found, half.blur_px);
            assert_eq!(half.wrong, Some(0), "{name}");
            assert!(rms < 0.002, "{name}: {rms}");
        }
    }
}
