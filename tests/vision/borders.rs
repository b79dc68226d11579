//! Is a corner near a border, a seam or a hole right, or left out?

use super::judge::judge;
use crate::common::board::Scene;
use biprism::raster::Raster;
use biprism::vision::half::{Half, split};
use biprism::vision::{Settings, detect};
use glam::DVec2;

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

/// A corner is measured while at least half of its window is in the picture: cut ever nearer from two sides, so that its ring
/// stays whole, it is there with 0.55 of the window and gone with 0.45.
#[test]
fn a_corner_goes_with_half_of_its_window() {
    // A board corner at (200.3, 180.4), whose window reaches 18 px to each side.
    let board = |width: usize, height: usize| {
        let middle = DVec2::new(width as f64, height as f64) * 0.5;
        Scene::view(width, height, 40.0, 0.0, 0.0, DVec2::new(200.3, 180.4) - middle)
    };
    let (mut kept, mut gone) = (0, 0);
    for cut in 5..13 {
        let scene = board(200 + cut, 180 + cut);
        let (index, at) = *scene
            .corners()
            .iter()
            .min_by(|a, b| a.1.distance(DVec2::new(200.3, 180.4)).total_cmp(&b.1.distance(DVec2::new(200.3, 180.4))))
            .unwrap();
        assert!(at.distance(DVec2::new(200.3, 180.4)) < 1e-9);
        let found = detect(&scene.render(), None, &Settings::default());
        let there = found.corners.iter().any(|c| c.position_px.distance(at) < 0.5);
        let share = scene.visible(index);
        println!("cut {cut}: {share:.3} of the window, found {there}");
        match share {
            s if s > 0.54 => kept += usize::from(there),
            s if s < 0.46 => gone += usize::from(!there),
            _ => continue,
        }
        assert_eq!(there, share > 0.5, "{share} of its window in the picture");
    }
    assert!(kept > 1 && gone > 1, "{kept} {gone}");
}
