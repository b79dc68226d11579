//! Do the numbers that a user reads mean what their names say?
//!
//! Between a right result and a report lie pooling, labels, signs, planes and units. Each is held here against a closed
//! form or another way to the same number.

use crate::command::{biprism, json, repository, small_scene, with_input};
use crate::instruments::{BOARD, FLAT, FREEFORM, NO_GLASS, built, scene};
use biprism::accuracy::Level;
use biprism::analysis::board_indexing::anchor;
use biprism::analysis::half_image::{HalfFrame, virtual_camera};
use biprism::io::exr::{ChannelSamples, read_channels};
use biprism::render::{Outputs, render, render_wanted};
use biprism::scene;
use biprism::system::InLight;
use biprism::vision::LatticeCorner;
use biprism::vision::half::Half;
use glam::DVec2;
use serde_json::Value;
use std::sync::OnceLock;
use std::time::Instant;

/// The small scene with a flat prism that stands aside and is rolled: its halves are alike in nothing.
const ROLL_DEG: f64 = 0.2;

fn aside(text: String) -> String {
    let placed = format!("kind = \"flat\"\nposition_mm = [1.5, 0.3, 0.0]\ntilt_deg = [0.0, 0.0, {ROLL_DEG}]");
    text.replace("kind = \"freeform\"", &placed).replace("[prism.design]\norder = \"x-then-y\"\ndegree = 5\n", "")
}

/// The judgement of the scene's own picture, by the command.
fn judged() -> &'static Value {
    static JUDGED: OnceLock<Value> = OnceLock::new();
    JUDGED.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        small_scene(folder.path(), aside);
        assert!(biprism(folder.path(), &["render", "scene.toml", "--out", "a.exr"]).status.success());
        let report = json(&biprism(
            folder.path(),
            &["measure", "a.exr", "--scene", "scene.toml", "--own", "--budget", "--json"],
        ));
        report["designs"][0].clone()
    })
}

/// A figure of both halves is made of those of each as its normaliser says, whatever their counts.
#[test]
fn figures_of_both_halves_are_those_of_each_together() {
    let design = judged();
    let [left, right] = ["left", "right"].map(|half| &design["halves"][half]["pinhole"]);
    let mut seen = 0;
    pooled(&design["pinhole"], left, right, "pinhole", &mut seen);
    assert!(seen > 20, "{seen}");
    // The detector's own figures: counts add up, errors are weighed by them.
    let [whole, left, right] =
        [&design["corners"], &design["halves"]["left"]["corners"], &design["halves"]["right"]["corners"]];
    let number = |side: &Value, key: &str| side[key].as_f64().expect(key);
    for key in ["visible", "found", "partial", "false"] {
        assert_eq!(number(whole, key), number(left, key) + number(right, key), "{key}");
    }
    assert_eq!(number(whole, "max_error_px"), number(left, "max_error_px").max(number(right, "max_error_px")));
    let [n_left, n_right] = [left, right].map(|half| number(half, "found") + number(half, "partial"));
    let square = |side: &Value| number(side, "rms_error_px") * number(side, "rms_error_px");
    let expected = (n_left * square(left) + n_right * square(right)) / (n_left + n_right);
    assert!(n_left != n_right && (square(whole) / expected - 1.0).abs() < 1e-12, "{n_left} {n_right}");
}

/// Holds every figure below `whole` against those of the halves; counts the values.
fn pooled(whole: &Value, left: &Value, right: &Value, place: &str, seen: &mut usize) {
    if let Some(normaliser) = whole.get("normaliser").and_then(Value::as_str) {
        for (side, count) in [("measured", "n"), ("true", "n_true")] {
            let [Some(w), Some(a), Some(b)] = [whole, left, right].map(|figure| figure[side].as_f64()) else {
                continue;
            };
            let [n, n_a, n_b] = [whole, left, right].map(|figure| figure[count].as_f64().expect("a count"));
            let mean = |a: f64, b: f64| (n_a * a + n_b * b) / (n_a + n_b);
            let expected = match normaliser {
                "sqrt(sum |e|^2 / N)" => mean(a * a, b * b).sqrt(),
                "sum |e| / N" | "sum e / N" => mean(a, b),
                "max |e|" | "fit to N" => a.max(b),
                other => panic!("{place}: {other}"),
            };
            assert_eq!(n, n_a + n_b, "{place} {count}");
            assert!(
                (w - expected).abs() <= 1e-12 * expected.abs(),
                "{place} {side}: {w}, and {a}, {b} make {expected}"
            );
            *seen += 1;
        }
    } else if let Some(map) = whole.as_object() {
        for (key, value) in map {
            pooled(value, &left[key], &right[key], &format!("{place}/{key}"), seen);
        }
    } else if let Some(list) = whole.as_array() {
        for (k, value) in list.iter().enumerate() {
            pooled(value, &left[k], &right[k], &format!("{place}/{k}"), seen);
        }
    }
}

/// A roll r of the prism turns the bend of each facet with it: the left half's view goes down by sin(r) times the bend, and
/// what it sees comes up by that; the right half's the other way. The bend is the tangent of the half's middle ray, and
/// acts over the way from the glass to the board.
#[test]
fn left_less_right_has_the_sign_of_the_closed_form() {
    let figure = &judged()["stereo"]["vertical_disparity_mean_px"];
    let bend = 0.25 * 10.56 / 35.0;
    let away = (1000.0 - 78.472 - 8.545) / 1000.0;
    let expected = -2.0 * libm::sin(ROLL_DEG.to_radians()) * bend * (35.0 / 0.022) * away;
    for side in ["measured", "true"] {
        let found = figure[side].as_f64().expect("a number");
        // The facets bend by a few per cent more or less towards the rims.
        assert!((found / expected - 1.0).abs() < 0.1, "{side}: {found}, by the closed form {expected}");
    }
}

/// The steps of the budget by their names: a detector on every pixel traced errs by less than 1e-3 px, the level of the
/// picture adds less than its promise, and the corners' own errors are the detector's and the level's together.
#[test]
fn the_steps_of_the_budget_have_their_own_names() {
    let design = judged();
    let budget = &design["error_budget"];
    let rms = |step: &str| budget[step]["rms_px"].as_f64().expect("a number");
    assert!(rms("sampling") < 1e-5 && rms("detector") > 3.0 * rms("sampling"), "{budget}");
    assert!((rms("detector") / design["corners"]["rms_error_px"].as_f64().expect("a number") - 1.0).abs() < 0.1);
    // The flat prism is far from a pinhole, and is not designed from points.
    assert!(rms("optics") > 1.0 && budget.get("fit").is_none() && budget.get("effects").is_none());
}

/// The row of Table 1 of the design paper that `compare` prints: of the plane at -f, with H and V in their places, for both
/// prisms. The grid of rays does not depend on the pixels.
#[test]
fn the_command_prints_the_rows_of_table_1() {
    let folder = tempfile::tempdir().expect("a folder");
    let one_depth = |text: String| text.replace("depths_mm = [500.0, 700.0, 1000.0]", "depths_mm = [1000.0]");
    small_scene(folder.path(), one_depth);
    let report = json(&biprism(folder.path(), &["compare", "scene.toml", "--json"]));
    let row = |design: usize, key: &str| {
        let value = &report["designs"][design]["halves"]["right"]["pinhole"]["designed"][key]["true"];
        value.as_f64().expect("a number")
    };
    assert_eq!(["mean_abs_h_mm", "mean_abs_v_mm"].map(|key| format!("{:.4}", row(0, key))), ["0.0604", "0.0936"]);
    // The paper's 0.0154 and 0.0011: reached, and of the order of these.
    let [h, v] = ["mean_abs_h_mm", "mean_abs_v_mm"].map(|key| row(1, key));
    assert!((1e-3..=0.0154).contains(&h) && (1e-4..=0.0011).contains(&v), "{h} {v}");
    for (key, mm) in [("mean_abs_h_px", h), ("mean_abs_v_px", v)] {
        assert!((row(1, key) * 0.022 / mm - 1.0).abs() < 1e-12, "{key}");
    }
}

/// The truth in an EXR is what the command traces through each pixel's centre.
#[test]
fn truth_layers_are_those_of_pixel_centres() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), aside);
    assert!(biprism(folder.path(), &["render", "scene.toml", "--stereo", "--out", "a.exr"]).status.success());
    let names = ["board.U", "board.V", "P.X", "P.Y", "P.Z", "class"];
    let layers = read_channels(&folder.path().join("a.exr"), &names).unwrap_or_else(|p| panic!("{p}"));
    let pixels: Vec<[usize; 2]> = (0..60).map(|k| [(k * 97) % 480, (k * 71) % 270]).collect();
    let points: String = pixels.iter().map(|[i, j]| format!("{}.5,{}.5\n", i, j)).collect();
    let traced = json(&with_input(folder.path(), &["trace", "scene.toml", "--json"], &points));
    for (k, &[i, j]) in pixels.iter().enumerate() {
        let ray = &traced[k];
        let expected =
            [&ray["board_mm"][0], &ray["board_mm"][1], &ray["world_mm"][0], &ray["world_mm"][1], &ray["world_mm"][2]];
        for (layer, expected) in layers.iter().zip(expected) {
            let ChannelSamples::F32(values) = &layer.samples else { panic!("{} is no number", layer.name) };
            let expected = expected.as_f64().unwrap_or_else(|| panic!("{ray}"));
            // A map within 1e-8 px of its rays, and f32: half a pixel is 0.3 mm.
            let found = f64::from(values.get(i, j));
            assert!(
                (found - expected).abs() < 1e-6 * expected.abs().max(100.0),
                "{} ({i}, {j}): {found} {expected}",
                layer.name
            );
        }
        let ChannelSamples::U32(classes) = &layers[5].samples else { panic!("a class is a whole number") };
        assert_eq!(ray["side"], ["left", "right"][classes.get(i, j) as usize], "({i}, {j})");
    }
}

/// What a picture says it kept to is what it keeps to: its lines are off by no more, and not by far less.
#[test]
fn what_is_achieved_is_the_shift_from_the_reference() {
    for prism in [FLAT, FREEFORM] {
        // Large pixels and small squares: the bend inside a pixel is what errs.
        let scene = scene(96, 54, prism, BOARD);
        let contrast = scene.board.white - scene.board.black;
        let at = |level: Level| render(&built(&scene).with_accuracy(level.accuracy()), &());
        let reference = at(Level::Reference);
        let film = at(Level::Draft);
        let pairs = film.radiance.data().iter().zip(reference.radiance.data());
        let most = pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
        // A line that moves by 1 px changes a pixel by the contrast at least, and by sqrt(2) of it at most.
        let shift_px = [most / (contrast * 2f64.sqrt()), most / contrast];
        let told = film.account.achieved_px();
        println!("{prism}: achieved {told:.1e}, found {shift_px:?}");
        assert!(told >= shift_px[0] && told < 30.0 * shift_px[1], "{told:e} {shift_px:?}: {}", film.account);
    }
}

/// The entry of a report is the account of the picture.
#[test]
fn the_report_tells_the_account_of_the_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = small_scene(folder.path(), |text| format!("accuracy = \"draft\"\n{}", aside(text)));
    let told = json(&biprism(folder.path(), &["render", "scene.toml", "--out", "a.png", "--json"]));
    let scene = scene::load(&path).unwrap_or_else(|problem| panic!("{problem}"));
    let account = render_wanted(&built(&scene), Outputs { truth: false }, &()).account;
    assert!(account.bend_px > 1e-6, "{account}");
    for (key, value) in [("achieved_px", account.map_px + account.bend_px), ("promise_px", account.promise_px)] {
        assert_eq!(told["accuracy"][key].as_f64(), Some(value), "{key}");
    }
}

/// Corners whose places on the board are in doubt have none: the lattice of a board that stands aside by less than
/// 0.3 of a square is taken for the board's own, and one that could as well be its neighbour's is refused.
#[test]
fn a_doubtful_index_is_refused() {
    let system = built(&scene(640, 360, NO_GLASS, BOARD));
    let frame = HalfFrame::new(&system, Half::Left);
    let camera = virtual_camera(&system, &frame).unwrap_or_else(|why| panic!("{why}"));
    let placed = |aside: DVec2| {
        let corner = |column: i32, row: i32| {
            let at = system.board().corner_at(f64::from(column), f64::from(row)) + aside * 10.0;
            let px = camera.project(system.board().world(at)).expect("it is before the camera");
            LatticeCorner { index: [column - 9, row - 4], position_px: px, polarity: None, covariance_px2: None }
        };
        let all = (0..40).flat_map(|column| (0..40).map(move |row| corner(column, row)));
        let seen: Vec<LatticeCorner> = all.filter(|c| frame.contains(c.position_px)).collect();
        assert!(seen.len() > 50, "{}", seen.len());
        anchor(&InLight::new(&system), &frame, &seen)
            .map(|found| found.iter().zip(&seen).all(|(f, c)| f.index == [c.index[0] + 9, c.index[1] + 4]))
    };
    for sure in [DVec2::ZERO, DVec2::new(0.29, 0.0), DVec2::new(-0.2, 0.29)] {
        assert_eq!(placed(sure), Some(true), "{sure}");
    }
    for doubtful in [DVec2::new(0.31, 0.0), DVec2::new(0.0, -0.4), DVec2::new(0.5, 0.0), DVec2::new(0.1, 0.5)] {
        assert_eq!(placed(doubtful), None, "{doubtful}");
    }
}

/// The time that `check` tells is that of the picture. A machine that does other things stretches either: one fair pair of
/// ten is asked for, and a forecast that is off by ten has none.
#[test]
fn the_forecast_of_time_is_the_time() {
    let folder = tempfile::tempdir().expect("a folder");
    // Below 100 000 pixels the picture itself is timed, and the reference takes long enough to be.
    let path = small_scene(folder.path(), |text| {
        let text = aside(text).replace("width_px = 480", "width_px = 120").replace("height_px = 270", "height_px = 68");
        format!("accuracy = \"reference\"\n{}", text.replace("pixel_pitch_um = 22.0", "pixel_pitch_um = 88.0"))
    });
    let system = built(&scene::load(&path).unwrap_or_else(|problem| panic!("{problem}")));
    let pair = || {
        let plan = json(&biprism(folder.path(), &["check", "scene.toml", "--json"]));
        let start = Instant::now();
        std::hint::black_box(render(&system, &()));
        (plan["plan"]["time_s"].as_f64().expect("a time"), start.elapsed().as_secs_f64())
    };
    let fair = |(told, took): &(f64, f64)| (0.33..3.0).contains(&(told / took));
    let pairs: Vec<(f64, f64)> = (0..10)
        .map(|_| pair())
        .scan(false, |done, pair| (!std::mem::replace(done, fair(&pair))).then_some(pair))
        .collect();
    assert!(pairs.iter().any(fair), "told and took, in s: {pairs:?}");
}

/// The virtual cameras that `check` tells are on their own sides, half a baseline from the axis each.
#[test]
fn the_virtual_cameras_stand_on_their_own_sides() {
    let paper = repository("scenes/paper.toml");
    let told = json(&biprism(&repository("scenes"), &["check", &paper.display().to_string(), "--json"]));
    let at = |half: &str| told["halves"][half]["virtual_camera_mm"][0].as_f64().expect("a number");
    // tan(delta) D / (1 - tan(delta) tan(alpha)): see the paper's tests.
    let tan_delta = 0.25 * 10.56 / 35.0;
    let half_baseline = tan_delta * 78.472 / (1.0 - tan_delta * libm::tan(8.85428f64.to_radians()));
    assert!((at("right") - half_baseline).abs() < 1e-4 && (at("left") + half_baseline).abs() < 1e-4, "{told}");
}
