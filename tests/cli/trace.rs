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

/// A thin prism turns rays by (n - 1) times its angle, with the catalogue's indices of N-BK7: 1.52238 at 486.13 nm, 1.5168 at
/// 587.56 nm, 1.51432 at 656.27 nm.
#[test]
fn a_wavelength_is_that_of_the_glass() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let of_glass = ["--set", "prism.glass=N-BK7", "--set", "prism.index=1.5168"];
    let traced = |nm: &str| {
        let args = [&["trace", "scene.toml", "--json", "--wavelength-nm", nm], &of_glass[..]].concat();
        json(&with_input(folder.path(), &args, "100.5,40.5\n"))[0].take()
    };
    let number = |row: &serde_json::Value, key: &str, axis: usize| row[key][axis].as_f64().expect("a number");
    let [blue, yellow, red] = ["486.1327", "587.5618", "656.2725"].map(traced);
    let slope = |key: &str| number(&yellow, key, 0) / number(&yellow, key, 2);
    let turned = slope("exit_direction") - slope("front_mm");
    let behind_mm = 1000.0 - number(&yellow, "back_mm", 2);
    let apart = number(&blue, "board_mm", 0) - number(&red, "board_mm", 0);
    let expected = behind_mm * turned * (1.52238 - 1.51432) / 0.5168;
    assert!((apart / expected - 1.0).abs() < 0.03, "{apart} mm, {expected} mm expected");

    let refused = |more: &[&str], word: &str| {
        let out = with_input(folder.path(), &[&["trace", "scene.toml", "--wavelength-nm"], more].concat(), "1,1\n");
        assert_eq!(out.status.code(), Some(2), "{more:?}");
        assert!(text(&out.stderr).contains(word), "{more:?}: {}", text(&out.stderr));
    };
    refused(&["500"], "says nothing of other wavelengths");
    refused(&[&["99"], &of_glass[..]].concat(), "300 to 2500 nm");
    refused(&[&["nan"], &of_glass[..]].concat(), "NaN");
}

/// The records of an NPY file, of so many bytes each.
fn records(bytes: &[u8], size: usize) -> Vec<&[u8]> {
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    bytes[start..].chunks_exact(size).collect()
}

/// An NPY file of f64.
fn npy(rows: &[&[f64]]) -> Vec<u8> {
    let header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {}), }}\n", rows.len(), rows[0].len());
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(rows.concat().iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// Arrays in and out hold what the text holds, bit by bit, also of rays that end in the glass.
#[test]
fn rays_are_the_same_as_text_and_as_arrays() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let pixels = [[10.25, 20.5], [400.75, 133.125], [-900.0, 0.5]];
    fs::write(folder.path().join("in.npy"), npy(&pixels.each_ref().map(|px| &px[..]))).expect("written");
    let run = |args: &[&str]| {
        let done = biprism(folder.path(), &[&["trace", "scene.toml"], args].concat());
        assert!(done.status.success(), "{}", text(&done.stderr));
        text(&done.stdout)
    };
    let read = |name: &str| fs::read(folder.path().join(name)).expect("written");
    let rows = run(&["--in", "in.npy"]);
    assert_eq!(run(&["--points", "in.npy", "--out", "out.npy"]), "", "the array is all that is written");
    let bytes = read("out.npy");
    let found = records(&bytes, 160);
    assert_eq!(found.len(), 3);
    for (line, record) in rows.lines().skip(1).zip(found) {
        let mut fields: Vec<&str> = line.split(',').collect();
        let (side, fate) = (fields.remove(2), fields.remove(2));
        for (k, field) in fields.iter().enumerate() {
            let value = f64::from_le_bytes(*record[8 * k..].first_chunk().expect("8 bytes"));
            let told = if field.is_empty() { f64::NAN } else { field.parse().expect("a number") };
            assert!(value == told || (value.is_nan() && told.is_nan()), "{k}: {value} {field}");
        }
        let number = |at: usize| u32::from_le_bytes(*record[at..].first_chunk().expect("4 bytes"));
        let side = ["left", "right", ""].iter().position(|name| *name == side).expect("a side");
        let class = if fate == "board" { side } else { 2 };
        assert_eq!([number(152), number(156)], [side as u32, class as u32], "{line}");
    }

    // Back, by the places that were found, and one far beside the picture.
    let places: Vec<[f64; 3]> = rows
        .lines()
        .skip(1)
        .take(2)
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            let [u, v] = [4, 5].map(|k| fields[k].parse().expect("a number"));
            [f64::from(fields[2] == "right"), u, v]
        })
        .chain([[0.0, 3000.0, 0.0]])
        .collect();
    fs::write(folder.path().join("back.npy"), npy(&places.iter().map(|place| &place[..]).collect::<Vec<_>>()))
        .expect("written");
    run(&["--back", "--in", "back.npy", "--out", "pixels.npy"]);
    let bytes = read("pixels.npy");
    for ((record, px), place) in records(&bytes, 44).iter().zip(pixels).zip(&places) {
        let value = |k: usize| f64::from_le_bytes(*record[8 * k..].first_chunk().expect("8 bytes"));
        assert_eq!([value(0), value(1)], place[1..]);
        let seen = u32::from_le_bytes(*record[40..].first_chunk().expect("4 bytes"));
        let near = libm::hypot(value(2) - px[0], value(3) - px[1]) < 1e-10;
        assert_eq!([near, seen == 1], [place[1] < 2000.0; 2], "{px:?}");
    }
    for (args, said) in [
        (&["--in", "back.npy"][..], "shape (3, 3)"),
        (&["--back", "--in", "in.npy"], "must have (n, 3)"),
        (&["--in", "in.npy", "--out", "a.csv"], "does not end in .npy"),
        (&["--in", "in.npy", "--out", "in.npy"], "read"),
    ] {
        let done = biprism(folder.path(), &[&["trace", "scene.toml"], args].concat());
        assert!(done.status.code() == Some(2) && text(&done.stderr).contains(said), "{args:?}: {}", text(&done.stderr));
    }
}

#[test]
fn a_designed_prism_comes_back_through_the_front_door() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = small_scene(folder.path(), |text| text.replace("degree = 5", "degree = 9"));
    let figures = json(&biprism(folder.path(), &["design", "scene.toml", "--cloud", "csv,ply", "--json"]));
    assert!((figures["facet_angle_deg"].as_f64().expect("a number") - 8.85428).abs() < 5e-6);
    let prism = fs::read_to_string(folder.path().join("out/prism.toml")).expect("written");
    let whole = fs::read_to_string(scene).expect("the scene");
    let (camera, rest) = whole.split_once("[prism]").expect("a prism");
    let board = &rest[rest.find("[board]").expect("a board")..];
    let clouds = "[prism]\nkind = \"point_cloud\"\nindex = 1.48\n[prism.front]\nfile = \"out/front.ply\"\ndegree = 9\n\
                  [prism.back]\nfile = \"out/cloud.csv\"\ndegree = 9\n";
    fs::write(folder.path().join("polynomial.toml"), format!("{camera}{prism}\n{board}")).expect("written");
    fs::write(folder.path().join("clouds.toml"), format!("{camera}{clouds}\n{board}")).expect("written");
    let board_of = |scene: &str| {
        let seen = json(&with_input(folder.path(), &["trace", scene, "--json"], "33.5,44.5\n"));
        [0, 1].map(|k| seen[0]["board_mm"][k].as_f64().expect("a number"))
    };
    let designed = board_of("scene.toml");
    // Scene text keeps every bit of a coefficient.
    assert_eq!(board_of("polynomial.toml"), designed);
    // The points of a cloud count alike, those of a design by Simpson's rule: the same surface but for what degree 9 leaves of the
    // points, below 1e-10 mm over 6 mm, so that slopes differ by less than 81 * 2e-10 / 6 (Markov's inequality), and at 1000 mm by this.
    let refitted = board_of("clouds.toml");
    assert!((0..2).all(|k| (refitted[k] - designed[k]).abs() < 2.7e-6), "{refitted:?} {designed:?}");
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
