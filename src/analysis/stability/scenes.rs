//! Scenes of the catalogue, built from text by the scene parser.

use crate::scene::Scene;
use crate::system::System;
use crate::{scene, system};
use glam::DVec2;

/// The flat prism of the design paper.
pub(super) const FLAT: &str = "kind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545";
/// Its freeform prism, marched coarsely: a fit of degree 5 hardly sees the difference.
pub(super) const FREEFORM: &str = "kind = \"freeform\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n\
                                   [prism.design]\nstep_px = 8.0";
/// Its board.
pub(super) const BOARD: &str = "columns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]";
/// No glass.
pub(super) const NO_GLASS: &str = "kind = \"none\"";

/// Columns and rows of the paper's sensor.
pub(super) const FULL: [usize; 2] = [1920, 1080];

/// f over the pixel pitch in the paper's camera: what a rounding of a direction is worth, in units of eps px.
pub(super) const FOCAL_PX: f64 = 35.0 / 0.0055;

/// Rounding of a whole trace: some 16 operations on directions and on lengths seen under them, each of at most eps of a
/// number of order 1, weighed by the focal length in px.
pub(super) const TRACE_PX: f64 = 16.0 * f64::EPSILON * FOCAL_PX;

/// The text of a scene whose sensor has `size` pixels over the width of the paper's field; `prism` may be whole tables.
pub(super) fn text(size: [usize; 2], camera: &str, prism: &str, board: &str) -> String {
    let pitch_um = 10560.0 / size[0] as f64;
    let prism = if prism.starts_with("[prism]") { prism.to_owned() } else { format!("[prism]\n{prism}") };
    format!(
        "name = \"case\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = {}\nheight_px = {}\npixel_pitch_um = \
         {pitch_um:?}\n{camera}\n{prism}\n[board]\n{board}\n",
        size[0], size[1]
    )
}

/// The scene of [`text`].
///
/// # Panics
/// When the text is no scene: the catalogue's texts are fixed.
pub(super) fn scene(size: [usize; 2], camera: &str, prism: &str, board: &str) -> Scene {
    let text = text(size, camera, prism, board);
    scene::parse(&text, "the catalogue of hard cases", None).unwrap_or_else(|problem| panic!("{problem}"))
}

/// The instrument of [`scene()`].
pub(super) fn built(size: [usize; 2], camera: &str, prism: &str, board: &str) -> System {
    system::build(&scene(size, camera, prism, board)).unwrap_or_else(|problem| panic!("{problem}"))
}

/// `count` places over a sensor, none of them special: a Kronecker sequence of the plastic number.
pub(super) fn places(size: [usize; 2], count: usize) -> impl Iterator<Item = DVec2> {
    let size = DVec2::new(size[0] as f64, size[1] as f64);
    (1..=count).map(move |k| {
        let k = k as f64;
        DVec2::new((k * 0.754_877_666_246_692_8).fract(), (k * 0.569_840_290_998_053_3).fract()) * size
    })
}

/// An error on the board at `px`, in px of the image: by the inverse of the map's derivative there.
pub(super) fn in_px(system: &System, px: DVec2, error_mm: DVec2) -> f64 {
    match system.footprint(px) {
        Ok(footprint) => (footprint.jacobian.inverse() * error_mm).length(),
        Err(_) => f64::NAN,
    }
}
