//! Is it right on what stands in the world: dark boards, uneven light, edges behind a board's rim, more boards than one?

use super::judge::judge;
use crate::common::board::{Noise, Scene};
use biprism::raster::Raster;
use biprism::vision::{Detection, Settings, detect, detect_all, turned_like};
use glam::{DMat3, DVec2};

/// A board of so many squares in the middle of a picture.
fn board(size: [f64; 2], step: f64, roll: f64, picture: [usize; 2]) -> Scene {
    let size = DVec2::from_array(size);
    let mut scene = Scene::view(picture[0], picture[1], step, roll, 12.0, DVec2::new(1.3, 2.1));
    scene.board_from_image = DMat3::from_translation((size * 0.5).floor()) * scene.board_from_image;
    Scene { size: Some(size), sigma_px: 0.7, ..scene }
}

/// The picture with each value made anew from its pixel's centre and what it was.
fn with(image: &Raster<f32>, value: impl Fn(DVec2, f64) -> f64) -> Raster<f32> {
    let width = image.width();
    let at = |k: usize| DVec2::new((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
    let data = image.data().iter().enumerate().map(|(k, &v)| value(at(k), f64::from(v)) as f32);
    Raster::from_data(width, image.height(), data.collect())
}

/// Every corner of the board, and nothing else.
fn assert_whole(name: &str, scene: &Scene, found: &Detection) {
    let e = judge(scene, found);
    assert_eq!((e.found, e.missing, e.wrong), (scene.corners().len(), 0, 0), "{name}: {e:?}");
}

/// An edge behind a board that has no margin meets the rim where two squares meet, and crosses it there: that crossing is no
/// corner of the board, nor is one on the squares behind the board, whatever its levels.
#[test]
fn an_edge_behind_the_rim_makes_no_corner() {
    for (number, (meets, slope, levels)) in [
        (DVec2::new(4.0, 8.0), 0.1, [0.7, 0.1]),
        (DVec2::new(4.0, 8.0), -0.3, [0.1, 0.7]),
        (DVec2::new(10.0, 3.0), 0.2, [0.8, 0.1]),
        (DVec2::new(10.0, 3.0), -0.1, [0.1, 0.8]),
        (DVec2::new(6.0, 0.0), 0.0, [0.6, 0.2]),
        (DVec2::new(6.0, 0.0), 0.2, [0.2, 0.6]),
    ]
    .into_iter()
    .enumerate()
    {
        let scene = board([10.0, 8.0], 36.0, 4.0, [480, 400]);
        let size = DVec2::new(10.0, 8.0);
        // By 8 x 8 points a pixel, since the exact picture has no background but light.
        let seen = |p: DVec2| {
            let at = scene.board(p);
            let away = at - meets;
            if at.min_element() > 0.0 && (size - at).min_element() > 0.0 {
                let even = (at.x.floor() + at.y.floor()) % 2.0 == 0.0;
                scene.levels[usize::from(even)]
            } else {
                let (along, across) = if meets.x == 10.0 { (away.y, away.x) } else { (away.x, away.y) };
                levels[usize::from(along - slope * across > 0.0)]
            }
        };
        let points = |k: i32| DVec2::new(f64::from(k % 8) - 3.5, f64::from(k / 8) - 3.5) / 8.0;
        let blank = Raster::filled(480, 400, 0.0);
        let image = with(&blank, |p, _| (0..64).map(|k| seen(p + points(k))).sum::<f64>() / 64.0);
        let found = detect(&Noise::new(3).added(&image, 0.01), None, &Settings::default());
        assert_whole(&format!("edge {number}"), &scene, &found);
    }
}

/// Light that falls to e^-4 over a board, along it and aslant, costs no corner: neither for want of strength, nor of contrast, nor
/// because bright corners leave more than the dark ones do.
#[test]
fn light_that_falls_over_a_board_costs_no_corner() {
    for (size, step) in [([10.0, 8.0], 36.0), ([10.0, 7.0], 38.0), ([6.0, 5.0], 60.0), ([15.0, 11.0], 24.0)] {
        let scene = board(size, step, 5.0, [480, 400]);
        let even = scene.render();
        for aslant in [0.0, 60.0, 200.0f64] {
            let direction = DVec2::from_angle(aslant.to_radians());
            let along: Vec<f64> = scene.corners().iter().map(|(_, p)| p.dot(direction)).collect();
            let (first, last) = along.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
            let light = |p: DVec2| libm::exp(-4.0 * ((p.dot(direction) - first) / (last - first)).clamp(-0.2, 1.3));
            // Noise of light: with its root, 1 % where it is full.
            let mut noise = Noise::new(7);
            let image = with(&even, |p, v| v * light(p));
            let deviates: Vec<f64> = image.data().iter().map(|_| noise.normal()).collect();
            let image = Raster::from_data(
                480,
                400,
                image.data().iter().zip(deviates).map(|(&v, n)| v + (0.004 * f64::from(v).sqrt() * n) as f32).collect(),
            );
            let found = detect(&image, None, &Settings::default());
            assert_whole(&format!("{size:?} at {aslant} deg"), &scene, &found);
        }
    }
}

/// A board at 3 % of the light of what stands beside it is found: of blots that are no board, and of a smaller board, which is the
/// second where all boards are asked for.
#[test]
fn a_dark_board_is_found_beside_bright_things() {
    let scene = board([10.0, 7.0], 30.0, -8.0, [380, 400]);
    let dark = with(&scene.render(), |_, v| 0.03 * v);
    let beside = |bright: &Raster<f32>| {
        let rows = (0..400).flat_map(|j| dark.row(j).iter().chain(bright.row(j)).copied().collect::<Vec<_>>());
        Noise::new(5).added(&Raster::from_data(480, 400, rows.collect()), 1e-4)
    };
    let mut noise = Noise::new(11);
    let blots: Vec<bool> = (0..17 * 67).map(|_| noise.uniform() > 0.5).collect();
    let blots = with(&Raster::filled(100, 400, 0.0), |p, _| {
        if blots[p.x as usize / 6 + 17 * (p.y as usize / 6)] { 0.9 } else { 0.05 }
    });
    assert_whole("blots", &scene, &detect(&beside(&blots), None, &Settings::default()));

    // The other is brighter, and has fewer corners.
    let other = Scene { size: Some(DVec2::new(4.0, 9.0)), ..board([4.0, 9.0], 20.0, 3.0, [100, 400]) };
    let image = beside(&other.render());
    assert_whole("board", &scene, &detect(&image, None, &Settings::default()));
    let all = detect_all(&image, None, &Settings::default());
    assert_eq!(all.iter().map(|found| found.corners.len()).collect::<Vec<_>>(), [54, 24]);
    assert_whole("first of all", &scene, &all[0]);
    let shifted = |c: &biprism::vision::Corner| biprism::vision::Corner {
        position_px: c.position_px - DVec2::new(380.0, 0.0),
        ..*c
    };
    let second = Detection { corners: all[1].corners.iter().map(shifted).collect(), ..all[1].clone() };
    assert_whole("second", &other, &second);
}

/// One board rolled by 44 deg in one picture and by 46 deg in the other is numbered alike, with the same colours.
#[test]
fn a_second_picture_is_numbered_like_the_first() {
    let [one, two] = [44.0, 46.0].map(|roll| board([8.0, 6.0], 28.0, roll, [320, 400]));
    let found = [&one, &two].map(|scene| detect(&scene.render(), None, &Settings::default()));
    let [first, other] = found;
    // The corner of the board that each is, by the truth.
    let named = |scene: &Scene, found: &Detection| -> Vec<([i32; 2], [i32; 2], bool)> {
        let main = |c: &biprism::vision::Corner| c.polarity == biprism::vision::Polarity::Main;
        let truth = scene.corners();
        let nearest = |at: DVec2| truth.iter().min_by(|a, b| a.1.distance(at).total_cmp(&b.1.distance(at))).unwrap().0;
        let mut named: Vec<_> = found.corners.iter().map(|c| (nearest(c.position_px), c.index, main(c))).collect();
        named.sort_unstable();
        named
    };
    assert_eq!(first.corners.len(), 35);
    assert_ne!(named(&one, &first), named(&two, &other), "else nothing is to be turned");
    assert_eq!(named(&one, &first), named(&two, &turned_like(&first, other.clone())));
    // Turned back it is what it was.
    assert_eq!(turned_like(&other, turned_like(&first, other.clone())), other);
}
