//! How right is it without noise?

use super::judge::judge;
use crate::common::board::Scene;
use crate::common::long_run::each;
use biprism::raster::Raster;
use biprism::vision::{Blur, Settings, UnevenLight, detect};
use glam::DVec2;

/// The noise-free scenes of the target, by name.
fn scenes() -> Vec<(&'static str, Scene)> {
    let (w, h) = (320, 360);
    let shift = DVec2::new(3.25, -4.63);
    let plain = |step: f64, roll: f64, tilt: f64| Scene::view(w, h, step, roll, tilt, shift);
    let tall = |step: f64, roll: f64, tilt: f64| Scene::view(480, 540, step, roll, tilt, shift);
    let size = |scene: Scene, columns: f64, rows: f64, shift: DVec2| {
        // The pattern's own origin moves so that the board is centred.
        let mut scene = scene;
        let offset = (DVec2::new(columns, rows) * 0.5).floor() + shift;
        scene.board_from_image = glam::DMat3::from_translation(offset) * scene.board_from_image;
        scene.size = Some(DVec2::new(columns, rows));
        scene
    };
    let bent = |scene: Scene, x: f64, y: f64| Scene { bend_px: DVec2::new(x, y), ..scene };
    // Light that falls by as much over fewer pixels would be steeper than what is promised.
    let shaded = |w: usize, h: usize, x: f64, y: f64| Scene {
        shade: 0.5,
        ..bent(Scene::view(w, h, 50.0, 2.0, 5.0, shift), x, y)
    };
    let large = Scene::view(960, 1080, 50.0, 2.0, 5.0, shift);
    let blur = |scene: Scene, sigma_px: f64| Scene { sigma_px, ..scene };
    let mut all = vec![
        ("fronto on the pixel lattice", size(Scene::view(w, h, 48.0, 0.0, 0.0, DVec2::ZERO), 7.0, 8.0, DVec2::ZERO)),
        ("fronto off the pixel lattice", size(plain(48.0, 0.0, 0.0), 7.0, 8.0, DVec2::ZERO)),
        ("fronto 55.37 px", plain(55.37, 0.0, 0.0)),
        ("rotated 7 deg", plain(48.0, 7.0, 0.0)),
        ("rotated 30 deg", plain(48.0, 30.0, 0.0)),
        ("rotated 45 deg", plain(48.0, 45.0, 0.0)),
        ("rotated 100 deg", plain(48.0, 100.0, 0.0)),
        ("tilted 30 deg", plain(48.0, 5.0, 30.0)),
        ("tilted 60 deg", plain(60.0, 10.0, 60.0)),
        ("tilted 60 deg, rolled 45", plain(60.0, 45.0, 60.0)),
        ("bent 15 px", bent(large.clone(), 10.0, 8.0)),
        ("bent 35 px", bent(large.clone(), 22.0, 16.0)),
        ("bent 60 px", bent(large.clone(), 38.0, 28.0)),
        ("bent 90 px", bent(large.clone(), 58.0, 45.0)),
        ("shaded", shaded(400, 450, 6.0, 5.0)),
        ("shaded, blur 1", blur(shaded(400, 450, 6.0, 5.0), 1.0)),
        ("shaded, blur 2", blur(shaded(640, 720, 15.0, 12.0), 2.0)),
        ("blur 0.3, tilted 60 deg, rolled 45", blur(Scene::view(300, 300, 60.0, 45.0, 60.0, shift), 0.3)),
        ("blur 0.5, tilted 60 deg, rolled 45", blur(Scene::view(400, 400, 60.0, 45.0, 60.0, shift), 0.5)),
        ("blur 1, tilted 60 deg, rolled 45", blur(plain(60.0, 45.0, 60.0), 1.0)),
        ("blur 2, tilted 60 deg, rolled 45", blur(tall(60.0, 45.0, 60.0), 2.0)),
    ];
    // Bent by a curvature of 3e-4 / px, as 6 px over 400.
    for sigma in [1.0, 2.0, 4.0, 6.0] {
        all.push(("blurred", blur(bent(plain(50.0, 3.0, 10.0), 3.84, 3.2), sigma)));
    }
    let small = |width: usize, height: usize, scene: Scene| Scene { width, height, ..scene };
    for sigma in [0.05, 0.2, 0.3, 0.42, 0.5] {
        let size = if sigma < 0.1 { 260 } else { 300 };
        all.push(("blurred", blur(small(size, size, bent(plain(40.0, 3.0, 10.0), 2.0, 1.6)), sigma)));
        all.push(("blurred, small squares", blur(small(150, 130, plain(10.37, 4.0, 0.0)), sigma)));
        all.push(("blurred, slanted", blur(Scene::view(200, 180, 40.0, 40.0, 50.0, shift), sigma)));
    }
    for step in [10.0, 12.0, 15.0, 20.0, 30.0, 64.0, 80.0] {
        all.push(("squares, sharp", plain(step, 4.0, 3.0)));
        let side = (6.0 * step) as usize + 100;
        all.push(("squares, blur 0.7", blur(Scene::view(side, side, step, 4.0, 3.0, shift), 0.7)));
    }
    all
}

#[test]
fn measures_noise_free_pictures_to_a_thousandth_of_a_pixel() {
    let mut failed = Vec::new();
    for (name, scene) in each(2, 0, scenes()) {
        let detection = detect(&scene.render(), None, &Settings::default());
        let e = judge(&scene, &detection);
        println!(
            "{name:34} s {:.1} -> {:?}: found {} missing {} wrong {} rms {:.5} max {:.5} bias {:.5}",
            scene.sigma_px,
            detection.sigma_px.map(|s| s.map(|v| (v * 1e4).round() / 1e4)),
            e.found,
            e.missing,
            e.wrong,
            e.rms,
            e.max,
            e.bias.length()
        );
        if e.missing + e.wrong > 0 || e.rms > 1e-3 || e.max > 3e-3 || e.bias.length() > 5e-4 {
            failed.push((name, e));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// The picture as an 8-bit sRGB file holds it, decoded again.
fn eight_bit(image: &Raster<f32>) -> Raster<f32> {
    image.map(|v| {
        let v = f64::from(v).clamp(0.0, 1.0);
        let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 };
        let stored = (encoded * 255.0).round() / 255.0;
        let decoded = if stored <= 0.040_45 { stored / 12.92 } else { libm::pow((stored + 0.055) / 1.055, 2.4) };
        decoded as f32
    })
}

#[test]
fn measures_eight_bit_pictures_to_three_thousandths_of_a_pixel() {
    let shift = DVec2::new(3.25, -4.63);
    for (name, scene) in [
        ("fronto", Scene::view(400, 450, 48.0, 0.0, 0.0, shift)),
        ("rotated", Scene::view(400, 450, 48.0, 7.0, 0.0, shift)),
        ("tilted", Scene::view(400, 450, 48.0, 5.0, 30.0, shift)),
        ("bent", Scene { bend_px: DVec2::new(6.0, 5.0), ..Scene::view(600, 680, 50.0, 2.0, 5.0, shift) }),
        ("small squares", Scene::view(320, 360, 15.0, 4.0, 3.0, shift)),
        ("blur 1", Scene { sigma_px: 1.0, ..Scene::view(400, 400, 40.0, 4.0, 3.0, shift) }),
    ] {
        let e = judge(&scene, &detect(&eight_bit(&scene.render()), None, &Settings::default()));
        println!("8 bit, {name:14} found {} rms {:.5} max {:.5} bias {:.5}", e.found, e.rms, e.max, e.bias.length());
        assert_eq!((e.missing, e.wrong), (0, 0), "{name}");
        // The target; the rounding error of a fronto-parallel edge is the same in every pixel of the edge.
        assert!(e.rms < 3e-3, "{name}: {e:?}");
    }
}

#[test]
fn a_known_blur_and_a_blur_of_each_corner_measure_as_well() {
    let scene = Scene { sigma_px: 1.0, ..Scene::view(300, 280, 32.0, 5.0, 0.0, DVec2::new(1.3, 2.1)) };
    let image = scene.render();
    for blur in [Blur::Known(1.0), Blur::PerCorner] {
        let e = judge(&scene, &detect(&image, None, &Settings { blur, ..Settings::default() }));
        assert!(e.missing + e.wrong == 0 && e.max < 3e-3, "{blur:?} {e:?}");
    }
}

#[test]
fn small_strongly_bent_grids_are_measured_to_a_thousandth_of_a_pixel() {
    // Square, bend and blur in px, tilt and roll in deg. Lines of three to eight corners, bent to radii of 600 px on.
    for (side, bend, sigma_px, tilt, roll) in [
        (170, 4.0, 0.0, 10.0, 3.0),
        (200, 8.0, 0.0, 10.0, 3.0),
        (260, 8.0, 0.7, 10.0, 3.0),
        (260, 15.0, 0.0, 10.0, 3.0),
        (330, 15.0, 0.7, 10.0, 3.0),
        (330, 15.0, 0.0, 30.0, 20.0),
    ] {
        let scene = Scene {
            sigma_px,
            bend_px: DVec2::new(bend, 0.8 * bend),
            ..Scene::view(side, side, 40.0, roll, tilt, DVec2::new(3.25, -4.63))
        };
        let e = judge(&scene, &detect(&scene.render(), None, &Settings::default()));
        println!("{side} px bent {bend} px: found {} missing {} rms {:.5} max {:.5}", e.found, e.missing, e.rms, e.max);
        assert!(e.missing + e.wrong == 0 && e.rms < 1e-3 && e.max < 3e-3, "{side} {bend} {e:?}");
    }
}

#[test]
fn light_is_told_apart_on_the_board_and_in_the_camera() {
    for vignetted in [false, true] {
        let scene = Scene {
            sigma_px: 2.0,
            shade: 0.5,
            vignetted,
            ..Scene::view(320, 360, 40.0, 2.0, 5.0, DVec2::new(3.25, -4.63))
        };
        let image = scene.render();
        let rms =
            |light: UnevenLight| judge(&scene, &detect(&image, None, &Settings { light, ..Settings::default() })).rms;
        let (board, camera) = (rms(UnevenLight::OnBoard), rms(UnevenLight::InCamera));
        println!("vignetted {vignetted}: rms {board:.5} as on the board, {camera:.5} as in the camera");
        let (right, wrong) = if vignetted { (camera, board) } else { (board, camera) };
        // The wrong side of the blur costs its variance times the light's relative change: 4 px^2 times some 0.003 / px.
        assert!(right < 2e-3 && wrong > 4.0 * right, "{vignetted} {right} {wrong}");
    }
}

/// Every edge cuts its pixels alike: position and blur are told apart only when the blur's own search has ended, and an edge
/// next to the border of its pixels is reached in small steps.
#[test]
fn edges_of_one_phase_are_not_taken_for_blurred() {
    for phase in [0.01, 0.037, 0.1, 0.3, 0.5] {
        let scene = Scene::view(320, 240, 40.0, 0.0, 0.0, DVec2::splat(phase));
        let found = detect(&scene.render(), None, &Settings::default());
        let e = judge(&scene, &found);
        // A tenth of what pictures without noise are promised.
        assert!(e.missing + e.wrong == 0 && e.max < 1e-4, "{phase} {:?} {e:?}", found.sigma_px);
    }
}
