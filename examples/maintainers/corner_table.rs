//! What the measuring eye makes of the kinds of scene that other detectors were measured on: the table of
//! `docs/corners.md`.
//!
//! ```sh
//! cargo run --release --example corner_table                 # prints the table
//! cargo run --release --example corner_table -- FOLDER       # also writes the pictures and their true corners
//! ```
//!
//! Boards of 13 x 17 inner corners on 960 x 1080 px, black 0.05 and white 0.85, rendered exactly by a renderer of the
//! tests. `tools/compare_corners.py FOLDER` measures the same files with OpenCV.

#[path = "../../tests/common/mod.rs"]
mod common;
#[path = "../../tests/vision/judge.rs"]
#[allow(dead_code, reason = "shared with tests that use more of it")]
mod judge;

use biprism::error::Error;
use biprism::io::corners::{CornerFormat, CornerView, IndexOrigin, ListedCorner, to_text};
use biprism::io::{atomic, png};
use biprism::raster::Raster;
use biprism::vision::{Settings, detect};
use common::board::{Noise, Scene};
use glam::{DMat3, DVec2};
use judge::{bound, judge};
use std::path::Path;
use std::process::ExitCode;

/// Squares of the board.
const SIZE: DVec2 = DVec2::new(14.0, 18.0);

/// A whole board, its middle at the middle of the picture plus `shift`.
fn whole(step: f64, roll: f64, tilt: f64, shift: DVec2) -> Scene {
    let mut scene = Scene::view(960, 1080, step, roll, tilt, shift);
    scene.board_from_image = DMat3::from_translation(SIZE * 0.5) * scene.board_from_image;
    scene.size = Some(SIZE);
    scene
}

/// Name, what it shows, the scene, and the noise as a share of full scale.
fn scenes() -> Vec<(&'static str, &'static str, Scene, f64)> {
    let middle = DVec2::new(3.25, -4.63);
    let bent = |sigma_px: f64, bend: f64| Scene {
        sigma_px,
        bend_px: DVec2::new(bend, 0.8 * bend),
        ..whole(50.0, 2.0, 5.0, middle)
    };
    let small = |step: f64| Scene { sigma_px: 0.5, bend_px: DVec2::new(10.0, 8.0), ..whole(step, 2.0, 5.0, middle) };
    let partial = |roll: f64| Scene {
        sigma_px: 0.5,
        bend_px: DVec2::new(15.0, 12.0),
        ..Scene::view(960, 1080, 50.0, roll, 8.0, middle)
    };
    vec![
        ("A0", "facing, edges on pixel borders", whole(52.0, 0.0, 0.0, DVec2::ZERO), 0.0),
        ("A1", "facing, off by (.25, .37) px", whole(52.0, 0.0, 0.0, DVec2::new(0.25, 0.37)), 0.0),
        ("A2", "facing, squares of 55.37 px", whole(55.37, 0.0, 0.0, DVec2::new(0.25, 0.37)), 0.0),
        ("A3", "turned by 7 deg", whole(48.0, 7.0, 0.0, middle), 0.0),
        ("A4", "turned by 30 deg", whole(40.0, 30.0, 0.0, middle), 0.0),
        ("B1", "tilted by 25 deg", whole(50.0, 3.0, 25.0, middle), 0.0),
        ("B2", "tilted by 50 deg", whole(52.0, 8.0, 50.0, middle), 0.0),
        ("C1", "prism, bent by 15 px", bent(0.0, 15.0), 0.0),
        ("C2", "prism, bent by 30 px", bent(0.0, 30.0), 0.0),
        ("D2", "prism, blur 0.5 px", bent(0.5, 15.0), 0.0),
        ("D3", "prism, blur 1 px", bent(1.0, 15.0), 0.0),
        ("D4", "prism, blur 2 px", bent(2.0, 15.0), 0.0),
        ("E1", "prism, blur 0.7 px, noise 1 %", bent(0.7, 15.0), 0.01),
        ("E3", "prism, blur 0.7 px, noise 3 %", bent(0.7, 15.0), 0.03),
        ("E5", "prism, blur 0.7 px, noise 5 %", bent(0.7, 15.0), 0.05),
        ("G20", "squares of 20 px, blur 0.5 px", small(20.0), 0.0),
        ("G15", "squares of 15 px, blur 0.5 px", small(15.0), 0.0),
        ("G12", "squares of 12 px, blur 0.5 px", small(12.0), 0.0),
        ("G15n", "squares of 15 px, blur 0.5 px, noise 3 %", small(15.0), 0.03),
        ("H1", "cut by all borders, blur 0.5 px", partial(4.0), 0.0),
        ("H2", "cut by all borders, blur 0.5 px, noise 3 %", partial(12.0), 0.03),
    ]
}

/// The picture as an 8-bit sRGB file holds it, and decoded again.
fn eight_bit(image: &Raster<f32>) -> [Raster<f32>; 2] {
    let encode = |v: f32| {
        let v = f64::from(v).clamp(0.0, 1.0);
        let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round()
    };
    let decode = |v: f32| {
        let stored = f64::from(v) / 255.0;
        (if stored <= 0.040_45 { stored / 12.92 } else { libm::pow((stored + 0.055) / 1.055, 2.4) }) as f32
    };
    let stored = image.map(|v| encode(v) as f32);
    let decoded = stored.map(decode);
    [stored, decoded]
}

fn run(folder: Option<&Path>) -> Result<(), Error> {
    println!("| scene | shows | true | found | false | float RMS | float max | 8 bit RMS | bound |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for (name, shows, scene, noise) in scenes() {
        let clean = scene.render();
        let image = if noise > 0.0 { Noise::new(1).added(&clean, noise) } else { clean };
        let [stored, decoded] = eight_bit(&image);
        let measure = |image: &Raster<f32>| judge(&scene, &detect(image, None, &Settings::default()));
        let (float, eight) = (measure(&image), measure(&decoded));
        let corners = scene.corners();
        let limit = (noise > 0.0).then(|| {
            let whole: Vec<[i32; 2]> =
                corners.iter().map(|(i, _)| *i).filter(|&i| scene.visible(i) > 0.999).step_by(11).collect();
            let variance: f64 = whole.iter().map(|&i| bound(&scene, i, 0.45)).map(|b| b[0] + b[1]).sum();
            noise * (variance / whole.len() as f64).sqrt()
        });
        println!(
            "| {name} | {shows} | {} | {} | {} | {:.5} | {:.5} | {:.5} | {} |",
            corners.len(),
            float.found,
            float.wrong,
            float.rms,
            float.max,
            eight.rms,
            limit.map_or("-".to_owned(), |l| format!("{l:.5}"))
        );
        if let Some(folder) = folder {
            let grey = stored.map(|v| [v as u8; 3]);
            png::write_rgb(&folder.join(format!("{name}.png")), &grey, &biprism::io::Notes::default())?;
            let listed = |&(index, position_px): &([i32; 2], DVec2)| ListedCorner { index, position_px, quality: None };
            let truth = CornerView {
                name: "whole".to_owned(),
                index_origin: Some(IndexOrigin::Board),
                corners: corners.iter().map(listed).collect(),
                rejected: Vec::new(),
                blur_px: None,
                elongated_blur: None,
                lean_px: None,
                marked_squares: false,
                transfer: None,
            };
            let own = CornerView::new("whole", 0, &detect(&decoded, None, &Settings::default()));
            for (ending, view) in [("true", truth), ("own", own)] {
                for (format, kind) in [(CornerFormat::Csv, "csv"), (CornerFormat::OpenCv, "yml")] {
                    let path = folder.join(format!("{name}.{ending}.{kind}"));
                    atomic::write_bytes(&path, to_text(std::slice::from_ref(&view), format).as_bytes())?;
                }
            }
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let folder = std::env::args().nth(1);
    match run(folder.as_deref().map(Path::new)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{}", problem.render(false));
            ExitCode::from(2)
        }
    }
}
