//! `corners` and `measure`: pictures and lists of corners from files.

use crate::command::{as_is, biprism, json, small_scene, text};
use serde_json::Value;
use std::fs;

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
