//! The four things for which other programs use biprism: a picture with its truth, a comparison of prisms, the detector by
//! itself, and a design. Every name comes from the crate's root or from a room that it names there.

use biprism::design::{DesignInput, VIRTUAL_CAMERA_Z_MM, text};
use biprism::glam::DVec3;
use biprism::raster::Raster;
use biprism::render::Outputs;
use biprism::scene::{BoardSpec, CameraSpec, DesignSettings, PrismSpec};
use biprism::vision::Settings;
use biprism::{Error, Film, Scene, System, compare, design, detect, scene, system};

fn main() -> Result<(), Error> {
    // Render a scene that is made in code, with what every pixel sees.
    let paper = scene::load("scenes/paper.toml".as_ref())?;
    let camera = CameraSpec { width_px: 320, height_px: 180, pitch_mm: 0.033, ..paper.camera };
    let board = BoardSpec { columns: 21, rows: 21, square_mm: 20.0, ..paper.board };
    let scene = Scene::new(camera, paper.prism.clone(), board);
    scene.check()?;
    let instrument: System = system::build(&scene)?;
    let film: Film = biprism::render::render_wanted(&instrument, Outputs { truth: true }, &());
    let seen = film.board_mm.as_ref().map(|board_mm| board_mm.data()[0]);
    println!("{} x {} px; the first sees {seen:?} mm", film.radiance.width(), film.radiance.height());

    // Judge the flat prism against the freeform one.
    for judged in compare(&scene, &())?.designs {
        let disparity = judged.judgement.vertical_disparity_rms_px();
        println!("{}: vertical disparity {:?} px RMS measured", judged.name, disparity.measured);
    }

    // Find the corners of a picture from elsewhere.
    let square = |k: usize| if (k % 200 / 30 + k / 200 / 30).is_multiple_of(2) { 0.8 } else { 0.1 };
    let picture = Raster::from_data(200, 160, (0..200 * 160).map(square).collect());
    println!("{} corners", detect(&picture, None, &Settings::default()).corners.len());

    // Design a prism, as the text of a scene.
    let PrismSpec::Freeform(prism, _) = paper.prism else { return Ok(()) };
    let settings = DesignSettings { step_px: 40.0, ..DesignSettings::default() };
    let input = DesignInput { camera: paper.camera, prism, settings, virtual_camera_z_mm: VIRTUAL_CAMERA_Z_MM };
    let designed = design(&input)?;
    let lines = text::scene_prism(&designed.front.patch, &designed.back.patch, &prism.body);
    let apex: DVec3 = DVec3::new(0.0, 0.0, prism.ridge_distance_mm);
    println!("{} lines of scene for the prism whose ridge is at {apex} mm", lines.lines().count());
    Ok(())
}
