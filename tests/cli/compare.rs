//! `compare` and `cost`: reports, budgets, expectations.

use crate::command::{as_is, biprism, json, quarter, small_scene, text, tiny_scene};
use serde_json::Value;
use std::fs;
use std::process::Command;

#[test]
fn compare_writes_the_same_bytes_for_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let mut first: Option<Vec<(String, Vec<u8>)>> = None;
    for threads in ["1", "2", "7", "64"] {
        let out = Command::new(env!("CARGO_BIN_EXE_biprism"))
            .current_dir(folder.path())
            .env("RAYON_NUM_THREADS", threads)
            .args(["compare", "scene.toml", "--budget", "--pictures", "all", "--out", threads])
            .output()
            .expect("it runs");
        assert!(out.status.success(), "{}", text(&out.stderr));
        assert!(!text(&out.stderr).contains(['\r', '\u{1b}', '█']), "no progress bar in a pipe");
        let read = |name: &str| {
            let bytes = fs::read(folder.path().join(threads).join(name)).expect("written");
            if name == "report.html" {
                // It names its own folder.
                return (name.to_owned(), text(&bytes).replace(&format!("--out {threads}"), "--out N").into_bytes());
            }
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
        let files: Vec<_> = pictures
            .into_iter()
            .chain(["report.json", "report.html", "cameras.yml", "corners.csv"])
            .map(read)
            .collect();
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
        // The level may move lines by 1e-5 px, and the detector, on pictures without noise, by about as much; the main job
        // asks for 0.01.
        assert!(corners["rms_error_px"].as_f64().is_some_and(|e| e <= 3e-5), "{corners}");
    }
    let disparity = |k: usize, side: &str| {
        report["designs"][k]["stereo"]["vertical_disparity_rms_px"][side].as_f64().expect("a number")
    };
    let [flat, freeform] = [0, 1].map(|k| disparity(k, "measured"));
    // Beyond a factor of 100 the flat prism is worse, and what is measured is what is there.
    assert!(flat > 100.0 * freeform, "flat {flat}, freeform {freeform}");
    for (k, measured) in [flat, freeform].into_iter().enumerate() {
        assert!((measured - disparity(k, "true")).abs() < 3e-5, "{measured} {}", disparity(k, "true"));
    }
}

#[test]
fn a_budget_splits_the_error_of_every_corner() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let all = ["compare", "scene.toml", "--budget", "--pictures", "all", "--json"];
    let compared = json(&biprism(folder.path(), &all));
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

/// What is written by default is small: the truth of every pixel, and the points of a design, are there where they are asked for.
#[test]
fn only_the_pictures_that_are_asked_for_are_written() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let written = |args: &[&str]| {
        let out = biprism(folder.path(), &[args, &["--out", "new"]].concat());
        assert!(out.status.success(), "{args:?}: {}", text(&out.stderr));
        let entries = fs::read_dir(folder.path().join("new")).expect("the folder");
        let mut names: Vec<String> = entries.map(|e| e.expect("it").file_name().display().to_string()).collect();
        names.sort();
        fs::remove_dir_all(folder.path().join("new")).expect("removed");
        names.join(" ")
    };
    let numbers = "cameras.yml corners.csv report.json";
    assert_eq!(written(&["compare", "scene.toml", "--pictures", "none"]), numbers);
    let drawn = "cameras.yml comparison.png comparison.svg corners.csv flat.png freeform.png overview.png overview.svg \
                 report.html report.json";
    assert_eq!(written(&["compare", "scene.toml"]), drawn);
    let all = written(&["compare", "scene.toml", "--pictures", "all"]);
    assert_eq!(all.replace("flat.exr ", "").replace("freeform.exr ", ""), drawn);
    assert_eq!(written(&["design", "scene.toml"]), "prism.toml");
    assert_eq!(written(&["design", "scene.toml", "--cloud", "ply"]), "back.ply front.ply prism.toml");
    assert_eq!(written(&["design", "scene.toml", "--cloud", "csv,ply"]), "back.ply cloud.csv front.ply prism.toml");
}

#[test]
fn an_unmet_expectation_is_exit_code_1_and_a_met_one_is_0() {
    let folder = tempfile::tempdir().expect("a folder");
    let claim = |max: f64| {
        let value = "freeform/stereo/vertical_disparity_rms_px/true";
        move |text: String| format!("{text}\n[[expect]]\nvalue = \"{value}\"\nmax = {max}\n")
    };
    tiny_scene(folder.path(), claim(1e-9));
    let out = biprism(folder.path(), &["compare", "scene.toml"]);
    assert_eq!(out.status.code(), Some(1), "{}", text(&out.stderr));
    assert!(text(&out.stderr).contains("not as expected: freeform/stereo"), "{}", text(&out.stderr));
    tiny_scene(folder.path(), claim(1.0));
    assert_eq!(biprism(folder.path(), &["compare", "scene.toml"]).status.code(), Some(0));
}

#[test]
fn cost_writes_a_table_a_curve_and_the_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), quarter);
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
