//! Boards whose bright squares hold marks, as those of a ChArUco board do.

use super::judge::judge;
use crate::common::board::{Noise, Scene};
use biprism::raster::Raster;
use biprism::vision::{Settings, detect};
use glam::{DMat3, DVec2};

/// Fields along a side of a mark, its black border with them: a marker of 5 x 5 bits.
const FIELDS: f64 = 7.0;

/// A board of 8 x 6 squares with marks of this share of a square, by 8 x 8 points a pixel.
fn marked(scene: &Scene, share: f64, seed: u64) -> Raster<f32> {
    let mut noise = Noise::new(seed);
    let bits: Vec<bool> = (0..8 * 6 * 49).map(|_| noise.uniform() > 0.5).collect();
    let size = scene.size.expect("it has one");
    let seen = |p: DVec2| -> bool {
        let at = scene.board(p);
        if at.min_element() < 0.0 || (size - at).min_element() <= 0.0 {
            return true;
        }
        // Columns and rows count as the scene's squares do: where their sum is even it is bright.
        let cell = at.floor();
        if (cell.x + cell.y) % 2.0 != 0.0 {
            return false;
        }
        let field = ((at - cell - 0.5 * (1.0 - share)) / share * FIELDS).floor();
        let inside = field.min_element() >= 0.0 && field.max_element() < FIELDS;
        let border = field.min_element() < 1.0 || field.max_element() >= FIELDS - 1.0;
        let bit = || bits[((cell.y * 8.0 + cell.x) * 49.0 + field.y * FIELDS + field.x) as usize];
        !inside || (!border && bit())
    };
    let points = |k: i32| DVec2::new(f64::from(k % 8) - 3.5, f64::from(k / 8) - 3.5) / 8.0;
    let mean = |k: usize| {
        let p = DVec2::new((k % scene.width) as f64 + 0.5, (k / scene.width) as f64 + 0.5);
        let bright = (0..64).filter(|i| seen(p + points(*i))).count() as f64 / 64.0;
        (scene.levels[0] + (scene.levels[1] - scene.levels[0]) * bright) as f32
    };
    let data = (0..scene.width * scene.height).map(mean).collect();
    noise.added(&Raster::from_data(scene.width, scene.height, data), 0.003)
}

/// Every corner of the squares is found, none of a mark, and what the squares hold moves them by less than it moves those of
/// `findChessboardCornersSB`, which errs by 0.03 px at least on such boards.
#[test]
fn marks_in_the_squares_cost_no_corner_and_make_none() {
    for (number, (share, step, roll, tilt)) in
        [(0.5, 40.0, 3.0, 0.0), (0.7, 40.0, 12.0, 25.0), (0.8, 45.0, -6.0, 20.0), (0.8, 42.0, 20.0, 10.0)]
            .into_iter()
            .enumerate()
    {
        let size = DVec2::new(8.0, 6.0);
        let mut scene = Scene::view(420, 330, step, roll, tilt, DVec2::new(1.3, 2.1));
        scene.board_from_image = DMat3::from_translation((size * 0.5).floor()) * scene.board_from_image;
        let scene = Scene { size: Some(size), ..scene };
        let found = detect(&marked(&scene, share, number as u64), None, &Settings::default());
        let e = judge(&scene, &found);
        println!(
            "marks of {share}: {} of {}, {} wrong, rms {:.4}, max {:.4}",
            e.found,
            scene.corners().len(),
            e.wrong,
            e.rms,
            e.max
        );
        assert_eq!((e.found, e.missing, e.wrong), (scene.corners().len(), 0, 0), "{share} {step}: {e:?}");
        assert!(found.marked_squares && e.rms < 0.03, "{share} {step}: {e:?}");
    }
    // A board without marks is none.
    let plain = Scene::view(300, 260, 36.0, 5.0, 10.0, DVec2::new(1.3, 2.1));
    assert!(!detect(&Noise::new(1).added(&plain.render(), 0.03), None, &Settings::default()).marked_squares);
}
