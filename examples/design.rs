//! Designs a freeform prism for a camera and puts it into a scene: `cargo run --release --example design`.
//!
//! Writes `designed.toml`, a scene of its own that `biprism render designed.toml --out a.png` takes.

use biprism::design::{DesignInput, VIRTUAL_CAMERA_Z_MM, text};
use biprism::io::atomic;
use biprism::scene::{BiprismSpec, CalibrationSpec, CameraSpec, DesignSettings, GlassSpec};
use biprism::{Error, design, glam, scene};
use std::path::Path;

/// What stands before the prism in the scene: the same camera as below, and a board.
const CAMERA_AND_BOARD: &str = "\
name = \"designed\"

[camera]
focal_length_mm = 25.0
width_px = 1280
height_px = 720
pixel_pitch_um = 5.0

[board]
columns = 31
rows = 31
square_mm = 12.0
position_mm = [0.0, 0.0, 800.0]

";

fn run() -> Result<(), Error> {
    let camera = CameraSpec {
        position_mm: glam::DVec3::ZERO,
        focal_length_mm: 25.0,
        width_px: 1280,
        height_px: 720,
        pitch_mm: 0.005,
        calibration: CalibrationSpec::default(),
    };
    // The flat prism that the design starts from; without a facet angle it is the one that leaves the two views parallel.
    let body = GlassSpec::new(1.48, 1.0);
    let prism = BiprismSpec { body, ridge_distance_mm: 60.0, thickness_mm: 8.0, facet_angle_rad: None };
    let settings = DesignSettings { step_px: 4.0, ..DesignSettings::default() };
    let designed = design(&DesignInput { camera, prism, settings, virtual_camera_z_mm: VIRTUAL_CAMERA_Z_MM })?;
    println!("facet angle   {:.5} deg", designed.camera.alpha_rad.to_degrees());
    println!("baseline      {:.4} mm", designed.camera.baseline_mm());
    println!("optical path  {:.1e} mm between the longest and the shortest", designed.optical_path_spread_mm);
    println!("fits          {:.1e} mm and {:.1e} mm at most", designed.front.max_mm, designed.back.max_mm);

    // The prism comes as scene text, and goes in like any other.
    let text = CAMERA_AND_BOARD.to_owned() + &text::scene_prism(&designed.front.patch, &designed.back.patch, &body);
    scene::parse(&text, "designed.toml", None)?;
    atomic::write_bytes(Path::new("designed.toml"), text.as_bytes())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(2);
    }
}
