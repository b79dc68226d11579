//! Does a camera with its own principal point, rotation and distortion see what its model says?

use crate::instruments::{BOARD, FLAT, NO_GLASS, built, scene, scene_from};
use biprism::analysis::judge::judge;
use biprism::analysis::view::HalfView;
use biprism::geom::{CalibratedPinhole, Distortion, Pose};
use biprism::scene::{self, Scene};
use biprism::system::aim::Aimer;
use biprism::system::{self, System};
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use std::path::Path;

/// Principal point, rotation and distortion at once, on a sensor of 320 x 180 px.
const ALL: &str = "principal_point_px = [163.5, 87.25]\nrotation_deg = [0.4, -0.6, 1.5]\n\
                   distortion = [-0.9, 1.5, 0.004, -0.003, 0.0]";
const WIDTH: usize = 320;
const HEIGHT: usize = 180;

fn system_of(camera: &str, prism: &str, board: &str) -> System {
    built(&scene_from(WIDTH, HEIGHT, camera, prism, board))
}

/// Places all over the picture.
fn places(count: usize) -> impl Iterator<Item = DVec2> {
    let share = |k: usize, alpha: f64| (0.5 + alpha * (k + 1) as f64).fract();
    let size = DVec2::new(WIDTH as f64, HEIGHT as f64);
    (0..count).map(move |k| size * DVec2::new(share(k, 0.754_877_666), share(k, 0.569_840_290)))
}

/// Cameras of 1920 x 1080 px whose pictures do not fold, from long lenses to wide ones, barrels and pincushions.
fn cameras() -> impl Strategy<Value = (CalibratedPinhole, DVec2)> {
    let radial = (-1.2..1.2f64, -1.0..1.5f64, -0.5..1.0f64);
    let tangential = (-0.03..0.03f64, -0.03..0.03f64);
    let intrinsics = (500.0..6000.0f64, 0.98..1.02f64, 800.0..1120.0f64, 440.0..640.0f64);
    let turn = (-40.0..40.0f64, -40.0..40.0f64, -180.0..180.0f64);
    (radial, tangential, intrinsics, turn).prop_filter_map("the picture folds", |((k1, k2, k3), (p1, p2), i, turn)| {
        let (fx, ratio, cx, cy) = i;
        let angles = DVec3::new(turn.0, turn.1, turn.2) * (std::f64::consts::PI / 180.0);
        let pinhole = CalibratedPinhole {
            tangent_per_px: DVec2::new(1.0 / fx, 1.0 / (fx * ratio)),
            distortion: Distortion::new([k1, k2, p1, p2, k3]),
            rotation: Pose::new(DVec3::ZERO, angles).rotation,
            lean: DVec2::ZERO,
        };
        let principal = DVec2::new(cx, cy);
        let folds = pinhole.fold_px(-principal, DVec2::new(1920.0, 1080.0) - principal);
        folds.is_none().then_some((pinhole, principal))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// The inverse of the distortion is exact, of several directions the one on the branch of the centre.
    #[test]
    fn a_place_and_its_direction_belong_together(
        (pinhole, principal) in cameras(),
        shares in prop::collection::vec((0.0..=1.0f64, 0.0..=1.0f64), 32),
    ) {
        for (x, y) in shares.into_iter().chain([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]) {
            let place = DVec2::new(1920.0 * x, 1080.0 * y) - principal;
            let seen = place * pinhole.tangent_per_px;
            let u = pinhole.distortion.undistort(seen);
            let off_px = ((pinhole.distortion.distort(u) - seen) / pinhole.tangent_per_px).length();
            // The terms of the formula round to 4.5 units in the last place of their sizes: 1e-12 px at 1000 px where they do
            // not cancel.
            let sizes = Distortion::new(pinhole.distortion.coefficients().map(f64::abs)).distort(u.abs());
            let bound_px = 4.5 * f64::EPSILON * (sizes / pinhole.tangent_per_px).length();
            prop_assert!(off_px < bound_px, "{place}: {off_px:e} px");

            // By the turned unit direction, of some ten more roundings, each as the slope magnifies it.
            let back = pinhole.project(pinhole.direction(place)).expect("it is before the camera");
            let slope = pinhole.distortion.jacobian(u);
            let stretch = slope.x_axis.length().max(slope.y_axis.length()) * (1.0 + u.length()) / pinhole.tangent_per_px.y;
            prop_assert!((back - place).length() < 10.0 * f64::EPSILON * stretch, "{place}: {back}");

            // A direction on the way to it is found again: its own root, no other.
            let on_the_way = u * 0.7;
            let again = pinhole.distortion.undistort(pinhole.distortion.distort(on_the_way));
            prop_assert!((again - on_the_way).length() < 1e-9, "{on_the_way}: {again}");
        }
    }

    #[test]
    fn differentials_are_the_slope_of_the_direction((pinhole, principal) in cameras(), x in 0.0..1.0f64, y in 0.0..1.0f64) {
        let place = DVec2::new(1920.0 * x, 1080.0 * y) - principal;
        let step = 1e-2;
        for (axis, found) in [DVec2::X, DVec2::Y].into_iter().zip(pinhole.differentials(place)) {
            let slope = (pinhole.direction(place + axis * step) - pinhole.direction(place - axis * step)) / (2.0 * step);
            // Near a fold the slope itself changes fast: third differences of the same step bound what is left out.
            let third = [2.0, 1.0, -1.0, -2.0].map(|k| pinhole.direction(place + axis * (k * step)));
            let left_out = (third[0] - 2.0 * third[1] + 2.0 * third[2] - third[3]).length() / (6.0 * step);
            prop_assert!((slope - found).length() < 2.0 * left_out + 16.0 * f64::EPSILON / step, "{slope} {found}");
        }
    }
}

/// Camera, prism and board turned alike about the pinhole: the same picture.
#[test]
fn a_rotation_of_everything_changes_nothing() {
    let board_mm = DVec3::new(12.0, -7.0, 1000.0);
    let board = |at: DVec3, tilt: &str| {
        format!("columns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [{:?}, {:?}, {:?}]\n{tilt}", at.x, at.y, at.z)
    };
    let own = "principal_point_px = [150.0, 99.5]\ndistortion = [0.7, -0.2, 0.01, 0.02, 0.1]";
    let still = system_of(own, FLAT, &board(board_mm, ""));
    for angles in [[4.0, 0.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, 70.0], [3.0, 5.0, -160.0]] {
        let turn = Pose::new(DVec3::ZERO, DVec3::from_array(angles.map(f64::to_radians)));
        let tilt = format!("tilt_deg = {angles:?}");
        let turned = system_of(
            &format!("{own}\nrotation_deg = {angles:?}"),
            &format!("{FLAT}\n{tilt}"),
            &board(turn.point(board_mm), &tilt),
        );
        for px in places(100) {
            let (a, b) = (still.footprint(px).expect("in view"), turned.footprint(px).expect("in view"));
            assert_eq!(a.sight.side, b.sight.side, "{px}");
            // Roundings of positions of 1000 mm.
            assert!((a.sight.board_mm - b.sight.board_mm).length() < 2e-11, "{angles:?} {px}");
            assert!((a.jacobian - b.jacobian).abs_diff_eq(glam::DMat2::ZERO, 1e-12), "{angles:?} {px}");
        }
    }
}

/// The middle as principal point, no angle and zeros are no camera of their own, bit for bit.
#[test]
fn nothing_is_the_plain_pinhole() {
    let nothing = format!(
        "principal_point_px = [{:?}, {:?}]\nrotation_deg = [0, 0, 0]\ndistortion = [0, 0, 0, 0, 0]",
        0.5 * WIDTH as f64,
        0.5 * HEIGHT as f64
    );
    for prism in [FLAT, NO_GLASS] {
        let (plain, own) = (built(&scene(WIDTH, HEIGHT, prism, BOARD)), system_of(&nothing, prism, BOARD));
        assert_eq!(plain.camera(), own.camera());
        assert!(own.is_mirror_symmetric() && own.camera().is_plain());
    }
    // By its own rays, which have a path of their own: the same to rounding.
    let almost = system_of("principal_point_px = [160.00000000001, 90.0]", FLAT, BOARD);
    assert!(!almost.camera().is_plain() && !almost.is_mirror_symmetric());
    let plain = built(&scene(WIDTH, HEIGHT, FLAT, BOARD));
    for px in places(100).filter(|px| (px.x - 160.0).abs() > 1e-6) {
        let (a, b) = (plain.trace(px).expect("in view"), almost.trace(px).expect("in view"));
        assert!(a.side == b.side && (a.board_mm - b.board_mm).length() < 1e-10, "{px}");
    }
}

/// The inverse trace through lens and prism.
#[test]
fn aiming_undoes_looking() {
    for prism in [FLAT, NO_GLASS] {
        let system = system_of(ALL, prism, BOARD);
        let aimer = Aimer::new(&system);
        let mut seen = 0;
        for px in places(200) {
            let Ok(sight) = system.trace(px) else { continue };
            let back = aimer.aim(sight.board_mm, sight.side).expect("found");
            // 0.9 mm/px on the board; positions of 200 mm round to 3e-14 mm, some of them on the way.
            assert!((back - px).length() < 4e-12 && aimer.sees(px, sight.side), "{px} {back}");
            seen += 1;
        }
        assert!(seen > 190, "only {seen} rays reach the board");
    }
}

/// Without glass the halves are those of the picture, wherever the principal point is.
#[test]
fn halves_meet_in_the_middle_of_the_picture() {
    let system = system_of(ALL, NO_GLASS, BOARD);
    for y in [0.25, 60.0, 90.5, 179.5] {
        for x in [159.999_999, 160.0, 160.000_001] {
            let side = system.trace(DVec2::new(x, y)).expect("in view").side;
            assert_eq!(side == system::Side::Right, x >= 160.0, "({x}, {y})");
        }
    }
}

/// A stop is about the axis of the lens: a circle about the principal point, as the lens bends it.
#[test]
fn a_stop_turns_with_the_camera() {
    let camera = "principal_point_px = [170.0, 80.0]\nrotation_deg = [0.0, 6.0, 0.0]\n\n[effect.clipping]\n\
                  stop = { at_mm = 50.0, diameter_mm = 10.0 }\n";
    let system = system_of(camera, NO_GLASS, BOARD);
    // 5 mm at 50 mm: a tangent of 0.1, of 35 mm / 33 um px.
    let radius_px = 0.1 * 35.0 / 0.033;
    for k in 0..64 {
        let (sin, cos) = libm::sincos(0.1 * f64::from(k));
        let at = |r: f64| DVec2::new(170.0, 80.0) + r * DVec2::new(cos, sin);
        assert!(system.trace(at(radius_px - 1e-9)).is_ok() && system.trace(at(radius_px + 1e-9)).is_err(), "{k}");
    }
}

/// Every point of the aperture sees the same point of the plane in focus, which is across the axis of the lens.
#[test]
fn a_thin_lens_keeps_its_plane_in_focus() {
    let camera = format!("{ALL}\n\n[effect.thin_lens]\nf_number = 1.4\nfocus_mm = 400.0\n");
    let system = system_of(&camera, NO_GLASS, BOARD);
    let lens = system.effects().lens.thin().copied().expect("it has one");
    let axis = Pose::new(DVec3::ZERO, DVec3::new(0.4, -0.6, 1.5) * (std::f64::consts::PI / 180.0)).rotation.z_axis;
    for px in places(50) {
        let in_focus = |pupil: DVec2| {
            let ray = system.camera().through(&lens, pupil).ray(px);
            ray.at((400.0 - ray.origin.dot(axis)) / ray.direction.dot(axis))
        };
        for pupil in [DVec2::new(10.0, 0.0), DVec2::new(-3.0, 8.0)] {
            // Roundings of positions of 400 mm.
            assert!((in_focus(pupil) - in_focus(DVec2::ZERO)).length() < 1e-12, "{px} {pupil}");
        }
    }
}

/// No lens is blamed on a prism: what a half is held against is where the lens shows the designed pinhole.
#[test]
fn a_lens_is_not_blamed_on_the_prism() {
    let board = "columns = 15\nrows = 15\nsquare_mm = 25.0\nposition_mm = [3.0, 4.0, 1000.0]\ntilt_deg = [10, -15, 3]";
    let of = |camera: &str, prism: &str| {
        let scene = Scene {
            analysis: scene::Analysis { depths_mm: vec![900.0, 1100.0], grid: 9 },
            ..scene_from(WIDTH, HEIGHT, camera, prism, board)
        };
        judge(&scene, &built(&scene), &()).1
    };
    // Without glass each half is a pinhole, to the roundings of 1000 px on the way.
    let found = of(ALL, NO_GLASS);
    let exact = found.pooled.designed.exact.expect("it is known").expect("it is measurable");
    assert!(exact.px.max < 1e-9, "{:e}", exact.px.max);
    assert!(exact.px.n > 100);
    let worst = |half: &HalfView| {
        let truth = half.truth.as_ref().expect("it is known");
        assert!(truth.len() > 20, "{} corners", truth.len());
        let off = |(&[column, row], corner): (&[i32; 2], &biprism::analysis::truth::TrueCorner)| {
            let at = found.view.board.world(found.view.board.corner_at(f64::from(column), f64::from(row)));
            half.ideal_px(at).expect("it is seen").distance(corner.position_px)
        };
        truth.iter().map(off).fold(0.0, f64::max)
    };
    assert!(found.view.halves.iter().map(worst).fold(0.0, f64::max) < 1e-9);

    // Behind a prism the figures are those of the plain pinhole, but for the other grid of rays.
    let rms =
        |camera: &str| of(camera, FLAT).pooled.designed.exact.expect("it is known").expect("it is measurable").px.rms;
    let (plain, own) = (rms(""), rms(ALL));
    assert!((own / plain - 1.0).abs() < 0.15, "{own} {plain}");
}

/// The places at which `cv2.projectPoints` sees points of a board, in pictures of four cameras, one of them read from a file of
/// `cv2.FileStorage`.
#[test]
fn pictures_are_those_of_opencv() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/oracle"));
    let camera = |name: &str| match name {
        // fx = 600, and cx, cy the middle.
        "barrel" => "focal_length_mm = 6.0\ndistortion = [-0.28, 0.07, 0, 0, 0]",
        "all" => {
            "focal_length_mm = 5.5\nprincipal_point_px = [331.75, 229.25]\nrotation_deg = [2.0, -3.5, 1.25]\n\
             distortion = [-0.31, 0.12, 0.0011, -0.0023, -0.02]"
        }
        "file" => "calibration = \"camera.yml\"",
        "pincushion" => {
            "focal_length_mm = 4.8\nprincipal_point_px = [300.5, 260.5]\nrotation_deg = [-1.0, 4.0, -90.0]\n\
             distortion = [0.6, 0.4, 0.01, -0.02, 0.1]"
        }
        other => panic!("no camera is called {other}"),
    };
    let system = |name: &str| {
        let text = format!(
            "name = \"oracle\"\n[camera]\nwidth_px = 640\nheight_px = 480\npixel_pitch_um = 10\n{}\n[prism]\nkind = \"none\"\n\
             [board]\ncolumns = 101\nrows = 101\nsquare_mm = 20.0\nposition_mm = [0, 0, 1000]\n",
            camera(name)
        );
        built(&scene::parse(&text, "oracle", Some(folder)).unwrap_or_else(|problem| panic!("{problem}")))
    };
    let text = std::fs::read_to_string(folder.join("camera.csv")).expect("the table is committed");
    let rows: Vec<Vec<&str>> =
        text.lines().filter(|line| !line.starts_with('#')).skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 160);
    for row in rows {
        let system = system(row[0]);
        let [u, v, x, y] = [1, 2, 3, 4].map(|k| row[k].parse::<f64>().expect("a number"));
        let (board_mm, px) = (DVec2::new(u, v), DVec2::new(x, y));
        let seen = system.trace(px).expect("it is seen").board_mm;
        // Some 20 roundings of px of 600, at up to 3 mm a px on the board, on either side.
        assert!((seen - board_mm).length() < 40.0 * 600.0 * f64::EPSILON * 3.0, "{row:?}: {seen}");
        let aimer = Aimer::new(&system);
        let side = system.trace(px).expect("it is seen").side;
        assert!((aimer.aim(board_mm, side).expect("found") - px).length() < 1e-11, "{row:?}");
    }
}

/// A rotation by what `tilt_deg` turns prism and board by.
#[test]
fn the_axis_is_where_the_angles_turn_it() {
    let system = system_of("rotation_deg = [0.0, 5.0, 0.0]", NO_GLASS, BOARD);
    let ray = system.camera().ray(DVec2::new(160.0, 90.0));
    let (sin, cos) = libm::sincos(5f64.to_radians());
    // About y, z goes to x.
    assert!((ray.direction - DVec3::new(sin, 0.0, cos)).length() < 1e-15);
    let seen = system.trace(DVec2::new(160.0, 90.0)).expect("in view").board_mm;
    assert!((seen - DVec2::new(1000.0 * sin / cos, 0.0)).length() < 1e-12);
}
