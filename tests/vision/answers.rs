//! Is an answer the same every time, and named as it should be?

use crate::common::board::{Noise, Scene};
use biprism::vision::{LatticeCorner, Polarity, Settings, detect, upright};
use glam::DVec2;

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
fn a_lattice_numbered_by_others_becomes_upright() {
    let scene = Scene::view(300, 280, 32.0, 5.0, 0.0, DVec2::new(1.3, 2.1));
    let own: Vec<LatticeCorner> =
        detect(&scene.render(), None, &Settings::default()).corners.iter().map(LatticeCorner::from).collect();
    assert!(own.len() > 40);
    let swapped = |p: Polarity| if p == Polarity::Main { Polarity::Anti } else { Polarity::Main };
    // Rows before columns, turned, mirrored, from another corner; of these the second and the last swap the diagonals.
    type Way = fn([i32; 2]) -> [i32; 2];
    let ways: [(Way, bool); 5] = [
        (|[i, j]| [j, i], false),
        (|[i, j]| [-j + 7, i - 3], true),
        (|[i, j]| [-i - 5, -j], false),
        (|[i, j]| [-j, -i], false),
        (|[i, j]| [i, 100 - j], true),
    ];
    for (way, swaps) in ways {
        let foreign = own.iter().map(|c| LatticeCorner {
            index: way(c.index),
            polarity: c.polarity.map(|p| if swaps { swapped(p) } else { p }),
            ..*c
        });
        let mut back = upright(&foreign.collect::<Vec<_>>());
        back.sort_by_key(|c| c.index);
        assert_eq!(back, own, "{:?}", way([1, 2]));
    }
    assert!(upright(&[]).is_empty());
}
