//! Does the eye measure what is there? Pictures with known corners, without noise and with it.

mod common;

use biprism::raster::Raster;
use biprism::vision::half::{Half, split};
use biprism::vision::{Blur, Detection, Polarity, Reason, Settings, detect};
use common::board::{Noise, Scene};
use glam::{DVec2, IVec2};

/// Errors of a detection against the truth.
#[derive(Debug)]
struct Errors {
    found: usize,
    /// Sufficiently visible corners that are not in the answer.
    missing: usize,
    /// Corners of the answer that are none, or whose index does not fit the others'.
    wrong: usize,
    rms: f64,
    max: f64,
    bias: DVec2,
}

/// A corner is sufficiently visible when its ring (4.5 px and the rough position's error) lies in the picture and so
/// does half its window.
const RING_PX: f64 = 5.0;

fn judge(scene: &Scene, detection: &Detection) -> Errors {
    let truth = scene.corners();
    let edge = DVec2::new(scene.width as f64, scene.height as f64);
    let mut errors = Vec::new();
    let mut wrong = 0;
    // Column and row of the truth are an integer rotation and shift of those of the answer.
    let mut pairs = Vec::new();
    for corner in &detection.corners {
        let nearest = truth
            .iter()
            .min_by(|a, b| a.1.distance(corner.position_px).total_cmp(&b.1.distance(corner.position_px)))
            .expect("a scene has corners");
        if nearest.1.distance(corner.position_px) > 1.0 {
            wrong += 1;
            continue;
        }
        errors.push(corner.position_px - nearest.1);
        pairs.push((IVec2::from_array(corner.index), IVec2::from_array(nearest.0)));
    }
    let fits = |column: IVec2, row: IVec2| {
        let shift = pairs.first().map_or(IVec2::ZERO, |(a, b)| *b - column * a.x - row * a.y);
        pairs.iter().filter(|(a, b)| *b == column * a.x + row * a.y + shift).count()
    };
    let turns = [IVec2::X, IVec2::Y, IVec2::NEG_X, IVec2::NEG_Y];
    let right = turns.iter().map(|&t| fits(t, t.perp())).max().unwrap_or(0);
    wrong += pairs.len() - right;
    let missing = truth
        .iter()
        .filter(|(index, p)| {
            p.min_element() > RING_PX && (edge - *p).min_element() > RING_PX && scene.visible(*index) > 0.52
        })
        .filter(|(index, _)| scene.spacing(*index) > 10f64.max(6.3 * scene.sigma_px))
        .filter(|(_, p)| !detection.corners.iter().any(|c| c.position_px.distance(*p) < 1.0))
        .count();
    let n = errors.len().max(1) as f64;
    Errors {
        found: detection.corners.len(),
        missing,
        wrong,
        rms: (errors.iter().map(|e| e.length_squared()).sum::<f64>() / n).sqrt(),
        max: errors.iter().map(|e| e.length()).fold(0.0, f64::max),
        bias: errors.iter().sum::<DVec2>() / n,
    }
}

/// The noise-free scenes of the target, by name.
fn scenes() -> Vec<(&'static str, Scene)> {
    let (w, h) = (640, 720);
    let shift = DVec2::new(3.25, -4.63);
    let plain = |step: f64, roll: f64, tilt: f64| Scene::view(w, h, step, roll, tilt, shift);
    let size = |scene: Scene, columns: f64, rows: f64, shift: DVec2| {
        // The pattern's own origin moves so that the board is centred.
        let mut scene = scene;
        let offset = (DVec2::new(columns, rows) * 0.5).floor() + shift;
        scene.board_from_image = glam::DMat3::from_translation(offset) * scene.board_from_image;
        scene.size = Some(DVec2::new(columns, rows));
        scene
    };
    let bent = |scene: Scene, x: f64, y: f64| Scene { bend_px: DVec2::new(x, y), ..scene };
    let large = Scene::view(960, 1080, 50.0, 2.0, 5.0, shift);
    let blur = |scene: Scene, sigma_px: f64| Scene { sigma_px, ..scene };
    let mut all = vec![
        ("fronto on the pixel lattice", size(Scene::view(w, h, 48.0, 0.0, 0.0, DVec2::ZERO), 12.0, 13.0, DVec2::ZERO)),
        ("fronto off the pixel lattice", size(plain(48.0, 0.0, 0.0), 12.0, 13.0, DVec2::ZERO)),
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
        ("shaded", Scene { shade: 0.5, ..bent(plain(50.0, 2.0, 5.0), 15.0, 12.0) }),
        ("shaded, blur 1", blur(Scene { shade: 0.5, ..bent(plain(50.0, 2.0, 5.0), 15.0, 12.0) }, 1.0)),
        ("shaded, blur 2", blur(Scene { shade: 0.5, ..bent(plain(50.0, 2.0, 5.0), 15.0, 12.0) }, 2.0)),
        ("blur 0.3, tilted 60 deg, rolled 45", blur(Scene::view(300, 300, 60.0, 45.0, 60.0, shift), 0.3)),
        ("blur 0.5, tilted 60 deg, rolled 45", blur(Scene::view(400, 400, 60.0, 45.0, 60.0, shift), 0.5)),
        ("blur 1, tilted 60 deg, rolled 45", blur(plain(60.0, 45.0, 60.0), 1.0)),
        ("blur 2, tilted 60 deg, rolled 45", blur(plain(60.0, 45.0, 60.0), 2.0)),
    ];
    for sigma in [1.0, 2.0, 4.0, 6.0] {
        all.push(("blurred", blur(bent(plain(50.0, 3.0, 10.0), 15.0, 12.0), sigma)));
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
    for (name, scene) in scenes() {
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

#[test]
fn a_flat_picture_has_no_corner() {
    let found = detect(&Raster::filled(64, 64, 0.5), None, &Settings::default());
    assert!(found.corners.is_empty() && found.rejected.is_empty());
}

/// The Cramer-Rao bound of a corner: variances (x, y) of its position, in px^2, per unit variance of a pixel, when the
/// directions of both edges and the six numbers of the light are unknown and the bend and the blur are known.
///
/// Straight edges under a Gaussian and a square pixel, whose mean is taken by 6 x 6 points; derivatives by differences.
fn bound(scene: &Scene, index: [i32; 2], half: f64) -> [f64; 2] {
    let at = |x: f64, y: f64| {
        scene.image(DVec2::new(f64::from(index[0]) + x, f64::from(index[1]) + y)).expect("in the picture")
    };
    let corner = at(0.0, 0.0);
    let steps = glam::DMat2::from_cols(0.5 * (at(1.0, 0.0) - at(-1.0, 0.0)), 0.5 * (at(0.0, 1.0) - at(0.0, -1.0)));
    let inverse = steps.inverse();
    let normal = |t: DVec2| libm::atan2(-t.x, t.y);
    let angles = [normal(steps.x_axis), normal(steps.y_axis)];
    let contrast = 0.5 * (scene.levels[1] - scene.levels[0]);
    // p[0..2]: corner, p[2..4]: angles.
    let pattern = |pixel: DVec2, p: [f64; 4]| {
        let n = 6;
        let sum: f64 = (0..n * n)
            .map(|k| {
                let sub = DVec2::new(f64::from(k % n) + 0.5, f64::from(k / n) + 0.5) / f64::from(n) - 0.5;
                let r = pixel + sub - DVec2::new(p[0], p[1]);
                let edge = |angle: f64| {
                    let (sin, cos) = libm::sincos(angle);
                    libm::erf(DVec2::new(cos, sin).dot(r) / scene.sigma_px * std::f64::consts::FRAC_1_SQRT_2)
                };
                edge(p[2]) * edge(p[3])
            })
            .sum();
        sum / f64::from(n * n)
    };
    let mut fisher = nalgebra::SMatrix::<f64, 10, 10>::zeros();
    let reach = half * (steps.x_axis.abs() + steps.y_axis.abs()) + 1.0;
    let (low, high) = ((corner - reach).floor(), (corner + reach).ceil());
    for j in low.y as i32..high.y as i32 {
        for i in low.x as i32..high.x as i32 {
            let pixel = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
            let local = inverse * (pixel - corner);
            if local.abs().max_element() > half {
                continue;
            }
            let p = [corner.x, corner.y, angles[0], angles[1]];
            let value = pattern(pixel, p);
            let by = |k: usize, h: f64| {
                let (mut a, mut b) = (p, p);
                a[k] += h;
                b[k] -= h;
                contrast * (pattern(pixel, a) - pattern(pixel, b)) / (2.0 * h)
            };
            let r = pixel - corner;
            let gradient = nalgebra::SVector::<f64, 10>::from_row_slice(&[
                by(0, 1e-3),
                by(1, 1e-3),
                by(2, 1e-4),
                by(3, 1e-4),
                1.0,
                r.x,
                r.y,
                value,
                value * r.x,
                value * r.y,
            ]);
            fisher += gradient * gradient.transpose();
        }
    }
    let inverse = fisher.cholesky().expect("a corner is determined").inverse();
    [inverse[(0, 0)], inverse[(1, 1)]]
}

#[test]
fn reaches_the_cramer_rao_bound_with_noise_and_knows_its_error() {
    let scene = Scene {
        sigma_px: 0.7,
        bend_px: DVec2::new(10.0, 8.0),
        ..Scene::view(640, 720, 50.0, 3.0, 8.0, DVec2::new(3.25, -4.63))
    };
    let clean = scene.render();
    let whole: Vec<_> = scene.corners().into_iter().filter(|(index, _)| scene.visible(*index) > 0.999).collect();
    let sample: Vec<[f64; 2]> = whole.iter().step_by(9).map(|(index, _)| bound(&scene, *index, 0.45)).collect();
    let variance = sample.iter().map(|b| b[0] + b[1]).sum::<f64>() / sample.len() as f64;
    for (noise, seeds) in [(0.01, 8), (0.03, 8), (0.05, 8)] {
        let (mut squares, mut distance, mut count, mut sum) = (0.0, 0.0, 0.0, DVec2::ZERO);
        for seed in 0..seeds {
            let image = Noise::new(1000 * seed + (noise * 1e4) as u64).added(&clean, noise);
            let detection = detect(&image, None, &Settings::default());
            let judged = judge(&scene, &detection);
            assert_eq!((judged.missing, judged.wrong), (0, 0), "{noise} {seed}");
            for (_, truth) in &whole {
                let corner = detection
                    .corners
                    .iter()
                    .min_by(|a, b| a.position_px.distance(*truth).total_cmp(&b.position_px.distance(*truth)))
                    .unwrap();
                let e = corner.position_px - *truth;
                squares += e.length_squared();
                distance += 0.5 * e.dot(corner.covariance_px2.inverse() * e);
                sum += e;
                count += 1.0;
            }
        }
        let (rms, limit) = ((squares / count).sqrt(), noise * variance.sqrt());
        let (ratio, calibration, bias) = (rms / limit, distance / count, sum / count);
        println!(
            "noise {noise}: rms {rms:.5} bound {limit:.5} ratio {ratio:.4} calibration {calibration:.3} bias {bias:.5}"
        );
        // The ratio's own standard error is 1 / sqrt(4 count) = 0.012.
        assert!(ratio < 1.05, "{noise}: {ratio}");
        assert!((0.9..1.1).contains(&calibration), "{noise}: {calibration}");
        // Four standard errors of the mean.
        assert!(bias.abs().max_element() < 4.0 * rms / (2.0 * count).sqrt(), "{noise}: {bias}");
    }
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
        ("fronto", Scene::view(640, 720, 48.0, 0.0, 0.0, shift)),
        ("rotated", Scene::view(640, 720, 48.0, 7.0, 0.0, shift)),
        ("tilted", Scene::view(640, 720, 48.0, 5.0, 30.0, shift)),
        ("bent", Scene { bend_px: DVec2::new(15.0, 12.0), ..Scene::view(960, 1080, 50.0, 2.0, 5.0, shift) }),
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
fn pictures_without_a_board_have_no_corner() {
    let noise =
        |width: usize, height: usize, seed: u64| Noise::new(seed).added(&Raster::filled(width, height, 0.5), 0.2);
    let blots = |k: usize| {
        // Upright and lying strokes and dots, as a page of text has them.
        let (x, y) = (k % 300, k / 300);
        let cell = (x / 9) * 7 + (y / 14) * 13;
        let stroke = match cell % 5 {
            0 => x % 9 < 2,
            1 => y % 14 < 2,
            2 => x % 9 < 2 || y % 14 > 10,
            3 => (x % 9 + y % 14) % 9 < 2,
            _ => false,
        };
        if stroke && y % 14 < 12 { 0.1 } else { 0.9 }
    };
    let mut pictures = vec![
        ("1 x 1", Raster::filled(1, 1, 0.3)),
        ("no pixel", Raster::filled(0, 0, 0.3)),
        ("one row", noise(400, 1, 1)),
        ("one column", noise(1, 400, 1)),
        ("6 x 6", noise(6, 6, 1)),
        ("black", Raster::filled(200, 100, 0.0)),
        ("not a number", Raster::filled(200, 100, f32::NAN)),
        ("infinite", Raster::filled(200, 100, f32::INFINITY)),
        ("huge", noise(200, 100, 3).map(|v| v * f32::MAX)),
        ("tiny", noise(200, 100, 3).map(|v| v * f32::MIN_POSITIVE)),
        ("text", Raster::from_data(300, 280, (0..300 * 280).map(blots).collect())),
        ("stripes", Raster::from_data(300, 280, (0..300 * 280).map(|k| f32::from(u8::from(k % 20 < 10))).collect())),
    ];
    pictures.extend((0..6).map(|seed| ("noise", noise(640, 480, seed))));
    for (name, image) in pictures {
        let found = detect(&image, None, &Settings::default());
        assert!(found.corners.is_empty(), "{name}: {} corners", found.corners.len());
        assert_eq!(found.sigma_px, None, "{name}");
        let counted: usize = found.counts().iter().map(|(_, count)| count).sum();
        assert_eq!(counted, found.rejected.len());
    }
}

#[test]
fn of_two_boards_the_larger_is_measured_and_the_other_named() {
    let board = |columns: f64, rows: f64, shift: DVec2| {
        let mut scene = Scene::view(400, 360, 28.0, 6.0, 0.0, shift);
        scene.board_from_image =
            glam::DMat3::from_translation((DVec2::new(columns, rows) * 0.5).floor()) * scene.board_from_image;
        scene.size = Some(DVec2::new(columns, rows));
        scene
    };
    let (large, small) = (board(8.0, 9.0, DVec2::new(3.3, 1.2)), board(6.0, 7.0, DVec2::new(-9.7, 4.1)));
    let (left, right) = (small.render(), large.render());
    let rows = (0..360).flat_map(|j| left.row(j).iter().chain(right.row(j)).copied().collect::<Vec<_>>());
    let detection = detect(&Raster::from_data(800, 360, rows.collect()), None, &Settings::default());
    assert_eq!(detection.corners.len(), 7 * 8);
    assert!(detection.corners.iter().all(|c| c.position_px.x > 400.0));
    let others = detection.rejected.iter().filter(|r| r.reason == Reason::OtherGrid);
    assert_eq!(others.clone().count(), 5 * 6);
    assert!(others.clone().all(|r| r.position_px.x < 400.0));
}

#[test]
fn borders_seams_and_holes_cut_corners_or_leave_them_right() {
    let scene =
        Scene { bend_px: DVec2::new(8.0, 6.0), ..Scene::view(400, 420, 40.0, 9.0, 10.0, DVec2::new(3.25, -4.63)) };
    let clean = scene.render();
    // A seam of masked columns; its pixels hold something else. Scattered dead pixels and a dead block.
    let mut image = clean.clone();
    let mut mask = Raster::filled(400, 420, true);
    for j in 0..420 {
        for i in 0..400 {
            let dead = (i * 7919 + j * 104_729) % 997 == 0 || ((100..115).contains(&i) && (60..80).contains(&j));
            if (200..206).contains(&i) {
                mask.data_mut()[j * 400 + i] = false;
                image.data_mut()[j * 400 + i] = 5.0;
            } else if dead {
                image.data_mut()[j * 400 + i] = if i % 2 == 0 { f32::NAN } else { f32::INFINITY };
            }
        }
    }
    let e = judge(&scene, &detect(&image, Some(&mask), &Settings::default()));
    println!("{e:?}");
    assert_eq!(e.wrong, 0);
    assert!(e.found > 60 && e.max < 3e-3, "{e:?}");
    // Cut anywhere: whatever is left near the border is right.
    for cut in 0..25 {
        let part = clean.columns(150 + cut, 400);
        let shifted = Scene { width: 250 - cut, board_from_image: scene.board_from_image, ..scene.clone() };
        let detection = detect(&part, None, &Settings::default());
        assert!(!detection.corners.is_empty());
        let truth = scene.corners();
        for corner in &detection.corners {
            let at = corner.position_px + DVec2::new((150 + cut) as f64, 0.0);
            let error = truth.iter().map(|(_, p)| p.distance(at)).fold(f64::INFINITY, f64::min);
            assert!(error < 3e-3, "cut {cut}: {at} errs by {error}, {}", shifted.width);
        }
    }
}

#[test]
fn a_hidden_part_is_left_out_with_its_reason() {
    let scene = Scene::view(400, 420, 40.0, 9.0, 10.0, DVec2::new(3.25, -4.63));
    let mut image = scene.render();
    // A grey sheet over the lower right, its edge through many squares.
    for j in 0..420 {
        for i in 0..400 {
            if i + 2 * j > 900 {
                image.data_mut()[j * 400 + i] = 0.5;
            }
        }
    }
    let detection = detect(&image, None, &Settings::default());
    let e = judge(&scene, &detection);
    assert_eq!(e.wrong, 0);
    assert!(e.found > 50 && e.max < 3e-3, "{e:?}");
    assert!(
        detection.rejected.iter().any(|r| matches!(r.reason, Reason::Residual | Reason::OffLattice | Reason::Moved))
    );
}

#[test]
fn answers_are_the_same_for_any_number_of_threads() {
    let scene = Scene { bend_px: DVec2::new(8.0, 6.0), ..Scene::view(400, 420, 30.0, 9.0, 10.0, DVec2::ZERO) };
    let image = Noise::new(5).added(&scene.render(), 0.02);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| detect(&image, None, &Settings::default()))
    };
    let one = run(1);
    assert!(one.corners.len() > 100);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

#[test]
fn halves_are_measured_apart_and_named_in_the_whole_picture() {
    let scene = Scene::view(301, 280, 32.0, 5.0, 0.0, DVec2::new(1.3, 2.1));
    let image = scene.render();
    for half in split(&image) {
        let detection = detect(&half.image, None, &Settings::default());
        assert!(detection.corners.len() > 12);
        for corner in &detection.corners {
            let at = half.full_from_half(corner.position_px);
            assert_eq!(at.x < 150.5, half.half == Half::Left);
            let error = scene.corners().iter().map(|(_, p)| p.distance(at)).fold(f64::INFINITY, f64::min);
            assert!(error < 1e-3, "{at} {error}");
        }
    }
}

#[test]
fn polarity_and_contrast_are_those_of_the_board() {
    let scene = Scene::view(300, 280, 32.0, 5.0, 0.0, DVec2::new(1.3, 2.1));
    let detection = detect(&scene.render(), None, &Settings::default());
    for corner in &detection.corners {
        assert!((corner.contrast - 0.8).abs() < 1e-4);
        let inside = scene.board(corner.position_px + DVec2::splat(5.0)).floor();
        let bright = (inside.x + inside.y) % 2.0 == 0.0;
        assert_eq!(corner.polarity == Polarity::Main, bright);
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
