//! Does a picture that was written as 16 bits show the corners of the one that was rendered?

use crate::common::twin::Tone;
use biprism::raster::Raster;
use biprism::render::render;
use biprism::vision::half::split;
use biprism::vision::{Settings, detect};
use biprism::{scene, system};
use std::fs;

/// As 16 bits of sRGB, read again.
fn written(light: &Raster<f32>) -> Raster<f32> {
    let code = |v: f32| (Tone::Srgb.encode(f64::from(v).clamp(0.0, 1.0)) * 65535.0).round() / 65535.0;
    light.map(|v| Tone::Srgb.decode(code(v)) as f32)
}

/// Every effect's scene, a board seen in part whose lines lie along the pixels, and the raw picture of a colour mosaic: the difference
/// of the last bits decides nothing.
#[test]
fn the_last_bits_of_a_picture_decide_nothing() {
    let mut failed = Vec::new();
    let mut files: Vec<_> = fs::read_dir("scenes/cases").unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| {
        let name = path.file_name().unwrap().to_string_lossy();
        ["effect_", "board_partial", "sensor_bayer"].iter().any(|start| name.starts_with(start))
    });
    files.sort();
    for path in files {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let system = system::build(&scene::load(&path).unwrap()).unwrap();
        let light = render(&system, &()).radiance;
        for (own, other) in split(&light).iter().zip(&split(&written(&light))) {
            let [a, b] = [own, other].map(|half| detect(&half.image, None, &Settings::default()));
            let apart = a.corners.iter().zip(&b.corners).map(|(a, b)| a.position_px.distance(b.position_px));
            let most = apart.fold(0.0, f64::max);
            println!(
                "{name} {}: {} and {} corners, {most:.1e} px apart",
                own.half.name(),
                a.corners.len(),
                b.corners.len()
            );
            if a.corners.len() != b.corners.len() || most > 1e-4 {
                failed.push(format!(
                    "{name} {}: {most:.1e} px, sigma {:?} {:?}",
                    own.half.name(),
                    a.sigma_px,
                    b.sigma_px
                ));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
