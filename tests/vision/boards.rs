//! What does it answer where there is no board, or more than one?

use super::judge::judge;
use crate::common::board::{Noise, Scene};
use biprism::raster::Raster;
use biprism::vision::{Reason, Settings, detect};
use glam::DVec2;

#[test]
fn a_flat_picture_has_no_corner() {
    let found = detect(&Raster::filled(64, 64, 0.5), None, &Settings::default());
    assert!(found.corners.is_empty() && found.rejected.is_empty());
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
