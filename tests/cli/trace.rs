//! `trace`, `design` and `golden`: tables forth and back, prisms as scene text, regression.

use crate::command::{as_is, biprism, json, repository, small_scene, text, with_input};
use std::fs;
use std::process::Command;

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
