//! Poses that are wrong, or not known.

use super::{
    FLAT, FREEFORM, LARGE, SMALL, TRUE_POSE, built, disparities, measured, photographed, text, through_a_lens,
};
use crate::command::{biprism, json};
use crate::common::board::Noise;
use biprism::analysis::half_image::{HalfFrame, virtual_camera};
use biprism::analysis::judge::Judgement;
use biprism::analysis::photograph::{MatchedBy, PlacedBy, PoseSource, photograph};
use biprism::analysis::truth;
use biprism::analysis::view::{DetectedLattice, detect};
use biprism::geom::Pose;
use biprism::raster::Raster;
use biprism::render::render;
use biprism::system::aim::Aimer;
use biprism::vision::half::Half;
use biprism::vision::{LatticeCorner, Polarity};
use glam::{DVec2, IVec2};
use std::fs;

/// Off by 20 mm, and by 3 deg about each axis in turn with the true one.
const OFF_POSE: &str = "position_mm = [20.0, -13.0, 1027.3205]\ntilt_deg = [7.0, -6.0, 2.0]\n";
/// What a pair of corners may be off by: what the task of measuring allows.
const WITHIN_PX: f64 = 0.01;

/// A pose that is off by 20 mm and 3 deg, JPEG, blur and noise leave the vertical disparity as it is.
#[test]
fn a_photograph_is_measured_whatever_pose_is_stated() {
    for prism in [FLAT, FREEFORM] {
        let own = through_a_lens(&text(prism, LARGE, TRUE_POSE));
        let stated = through_a_lens(&text(prism, LARGE, OFF_POSE));
        let (folder, picture) = photographed(&own);
        let photo = measured(&picture, &stated);
        let [found, exact] = disparities(&photo, &own);
        let pose = photo.pose.as_ref().expect("there are corners");
        println!("vertical disparity {found:.4} px, true {exact:.4}; {pose:?}");
        assert!((found - exact).abs() < WITHIN_PX, "{found} {exact}");
        assert_eq!(pose.source, PoseSource::Mismatch);
        // What is left is the noise of a corner: some 0.01 px at 1 % and 0.8 px of blur, twice that with what a JPEG adds.
        assert!(pose.deviation.is_some_and(|left| left.rms < 0.04), "{pose:?}");

        // The command says the same.
        fs::write(folder.path().join("scene.toml"), &stated).expect("written");
        let args = ["measure", "photo.jpg", "--scene", "scene.toml", "--transfer", "srgb", "--json"];
        let told = biprism(folder.path(), &args);
        assert!(String::from_utf8_lossy(&told.stderr).contains("note: the stated pose of the board does not match"));
        let design = json(&told)["designs"][0].clone();
        assert_eq!(design["stereo"]["vertical_disparity_rms_px"]["measured"].as_f64(), Some(found));
        let entry = &design["board_pose"];
        assert_eq!(entry["source"], "fitted in place of the stated one");
        assert_eq!(entry["free"].as_array().map(Vec::len), Some(6));
        // The stated pose is off by 20 mm and 3 deg, and noise moves the fitted one by less than a tenth of either.
        let off = ["off_mm", "off_deg"].map(|key| entry[key].as_f64().expect("a number"));
        assert!((off[0] - 20.0).abs() < 2.0 && (off[1] - 3.0).abs() < 0.3, "{entry}");
    }
}

/// What needs no pose.
fn poseless(judgement: &Judgement) -> [f64; 4] {
    let disparity = judgement.stereo.disparity.measured.expect("asked for").expect("there are pairs");
    let straight = judgement.pooled.straightness.measured.expect("asked for").expect("there are rows");
    [disparity.vertical_rms_px, disparity.vertical_max_px, disparity.vertical_mean_px, straight.both.rms_px]
}

/// A figure that needs no pose does not depend on the stated one, but for the order of a sum where it turns the board.
#[test]
fn what_needs_no_pose_does_not_depend_on_it() {
    let own = text(FLAT, LARGE, TRUE_POSE);
    let picture = render(&built(&own).1, &()).radiance;
    let of = |pose: &str| measured(&picture, &text(FLAT, LARGE, pose));
    let truth = of(TRUE_POSE);
    assert_eq!(truth.pose.as_ref().map(|pose| pose.source), Some(PoseSource::Stated));
    let own = poseless(&truth.judged().0);
    let far = "position_mm = [300.0, 150.0, 2000.0]\ntilt_deg = [-30.0, 40.0, 20.0]\n";
    let on_edge = "position_mm = [0.0, 0.0, 900.0]\ntilt_deg = [0.0, 90.0, 0.0]\n";
    for (pose, source) in [
        (OFF_POSE.to_owned(), PoseSource::Mismatch),
        (far.to_owned(), PoseSource::Mismatch),
        (on_edge.to_owned(), PoseSource::Mismatch),
        (format!("{far}pose = \"fit\"\n"), PoseSource::Asked),
        (format!("{TRUE_POSE}pose = \"fit\"\n"), PoseSource::Asked),
    ] {
        let photo = of(&pose);
        let found = photo.pose.expect("there are corners");
        assert_eq!(found.source, source, "{pose}");
        assert_eq!(found.matched.map(|m| m.by), Some([MatchedBy::Rays; 2]));
        let same = poseless(&of(&pose).judged().0).iter().zip(own).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(same, "{pose}");
    }
}

/// On a picture without noise the six numbers come out as they are: the detector errs by less than 0.002 px, a part in 1e5 of
/// the picture's width, and no number is known worse than by some ten times that of its reach (the tilt, by the disparities of
/// the board's ends).
#[test]
fn the_six_numbers_are_those_of_the_board() {
    for (prism, board) in [(FLAT, LARGE), (FREEFORM, SMALL)] {
        let own = text(prism, board, TRUE_POSE);
        let (truth, system) = built(&own);
        let picture = render(&system, &()).radiance;
        let near = "position_mm = [16.0, -5.0, 990.0]\ntilt_deg = [0.0, 0.0, 0.0]\npose = \"fit\"\n";
        let photo = measured(&picture, &text(prism, board, near));
        let found = photo.pose.expect("there are corners");
        let (pose, exact) = (found.world_from_board, truth.board.world_from_board);
        let off_mm = pose.translation_mm - exact.translation_mm;
        let off_deg = (pose.angles_rad() - exact.angles_rad()).to_array().map(f64::to_degrees);
        println!("off by {off_mm} mm, {off_deg:?} deg, residual {:?}", found.deviation);
        assert!(found.deviation.is_some_and(|left| left.rms < 0.002), "{found:?}");
        assert!(off_mm.truncate().length() < 0.02 && off_mm.z.abs() < 0.2, "{off_mm}");
        assert!(off_deg.into_iter().all(|deg| deg.abs() < 0.02), "{off_deg:?}");
        assert_eq!(found.other, None);
        let placed = if board == SMALL { PlacedBy::OnlyPlace } else { PlacedBy::NearestToStated };
        assert_eq!(found.placed, placed);
        // With the place of the board, every corner has its own.
        let right = photo.view.halves.iter().all(|half| {
            let camera = half.camera.expect("a pinhole");
            half.found.iter().all(|f| {
                let at = photo.view.board.corner_at(f64::from(f.index[0]), f64::from(f.index[1]));
                // The pinholes are those of a prism that bends by some px.
                camera.project(photo.view.board.world(at)).is_some_and(|px| px.distance(f.position_px) < 8.0)
            })
        });
        assert!(right, "a corner is not where its index is");
    }
}

/// A board that both halves show whole is matched by its columns and rows, whatever prism the scene has.
#[test]
fn a_whole_board_is_matched_without_the_prism() {
    let own = text(FLAT, SMALL, TRUE_POSE);
    let picture: Raster<f32> = render(&built(&own).1, &()).radiance;
    // A prism twice as far off sees a pair of twice the baseline: 1.2 squares more of disparity.
    let other = FLAT.replace("78.472", "160.0");
    let photo = measured(&picture, &text(&other, SMALL, TRUE_POSE));
    let matched = photo.pose.as_ref().expect("there are corners").matched.expect("they are matched");
    assert!(matched.is_sure() && matched.doubt > 0.3, "{matched:?}");
    let [found, exact] = disparities(&photo, &own);
    // Both are of the detector's error.
    assert!((found - exact).abs() < 2e-3, "{found} {exact}");
}

/// Corners that another program numbers otherwise, in a list that tells no colours, are matched as well.
#[test]
fn foreign_corners_are_matched_without_colours() {
    let own = text(FLAT, LARGE, TRUE_POSE);
    let (_, system) = built(&own);
    let picture = render(&system, &()).radiance;
    let mut lattices = detect(&system, &picture, &());
    lattices.iter_mut().flat_map(|half| &mut half.corners).for_each(|corner| corner.polarity = None);
    let (scene, system) = built(&text(FLAT, LARGE, OFF_POSE));
    let photo = photograph(&scene, &system, &lattices, &());
    let [found, exact] = disparities(&photo, &own);
    assert!((found - exact).abs() < 2e-3, "{found} {exact}");
}

/// Seen from afar without a prism, a board and its mirror image about the line of sight look alike: the two are told apart
/// without noise, and named where noise hides which it is.
#[test]
fn a_tilt_that_noise_hides_is_named() {
    let far = "position_mm = [0.0, 0.0, 60000.0]\ntilt_deg = [0.0, 20.0, 0.0]\npose = \"fit\"\n";
    let scene = text("[prism]\nkind = \"none\"\n", "columns = 9\nrows = 9\nsquare_mm = 40.0\n", far);
    let (scene, system) = built(&scene.replace("focal_length_mm = 35.0", "focal_length_mm = 200.0"));
    let frame = HalfFrame::new(&system, Half::Left);
    let camera = virtual_camera(&system, &frame).unwrap_or_else(|why| panic!("{why}"));
    let noise = Noise::new(5).added(&Raster::from_data(8, 16, vec![0.0; 128]), 1.0);
    for (sigma_px, told) in [(0.0, true), (0.1, false)] {
        let corner = |k: i32| {
            let (column, row) = (k % 8, k / 8);
            let at = system.board().world(system.board().corner_at(f64::from(column), f64::from(row)));
            let off = DVec2::new(f64::from(noise.data()[2 * k as usize]), f64::from(noise.data()[2 * k as usize + 1]));
            let position_px = camera.project(at).expect("it is in front") + off * sigma_px;
            LatticeCorner { index: [column, row], position_px, polarity: None, covariance_px2: None }
        };
        let corners = (0..64).map(corner).collect();
        let lattices = [DetectedLattice { corners, ..DetectedLattice::default() }, DetectedLattice::default()];
        let found = photograph(&scene, &system, &lattices, &()).pose.expect("there are corners");
        assert_eq!(found.other.is_none(), told, "{sigma_px}: {found:?}");
        let tilt_deg = |pose: Pose| pose.angles_rad().y.to_degrees();
        let tilts: Vec<f64> = [Some(found.world_from_board), found.other].into_iter().flatten().map(tilt_deg).collect();
        // A row is 42 px wide, and foreshortened by 0.25 px a deg: 0.1 px a corner, over 64 of them, are some 0.1 deg.
        assert!(tilts.iter().any(|tilt| (tilt - 20.0).abs() < if told { 1e-3 } else { 2.0 }), "{tilts:?}");
        assert!(told || tilts.iter().any(|tilt| (tilt + 20.0).abs() < 2.0), "{tilts:?}");
    }
}

/// A telecentric camera tells no distance by the size of the squares: the stated pose matches the halves, and then both fix the
/// board.
#[test]
fn a_telecentric_camera_is_matched_by_the_stated_pose() {
    let lens = "[effect.telecentric]\nmagnification = 0.55\nna = 0.01\nfocus_mm = 190.0\n";
    let board = "columns = 41\nrows = 31\nsquare_mm = 1.0\n";
    let scene = |pose: &str| text(&format!("{FLAT}facet_angle_deg = 8.0\n"), board, pose) + lens;
    let (_, system) = built(&scene("position_mm = [0.3, -0.2, 200.0]\ntilt_deg = [3.0, 2.0, 1.0]\n"));
    let aimer = Aimer::new(&system);
    let lattices = Half::BOTH.map(|half| {
        let frame = HalfFrame::new(&system, half);
        let seen = truth::corners(&system, &aimer, &frame).expect("few enough").into_iter().map(|(index, corner)| {
            let dark_main = (index[0] + index[1]) % 2 == 0;
            let polarity = Some(if dark_main { Polarity::Anti } else { Polarity::Main });
            LatticeCorner { index, position_px: corner.position_px, polarity, covariance_px2: None }
        });
        DetectedLattice { corners: seen.collect(), ..DetectedLattice::default() }
    });
    let told = "position_mm = [0.3, -0.2, 200.0]\ntilt_deg = [3.0, 2.0, 1.0]\n";
    for (pose, source) in [(told, PoseSource::Stated), ("position_mm = [0.0, 0.0, 198.0]\n", PoseSource::Mismatch)] {
        let (own, other) = built(&scene(pose));
        let photo = photograph(&own, &other, &lattices, &());
        let found = photo.pose.expect("there are corners");
        assert_eq!(found.source, source, "{found:?}");
        let matched = found.matched.expect("they are matched");
        assert_eq!((matched.shift, matched.by), (IVec2::ZERO, [MatchedBy::StatedPose; 2]));
        // Corners without error leave rounding: some 1e-13 px, over a part in 1e4 of what a number does.
        let off_mm = found.world_from_board.translation_mm - system.board().pattern.world_from_board.translation_mm;
        assert!(off_mm.length() < 1e-6, "{off_mm}");
    }
    // One half alone does not say how far the board is.
    let alone = [lattices[0].clone(), DetectedLattice::default()];
    let (own, other) = built(&scene("position_mm = [0.0, 0.0, 190.0]\ntilt_deg = [-9.0, 0.0, 0.0]\n"));
    let photo = photograph(&own, &other, &alone, &());
    let found = photo.pose.as_ref().expect("there are corners");
    assert!(matches!(found.source, PoseSource::Unknown(_)) && found.deviation.is_none(), "{found:?}");
    let (judgement, _) = photo.judged();
    assert_eq!(judgement.depths_mm, None);
    assert!(judgement.halves[0].straightness.measured.is_some_and(|rows| rows.is_ok()));
}
