//! Does each level of accuracy keep what it promises?

use crate::instruments::{BOARD, FLAT, FREEFORM, built, scene};
use biprism::accuracy::{Accuracy, Level};
use biprism::render::{Film, Outputs, Plan, picture, render, render_wanted};
use biprism::scene::Scene;
use biprism::system::aim::Aimer;
use biprism::system::{Side, System};
use glam::DVec2;

/// Scenes whose maps bend little and much, whose ridge is off the middle and aslant, whose footprints are slanted; all over
/// the paper's width, on so many rows, and one over its height.
fn scenes(rows: usize) -> Vec<Scene> {
    let shifted = FLAT.to_owned() + "\nposition_mm = [0.8, 0.3, 0.0]\ntilt_deg = [0.5, -0.8, 1.5]";
    let posed = BOARD.replace("[0.0, 0.0, 1000.0]", "[5.0, 3.0, 900.0]\ntilt_deg = [8.0, -11.0, 27.0]");
    // Surfaces of revolution, as two idealised surfaces and as one piece of glass.
    let revolved = |objective: &str, solid: bool| {
        format!(
            "{FREEFORM}\nsolid = {solid}\n[prism.design]\nobjective = \"{objective}\"\nsurface = \"revolved\"\nstep_px = 20.0"
        )
    };
    vec![
        scene(320, rows, &revolved("epipolar", false), BOARD),
        scene(320, rows, &revolved("epipolar", true), BOARD),
        scene(161, rows + 3, &revolved("toed-in", true), &posed),
        scene(480, rows, FLAT, BOARD),
        scene(481, rows + 1, FREEFORM, BOARD),
        scene(320, rows + 3, FREEFORM, &posed),
        scene(320, rows + 3, &shifted, BOARD),
        scene(40, 30, FLAT, BOARD),
    ]
}

fn at(scene: &Scene, level: Level) -> System {
    built(scene).with_accuracy(level.accuracy())
}

/// The largest shift of a line that a difference of pixels can stand for: a line that moves by 1 px changes a pixel by
/// at most the contrast times its diagonal; f32 rounds radiances of up to 0.85 to 3e-8.
fn shift_px(scene: &Scene, a: &Film, b: &Film) -> f64 {
    let pairs = a.radiance.data().iter().zip(b.radiance.data());
    let most = pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
    (most - 6e-8) / ((scene.board.white - scene.board.black) * 2.0f64.sqrt())
}

#[test]
fn lines_lie_where_the_reference_has_them() {
    for (k, scene) in scenes(1).into_iter().enumerate() {
        let system = built(&scene);
        let reference = render(&system.with_accuracy(Level::Reference.accuracy()), &());
        assert!(reference.account.bend_px < 1e-6, "the reference has not settled: {}", reference.account);
        for level in [Level::Draft, Level::Standard, Level::Exact] {
            let film = render(&system.with_accuracy(level.accuracy()), &());
            let shift = shift_px(&scene, &film, &reference);
            assert!(shift < film.account.promise_px, "{shift:e} px: {}", film.account);
            assert!(film.account.achieved_px() < film.account.promise_px, "{}", film.account);
        }
        // Between the presets a target is kept by dividing pixels further.
        let target_px = [3e-3, 1e-6, 2e-7][k % 3];
        let film = render(&system.with_accuracy(Accuracy::for_target(target_px)), &());
        let shift = shift_px(&scene, &film, &reference);
        assert!(shift < target_px, "{shift:e} px: {}", film.account);
        assert!(film.account.achieved_px() <= target_px && film.counts.capped_pixels == 0, "{}", film.account);
    }
}

/// What each level's pixels see, at the exact places of the corners.
#[test]
fn corners_lie_where_the_reference_has_them() {
    for scene in scenes(20) {
        let reference = at(&scene, Level::Reference);
        let aimer = Aimer::new(&reference);
        let [columns, rows] = reference.board().inner_corners();
        let mut corners = Vec::new();
        for (column, row) in (0..columns).flat_map(|c| (0..rows).map(move |r| (c, r))) {
            let board_mm = reference.board().corner_at(column as f64, row as f64);
            for side in Side::ALL {
                let seen = |px: &DVec2| reference.footprint(*px).ok().filter(|f| f.sight.side == side);
                let [width, height] = reference.camera().size_px().map(|n| n as f64);
                let inside = |px: &DVec2| px.cmpge(DVec2::ZERO).all() && px.cmple(DVec2::new(width, height)).all();
                let found = aimer.aim(board_mm, side).ok().filter(inside);
                corners.extend(found.and_then(|px| Some((px, board_mm, seen(&px)?.jacobian))));
            }
        }
        assert!(corners.len() > 20, "{}", corners.len());
        for (level, most_px) in [(Level::Draft, 1e-3), (Level::Standard, 1e-7), (Level::Exact, 1e-9)] {
            let system = at(&scene, level);
            let plan = Plan::new(&system);
            for (px, board_mm, jacobian) in &corners {
                let seen = plan.trace(*px).expect("what the reference sees");
                let shift = (jacobian.inverse() * (seen - *board_mm)).length();
                assert!(shift < most_px, "{}: {shift:e} px at {px}", level.name());
            }
        }
    }
}

#[test]
fn a_target_takes_the_cheapest_level_that_promises_it() {
    for (target_px, level) in [
        (1.0, Level::Draft),
        (0.01, Level::Draft),
        (1e-3, Level::Standard),
        (1e-5, Level::Standard),
        (1e-7, Level::Standard),
        (1e-8, Level::Reference),
    ] {
        let accuracy = Accuracy::for_target(target_px);
        assert_eq!((accuracy.level, accuracy.target_px), (level, Some(target_px)));
    }
    let mut levels = Level::ALL.map(|level| level.accuracy().promise_px);
    levels.reverse();
    assert!(levels.is_sorted(), "a dearer level promises less");
}

#[test]
fn a_picture_without_its_truth_is_the_same_picture() {
    for scene in scenes(20) {
        let system = built(&scene);
        let (with, without) = (render(&system, &()), render_wanted(&system, Outputs { truth: false }, &()));
        assert!(with.radiance == without.radiance && with.counts == without.counts && with.account == without.account);
        assert_eq!((without.class, without.board_mm), (None, None));
    }
}

/// The knobs of the map by themselves: a fixed degree and small patches give the same picture, as far as they go.
#[test]
fn degree_and_patches_can_be_chosen() {
    let scene = &scene(480, 270, FLAT, BOARD);
    let standard = render(&at(scene, Level::Standard), &());
    let mut error = f64::INFINITY;
    for degree in [2, 4, 6, 8] {
        let accuracy = Accuracy { map_degree: Some(degree), map_px: f64::INFINITY, ..Accuracy::standard() };
        let film = render(&built(scene).with_accuracy(accuracy), &());
        assert!(film.account.map_px < error, "degree {degree}: {}", film.account);
        error = film.account.map_px;
    }
    assert!(error < 1e-8, "{error:e}");
    let patched = built(scene).with_accuracy(Accuracy { patch_px: 128, ..Accuracy::standard() });
    let plan = Plan::new(&patched);
    let film = picture(&plan, Outputs { truth: false }, &());
    assert!(film.account.patches > 8, "{}", film.account);
    assert!(shift_px(scene, &film, &standard) < 1e-7);
}
