//! Does it measure a photograph? No camera is at hand: pictures with what a camera does, through a JPEG file.

use super::judge::{bound, judge};
use crate::common::board::{Noise, Scene};
use biprism::raster::Raster;
use biprism::raster::transfer::Transfer;
use biprism::vision::{Blur, Settings, detect};
use glam::{DMat3, DVec2};
use image::codecs::jpeg::JpegEncoder;
use std::io::Write;

/// Linear light as a JPEG file of some quality holds it in sRGB, read again as a user reads it.
fn through_jpeg(image: &Raster<f32>, quality: u8) -> Raster<f32> {
    let encode = |v: &f32| {
        let v = f64::from(*v).clamp(0.0, 1.0);
        let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round() as u8
    };
    let grey: Vec<u8> = image.data().iter().map(encode).collect();
    let colour: Vec<u8> = grey.iter().flat_map(|&v| [v; 3]).collect();
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, quality)
        .encode(&colour, image.width() as u32, image.height() as u32, image::ExtendedColorType::Rgb8)
        .expect("it can be encoded");
    let mut file = tempfile::Builder::new().suffix(".jpg").tempfile().expect("a temporary file");
    file.write_all(&bytes).expect("it is written");
    biprism::io::read(file.path(), Some(Transfer::Srgb)).expect("it is a JPEG").0
}

/// A board of 14 x 11 squares on a light table, through a lens that bends lines by 10 px, in uneven light.
fn scene(sigma_px: f64, tilt: f64, shade: f64) -> Scene {
    let size = DVec2::new(14.0, 11.0);
    let mut scene = Scene {
        sigma_px,
        shade,
        bend_px: DVec2::new(9.0, -6.0),
        levels: [0.04, 0.7],
        ..Scene::view(800, 600, 44.0, 7.0, tilt, DVec2::new(3.25, -4.63))
    };
    scene.board_from_image = DMat3::from_translation((size * 0.5).floor()) * scene.board_from_image;
    scene.size = Some(size);
    scene
}

#[test]
fn every_corner_of_a_photograph_is_found_as_well_as_its_noise_allows() {
    for (name, scene, noise, quality) in [
        ("good light", scene(0.9, 12.0, 0.2), 0.005, 95),
        ("strong shade, noise, JPEG 85", scene(1.1, 20.0, 0.6), 0.01, 85),
        ("out of focus", scene(2.5, 8.0, 0.4), 0.01, 85),
        ("tilted 50 deg, dim", Scene { levels: [0.02, 0.25], ..scene(0.8, 50.0, 0.4) }, 0.005, 85),
    ] {
        let clean = scene.render();
        let image = through_jpeg(&Noise::new(7).added(&clean, noise), quality);
        // What the pixels of the board are off by, in all.
        let off: Vec<f64> = image.data().iter().zip(clean.data()).map(|(a, b)| f64::from(a - b)).collect();
        let sigma = (off.iter().map(|e| e * e).sum::<f64>() / off.len() as f64).sqrt();
        let corners = scene.corners();
        let sample: Vec<[f64; 2]> = corners.iter().step_by(13).map(|(index, _)| bound(&scene, *index, 0.45)).collect();
        let limit = sigma * (sample.iter().map(|b| b[0] + b[1]).sum::<f64>() / sample.len() as f64).sqrt();
        for blur in [Blur::Common, Blur::PerCorner] {
            let found = detect(&image, None, &Settings { blur, ..Settings::default() });
            let e = judge(&scene, &found);
            println!(
                "{name}, {blur:?}: found {} of {}, off by {sigma:.4}, rms {:.4} bound {limit:.4} ratio {:.2}",
                e.found,
                corners.len(),
                e.rms,
                e.rms / limit
            );
            assert_eq!((e.found, e.missing, e.wrong), (corners.len(), 0, 0), "{name} {blur:?}");
            // The bound is that of white noise as strong; what a JPEG loses is strongest at edges, and alike in blocks of
            // eight pixels.
            assert!(e.rms < 2.0 * limit, "{name} {blur:?}: {e:?}");
        }
    }
}
