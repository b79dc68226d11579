//! Scenes for the tests, made from text through the front door.

use biprism::effect::Effects;
use biprism::raster::Raster;
use biprism::render::{Outputs, render_wanted};
use biprism::scene::{self, Scene};
use biprism::system::{self, System};

/// A scene whose prism is the given TOML table body, on a sensor of `width` x `height`.
pub(crate) fn scene(width: usize, height: usize, prism: &str, board: &str) -> Scene {
    scene_from(width, height, "", prism, board)
}

/// [`scene`] with further keys of the camera.
pub(crate) fn scene_from(width: usize, height: usize, camera: &str, prism: &str, board: &str) -> Scene {
    // The pitch keeps the field of the paper: 10.56 mm across.
    let pitch_um = 10560.0 / width as f64;
    let text = format!(
        "name = \"test\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = {width}\nheight_px = {height}\n\
         pixel_pitch_um = {pitch_um}\n{camera}\n[prism]\n{prism}\n[board]\n{board}\n"
    );
    scene::parse(&text, "test", None).unwrap_or_else(|problem| panic!("{problem}\n{text}"))
}

/// No prism at all.
pub(crate) const NO_GLASS: &str = "kind = \"none\"";
/// The flat prism of the paper.
pub(crate) const FLAT: &str = "kind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545";
/// The freeform prism of the paper.
pub(crate) const FREEFORM: &str = "kind = \"freeform\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545";
/// The board of the paper.
pub(crate) const BOARD: &str = "columns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]";

/// The instrument of a scene that can be built.
pub(crate) fn built(scene: &Scene) -> System {
    system::build(scene).unwrap_or_else(|problem| panic!("{problem}"))
}

/// The instrument of a scene with other effects.
pub(crate) fn with(scene: &Scene, effects: Effects) -> System {
    built(&Scene { effects, ..scene.clone() })
}

/// The picture of an instrument, without its truth.
pub(crate) fn picture(system: &System) -> Raster<f32> {
    render_wanted(system, Outputs { truth: false }, &()).radiance
}

/// The share of a disk of radius 1 to the left of x, integrated over x: of a straight edge seen through a circular
/// aperture, out of focus.
pub(crate) fn edge_integral(x: f64) -> f64 {
    let inside = |x: f64| {
        let rest = (1.0 - x * x).max(0.0);
        0.5 * x + (x * libm::asin(x) + rest.sqrt() - rest * rest.sqrt() / 3.0) / std::f64::consts::PI
    };
    if x >= 1.0 {
        inside(1.0) + (x - 1.0)
    } else if x <= -1.0 {
        0.0
    } else {
        inside(x)
    }
}
