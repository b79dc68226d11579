//! Do the commands do what they say: exit codes, messages, files?

use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn biprism(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_biprism")).current_dir(folder).args(args).output().expect("it runs")
}

fn with_input(folder: &Path, args: &[&str], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_biprism"))
        .current_dir(folder)
        .args(args)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it runs");
    child.stdin.take().expect("a pipe").write_all(input.as_bytes()).expect("written");
    child.wait_with_output().expect("it ends")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON on stdout and nothing else")
}

/// The paper's scene on a sensor of 480 x 270 px, in a file of `folder`.
fn small_scene(folder: &Path, change: impl Fn(String) -> String) -> PathBuf {
    let paper = fs::read_to_string(repository("scenes/paper.toml")).expect("the scene is there");
    let small = paper
        .replace("width_px = 1920", "width_px = 480")
        .replace("height_px = 1080", "height_px = 270")
        .replace("pixel_pitch_um = 5.5", "pixel_pitch_um = 22.0")
        .replace("depths_mm = [500.0, 1000.0, 2000.0]", "depths_mm = [500.0, 700.0, 1000.0]");
    let path = folder.join("scene.toml");
    fs::write(&path, change(small)).expect("written");
    path
}

fn as_is(text: String) -> String {
    text
}

#[test]
fn compare_writes_the_same_bytes_for_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let mut first: Option<Vec<(String, Vec<u8>)>> = None;
    for threads in ["1", "2", "8"] {
        let out = Command::new(env!("CARGO_BIN_EXE_biprism"))
            .current_dir(folder.path())
            .env("RAYON_NUM_THREADS", threads)
            .args(["compare", "scene.toml", "--budget", "--out", threads])
            .output()
            .expect("it runs");
        assert!(out.status.success(), "{}", text(&out.stderr));
        assert!(!text(&out.stderr).contains(['\r', '\u{1b}', '█']), "no progress bar in a pipe");
        let read = |name: &str| {
            let bytes = fs::read(folder.path().join(threads).join(name)).expect("written");
            if name != "report.json" {
                return (name.to_owned(), bytes);
            }
            let mut report: Value = serde_json::from_slice(&bytes).expect("JSON");
            for design in report["designs"].as_array_mut().expect("designs") {
                // The clock alone may differ.
                design["timing_s"] = Value::Null;
            }
            (name.to_owned(), report.to_string().into_bytes())
        };
        let pictures = ["flat.png", "freeform.png", "flat.exr", "freeform.exr", "comparison.png", "budget.png"];
        let files: Vec<_> = pictures.into_iter().chain(["report.json"]).map(read).collect();
        match &first {
            None => first = Some(files),
            Some(first) => {
                for (a, b) in first.iter().zip(&files) {
                    assert!(a == b, "{} differs with {threads} threads", a.0);
                }
            }
        }
    }
}

#[test]
fn compare_reports_every_corner_and_the_better_prism() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let report = json(&biprism(folder.path(), &["compare", "scene.toml", "--json"]));
    let written: Value =
        serde_json::from_slice(&fs::read(folder.path().join("out/report.json")).expect("written")).expect("JSON");
    assert_eq!(report, written);
    assert_eq!(report["schema"], "biprism-report/1");
    for design in report["designs"].as_array().expect("designs") {
        let corners = &design["corners"];
        assert!(corners["visible"].as_u64().is_some_and(|n| n > 300), "{corners}");
        assert_eq!(corners["visible"], corners["found"]);
        assert_eq!(corners["false"], 0);
        // The bound of the main job; squares are 16 px here and 64 px in the paper's scene.
        assert!(corners["rms_error_px"].as_f64().is_some_and(|e| e <= 0.01), "{corners}");
    }
    let disparity = |k: usize| report["designs"][k]["stereo"]["vertical_disparity_rms_px"]["measured"].as_f64();
    assert!(disparity(0) > disparity(1), "flat {:?}, freeform {:?}", disparity(0), disparity(1));
}

/// The truth of one instrument is not that of another, whatever the scenes are called.
#[test]
fn a_picture_is_measured_as_its_own_by_its_own_instrument_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    assert!(biprism(folder.path(), &["render", "scene.toml", "--out", "a.png"]).status.success());
    let own = ["measure", "a.png", "--scene", "scene.toml", "--own"];
    let told = biprism(folder.path(), &own);
    assert!(told.status.success(), "{}", text(&told.stderr));
    // One picture has one depth, and the table says so once.
    assert_eq!(text(&told.stdout).matches("too few depths of the board: 1").count(), 1, "{}", text(&told.stdout));
    for (part, from, to) in [
        ("camera", "focal_length_mm = 35.0", "focal_length_mm = 35.001"),
        ("prism", "index = 1.48", "index = 1.4801"),
        ("board", "position_mm = [0.0, 0.0, 1000.0]", "position_mm = [0.1, 0.0, 1000.0]"),
        ("effects", "[board]", "[effect.manufacture.back]\ntilt_deg = [0.1, 0.0, 0.0]\n[board]"),
    ] {
        small_scene(folder.path(), |scene| scene.replace(from, to));
        let refused = biprism(folder.path(), &own);
        let told = text(&refused.stderr);
        assert!(refused.status.code() == Some(2) && told.contains(&format!("has another {part}")), "{part}: {told}");
        let noted = biprism(folder.path(), &own[..4]);
        assert!(noted.status.success() && text(&noted.stderr).contains(&format!("has another {part}")), "{part}");
    }
    // Another level of accuracy and another name do not change the truth.
    small_scene(folder.path(), |scene| {
        format!("accuracy = \"draft\"\n{}", scene.replace("name =", "name = \"new\" #"))
    });
    assert!(biprism(folder.path(), &own).status.success());
}

#[test]
fn a_budget_splits_the_error_of_every_corner() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let compared = json(&biprism(folder.path(), &["compare", "scene.toml", "--budget", "--json"]));
    let picture = ["measure", "out/freeform.exr", "--scene", "scene.toml", "--budget", "--json"];
    assert_eq!(biprism(folder.path(), &picture).status.code(), Some(2), "only a picture of its own has a truth");
    let measured = json(&biprism(folder.path(), &[&picture[..], &["--own"]].concat()));
    for (design, fitted) in
        [(&compared["designs"][0], false), (&compared["designs"][1], true), (&measured["designs"][0], true)]
    {
        let budget = &design["error_budget"];
        let corners = budget["corners"].as_array().expect("corners");
        assert!(corners.len() > 300 && budget["left_out"] == 0, "{} corners", corners.len());
        assert_eq!(budget["fit"].is_object(), fitted);
        for corner in corners {
            let px = |key: &str, axis: usize| corner[key][axis].as_f64().unwrap_or(0.0);
            for axis in 0..2 {
                let steps: f64 = ["optics_px", "fit_px", "detector_px", "effects_px", "sampling_px"]
                    .map(|key| px(key, axis))
                    .iter()
                    .sum();
                let total = px("measured_px", axis) - px("ideal_px", axis);
                // Positions of 200 px, and their differences.
                assert!(total != 0.0 && (steps - total).abs() < 1e-12, "{corner}");
            }
        }
    }
}

#[test]
fn an_unmet_expectation_is_exit_code_1_and_a_met_one_is_0() {
    let folder = tempfile::tempdir().expect("a folder");
    let claim = |max: f64| {
        let value = "freeform/stereo/vertical_disparity_rms_px/true";
        move |text: String| format!("{text}\n[[expect]]\nvalue = \"{value}\"\nmax = {max}\n")
    };
    small_scene(folder.path(), claim(1e-9));
    let out = biprism(folder.path(), &["compare", "scene.toml"]);
    assert_eq!(out.status.code(), Some(1), "{}", text(&out.stderr));
    assert!(text(&out.stderr).contains("not as expected: freeform/stereo"), "{}", text(&out.stderr));
    small_scene(folder.path(), claim(1.0));
    assert_eq!(biprism(folder.path(), &["compare", "scene.toml"]).status.code(), Some(0));
}

#[test]
fn a_target_chooses_the_level_and_says_what_was_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    for (target, level) in [("0.01", "draft"), ("1e-3", "standard"), ("1e-6", "standard")] {
        let args = ["render", "scene.toml", "--out", "a.png", "--json", "--target-px", target];
        let run = biprism(folder.path(), &args);
        let accuracy = &json(&run)["accuracy"];
        assert_eq!(accuracy["level"], level);
        assert_eq!(accuracy["target_px"].as_f64(), target.parse().ok());
        assert!(accuracy["achieved_px"].as_f64() <= target.parse().ok(), "{accuracy}");
        assert!(text(&run.stderr).contains("the cheapest level that keeps to"), "{}", text(&run.stderr));
    }
    for target in ["-1", "0", "2", "much", "nan"] {
        let run = biprism(folder.path(), &["render", "scene.toml", "--out", "a.png", &format!("--target-px={target}")]);
        assert_eq!(run.status.code(), Some(2), "{target}");
    }
}

#[test]
fn cost_writes_a_table_a_curve_and_the_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let run = biprism(folder.path(), &["cost", "scene.toml", "--quick", "--repetitions", "1", "--json"]);
    let report = json(&run);
    assert_eq!(report["schema"], "biprism-cost/1");
    let levels = report["pictures"].as_array().expect("a list").iter().filter(|p| p["knob"] == "level");
    assert_eq!(levels.count(), 3, "a quick look does not time the reference");
    let read = |name: &str| fs::read(folder.path().join("out").join(name)).expect("written");
    assert_eq!(read("cost.json"), run.stdout);
    assert!(text(&read("cost.csv")).starts_with("kind,knob,value,"));
    for name in ["cost", "cost_design"] {
        assert!(read(&format!("{name}.png")).starts_with(b"\x89PNG"));
        assert!(text(&read(&format!("{name}.svg"))).contains("Pareto front"));
    }
}

#[test]
fn a_bad_scene_is_one_error_with_its_line_and_exit_code_2() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), |text| text.replace("index = 1.48", "index = nan"));
    for verb in [&["compare", "scene.toml"][..], &["check", "scene.toml"], &["render", "scene.toml", "--out", "a.png"]]
    {
        let out = biprism(folder.path(), verb);
        assert_eq!(out.status.code(), Some(2));
        let told = text(&out.stderr);
        assert!(told.contains("index") && told.contains("scene.toml:") && told.contains("help"), "{told}");
        assert_eq!(told.matches("error").count(), 1, "{told}");
        assert!(out.stdout.is_empty());
    }
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "nothing is written");
}

/// The design paper's slip: n_d stands for the index at 486 nm.
#[test]
fn an_index_at_another_wavelength_is_noted() {
    let folder = tempfile::tempdir().expect("a folder");
    let glass = |index: f64, nm: f64| {
        let keys = format!("index = {index}\nglass = \"N-BK7\"\nwavelength_nm = {nm}");
        move |text: String| text.replace("index = 1.48", &keys)
    };
    small_scene(folder.path(), glass(1.5168, 486.0));
    let out = biprism(folder.path(), &["check", "scene.toml"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let told = text(&out.stderr);
    assert!(told.contains("N-BK7 has 1.52239 at 486 nm") && told.contains("1.5168 is its index at 588 nm"), "{told}");
    for right in [glass(1.5168, 587.6), glass(1.5224, 486.0)] {
        small_scene(folder.path(), right);
        assert!(biprism(folder.path(), &["check", "scene.toml"]).stderr.is_empty());
    }
}

/// A picture's plan: what is kept and dropped, and why; and that the picture is made by it.
#[test]
fn check_shows_the_plan_and_render_follows_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let with = |effects: &'static str| {
        move |text: String| {
            let tables = "[effect.cos4]\n[effect.absorption]\nper_mm = 1e-9\n";
            format!("{}\n{tables}", text.replacen("name =", &format!("effects = {effects}\nname ="), 1))
        }
    };
    small_scene(folder.path(), with("\"auto\""));
    let plan = json(&biprism(folder.path(), &["check", "scene.toml", "--json"]))["plan"].clone();
    let effects = plan["effects"].as_array().expect("a list");
    let of = |key: &str| effects.iter().find(|effect| effect["effect"] == key).expect("it acts");
    assert!(of("cos4")["kept"] == true && of("absorption")["kept"] == false, "{plan}");
    assert!(of("absorption")["bound"]["grey"].as_f64().expect("a number") < 1e-6);
    assert!(of("absorption")["saved_s"].is_number() && plan["time_s"].as_f64().expect("a time") > 0.0);
    // Radiance, class, board position: 13 bytes a pixel.
    assert_eq!(plan["memory_bytes"], 480 * 270 * 13);
    assert_eq!((&plan["passes"], &plan["level"]), (&Value::from(1), &Value::from("standard")));
    let told = text(&biprism(folder.path(), &["check", "scene.toml"]).stdout);
    assert!(told.contains("absorption") && told.contains("dropped") && told.contains("every ray reaches"), "{told}");
    let picture = |folder: &Path| {
        let done = biprism(folder, &["render", "scene.toml", "--out", "a.png"]);
        assert!(done.status.success());
        let told = text(&done.stderr).contains("left out: absorption");
        (fs::read(folder.join("a.png")).expect("it is written"), told)
    };
    let (lighter, told) = picture(folder.path());
    assert!(told);
    small_scene(folder.path(), move |text| format!("{text}\n[effect.cos4]\n"));
    assert!(picture(folder.path()) == (lighter, false));
}

/// A PNG holds what the sensor's gamma makes of the light: 0.4^(1/2.2), to a step of 16 bits.
#[test]
fn a_gamma_is_in_the_picture_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let grey = |text: String| {
        let text = text.replace("[board]", "[board]\nblack = 0.4\nwhite = 0.4\nbackground = 0.4");
        format!("{text}\n[effect.sensor]\ngamma = 2.2\n")
    };
    small_scene(folder.path(), grey);
    assert!(biprism(folder.path(), &["render", "scene.toml", "--out", "a.png"]).status.success());
    let (picture, _) = biprism::io::read(&folder.path().join("a.png"), None).expect("a picture");
    let expected = libm::powf(0.4, 1.0 / 2.2);
    assert!(picture.data().iter().all(|v| (v - expected).abs() < 1.0 / 65535.0), "{}", picture.data()[0]);
}

#[test]
fn missing_files_and_bad_names_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    for (args, word) in [
        (&["compare", "nothing.toml"][..], "nothing.toml"),
        (&["render", "scene.toml", "--out", "a.jpg"], ".exr"),
        (&["corners", "scene.toml"], "PNG"),
        (&["measure", "nothing.png", "--scene", "scene.toml"], "nothing.png"),
        (&["trace", "scene.toml", "--points", "nothing.csv"], "nothing.csv"),
        (&["compare", "scene.toml", "--out", "scene.toml/x"], "folder"),
    ] {
        let out = biprism(folder.path(), args);
        assert_eq!(out.status.code(), Some(2), "{args:?}");
        assert!(text(&out.stderr).contains(word), "{args:?}: {}", text(&out.stderr));
    }
    // Where no file can be made, the name that was asked for is told, not that of the temporary file.
    #[cfg(target_os = "linux")]
    {
        let told = text(&biprism(folder.path(), &["render", "scene.toml", "--out", "/proc/a.png"]).stderr);
        assert!(told.contains("/proc/a.png") && !told.contains(".biprism-"), "{told}");
        assert!(told.contains("write to another one") && !told.contains("create its directory"), "{told}");
    }
}

#[test]
fn tracing_forth_and_back_is_the_identity() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let forth = with_input(folder.path(), &["trace", "scene.toml"], "x_px,y_px\n10.25,20.5\n400.75,133.125\n");
    assert!(forth.status.success(), "{}", text(&forth.stderr));
    let lines = text(&forth.stdout);
    let rows: Vec<Vec<&str>> = lines.lines().skip(1).map(|l| l.split(',').collect()).collect();
    assert_eq!(rows.len(), 2);
    assert_eq!(rows[0][2..4], ["left", "board"]);
    let points: String = rows.iter().map(|r| format!("{},{},{}\n", r[2], r[4], r[5])).collect();
    let back = json(&with_input(folder.path(), &["trace", "scene.toml", "--back", "--json"], &points));
    for (k, px) in [[10.25, 20.5], [400.75, 133.125]].iter().enumerate() {
        let found = &back[k]["pixel_px"];
        let miss = (0..2).map(|a| (found[a].as_f64().expect("a number") - px[a]).abs()).fold(0.0, f64::max);
        assert!(miss < 1e-10, "{found}");
        assert_eq!(back[k]["seen"], true);
    }
    let bad = with_input(folder.path(), &["trace", "scene.toml"], "1,2\n3,nan\n");
    assert_eq!(bad.status.code(), Some(2));
    assert!(text(&bad.stderr).contains("stdin:2") && text(&bad.stderr).contains("y_px"), "{}", text(&bad.stderr));
}

#[test]
fn a_designed_prism_comes_back_through_the_front_door() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = small_scene(folder.path(), as_is);
    let figures = json(&biprism(folder.path(), &["design", "scene.toml", "--json"]));
    assert!((figures["facet_angle_deg"].as_f64().expect("a number") - 8.85428).abs() < 5e-6);
    let prism = fs::read_to_string(folder.path().join("out/prism.toml")).expect("written");
    let whole = fs::read_to_string(scene).expect("the scene");
    let (camera, rest) = whole.split_once("[prism]").expect("a prism");
    let board = &rest[rest.find("[board]").expect("a board")..];
    let clouds = "[prism]\nkind = \"point_cloud\"\nindex = 1.48\n[prism.front]\nfile = \"out/front.ply\"\ndegree = 5\n\
                  [prism.back]\nfile = \"out/cloud.csv\"\ndegree = 5\n";
    fs::write(folder.path().join("polynomial.toml"), format!("{camera}{prism}\n{board}")).expect("written");
    fs::write(folder.path().join("clouds.toml"), format!("{camera}{clouds}\n{board}")).expect("written");
    let board_of = |scene: &str| {
        let seen = json(&with_input(folder.path(), &["trace", scene, "--json"], "33.5,44.5\n"));
        [0, 1].map(|k| seen[0]["board_mm"][k].as_f64().expect("a number"))
    };
    let designed = board_of("scene.toml");
    // Scene text keeps every bit of a coefficient.
    assert_eq!(board_of("polynomial.toml"), designed);
    // The cloud is fitted about another centre and scale: the same surface but for rounding.
    let refitted = board_of("clouds.toml");
    assert!((0..2).all(|k| (refitted[k] - designed[k]).abs() < 1e-8), "{refitted:?} {designed:?}");
}

#[test]
fn corners_and_measure_take_pictures_from_files() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let rendered = biprism(folder.path(), &["render", "scene.toml", "--out", "a.png", "--out", "a.exr", "--json"]);
    assert_eq!(json(&rendered)["fates"]["missed"], 0);
    let csv = biprism(folder.path(), &["corners", "a.png"]);
    assert!(csv.status.success(), "{}", text(&csv.stderr));
    // A remark on the convention, the heading, and a line a corner.
    let rows = text(&csv.stdout).lines().filter(|line| !line.starts_with('#')).count() - 1;
    assert!(rows > 300, "{rows}");
    let found = json(&biprism(folder.path(), &["corners", "a.exr", "--json"]));
    let count = |k: usize| found["halves"][k]["corners"].as_array().map_or(0, Vec::len);
    assert_eq!(count(0) + count(1), rows);
    let report = json(&biprism(folder.path(), &["measure", "a.exr", "--scene", "scene.toml", "--own", "--json"]));
    assert_eq!(report["designs"][0]["corners"]["false"], 0);
    let report = json(&biprism(folder.path(), &["measure", "a.png", "--scene", "scene.toml", "--json"]));
    assert_eq!(report["designs"][0]["corners"]["visible"], Value::Null);
    assert!(report["designs"][0]["stereo"]["vertical_disparity_rms_px"]["measured"].is_f64());
}

#[test]
fn corners_of_another_program_are_measured_as_our_own() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let run = |args: &[&str]| biprism(folder.path(), args);
    assert!(run(&["render", "scene.toml", "--out", "a.exr"]).status.success());
    let told = json(&run(&["corners", "a.exr", "--out", "a.csv", "--json"]));
    assert!(told["halves"][0]["corners"].as_u64() > Some(100) && told["halves"][1]["rejected"]["ring"].is_u64());
    // The design's figures, without the times and what only a detection tells.
    let figures = |file: &str| {
        let report = json(&run(&["measure", file, "--scene", "scene.toml", "--own", "--json"]));
        let design = &report["designs"][0];
        assert_eq!(
            (&design["corners"]["false"], &design["corners"]["found"]),
            (&0.into(), &design["corners"]["visible"])
        );
        [
            design["stereo"]["vertical_disparity_rms_px"]["measured"].as_f64().expect("a number"),
            design["corners"]["rms_error_px"].as_f64().expect("a number"),
        ]
    };
    let own = figures("a.exr");
    // A half's own px and those of the whole picture differ by a shift that rounds.
    let same = |file: &str| figures(file).iter().zip(own).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(same("a.csv"));
    assert!(run(&["corners", "a.csv", "--out", "a.yml"]).status.success());
    assert!(same("a.yml"));
    // Another program knows neither our qualities nor our numbering: rows before columns, from the lower right.
    let lines = fs::read_to_string(folder.path().join("a.csv")).expect("it was written");
    let foreign = lines.lines().filter(|line| !line.starts_with(['#', 'h'])).map(|line| {
        let f: Vec<&str> = line.split(',').collect();
        let turned = |k: usize| 40 - f[k].parse::<i32>().expect("a whole number");
        format!("{},{},{},{},{}\n", f[0], turned(2), turned(1), f[3], f[4])
    });
    let head = "# pixel centre: (i + 0.5, j + 0.5)\nhalf,column,row,x_px,y_px\n";
    fs::write(folder.path().join("b.csv"), foreign.fold(head.to_owned(), |all, line| all + &line)).expect("written");
    assert!(same("b.csv"));
    for (file, text, rule) in [
        ("c.csv", lines.replace("left,", "whole,"), "must have those of left and right"),
        ("d.csv", lines.replace("left,", "middle,").replace("right,", "left,"), "must have those of left and right"),
        ("e.csv", lines.replacen("right,", "left,99", 1), "lies at"),
        ("f.csv", lines.replacen("(i + 0.5, j + 0.5)", "(i, j)", 1), "the pixel centre is"),
        ("g.csv", lines[..lines.len() / 2].to_owned(), ""),
    ] {
        fs::write(folder.path().join(file), text).expect("written");
        let refused = run(&["measure", file, "--scene", "scene.toml"]);
        assert_eq!(refused.status.code(), Some(2), "{file}");
        assert!(self::text(&refused.stderr).contains(rule), "{file}: {}", self::text(&refused.stderr));
    }
}

#[test]
fn golden_says_what_moved() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases = folder.path().join("cases");
    fs::create_dir(&cases).expect("a folder");
    fs::copy(repository("scenes/cases/sensor_tiny.toml"), cases.join("sensor_tiny.toml")).expect("copied");
    let run = |update: &str| {
        Command::new(env!("CARGO_BIN_EXE_biprism"))
            .current_dir(folder.path())
            .env("UPDATE_GOLDEN", update)
            .env_remove("CI")
            .args(["golden", "cases"])
            .output()
            .expect("it runs")
    };
    assert_eq!(run("0").status.code(), Some(1), "a case without a golden fails");
    assert_eq!(run("1").status.code(), Some(0));
    assert_eq!(run("0").status.code(), Some(0));
    fs::remove_file(cases.join("sensor_tiny.toml")).expect("removed");
    fs::copy(repository("scenes/cases/prism_none.toml"), cases.join("prism_none.toml")).expect("copied");
    let out = run("0");
    assert_eq!(out.status.code(), Some(1));
    assert!(text(&out.stdout).contains("sensor_tiny"), "a golden without a case fails: {}", text(&out.stdout));
}
