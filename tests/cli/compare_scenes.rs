//! `compare` of several scenes: each scene's own prism, its cameras and its corners.

use crate::command::{biprism, json, text, tiny_scene};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The tiny scene under another name and over three depths, changed by `edit`, as the file `name.toml`.
fn scene(folder: &Path, name: &str, edit: impl Fn(String) -> String) {
    tiny_scene(folder, |text| {
        let named = text.replace("name = \"paper\"", &format!("name = \"{name}\""));
        edit(named.replace("depths_mm = [1000.0]", "depths_mm = [500.0, 1000.0, 2000.0]"))
    });
    fs::rename(folder.join("scene.toml"), folder.join(format!("{name}.toml"))).expect("renamed");
}

fn flat(text: String) -> String {
    let design = text.find("[prism.design]").expect("it is there");
    let end = text[design..].find("\n\n").expect("it ends") + design;
    format!("{}{}", &text[..design], &text[end..]).replace("kind = \"freeform\"", "kind = \"flat\"")
}

/// A row of the table of corners: design, half, index, and the numbers that are there.
type CornerRow = (String, String, [f64; 2], Vec<Option<f64>>);

fn rows(csv: &str) -> Vec<CornerRow> {
    csv.lines()
        .skip(2)
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |cell: &&str| cell.parse().ok();
            let index = [2, 3].map(|k: usize| cells[k].parse().expect("an index"));
            (cells[0].to_owned(), cells[1].to_owned(), index, cells[4..].iter().map(number).collect())
        })
        .collect()
}

fn square(v: f64) -> f64 {
    v * v
}

#[test]
fn prisms_of_several_scenes_are_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    scene(folder.path(), "one", |text| text);
    scene(folder.path(), "two", flat);
    scene(folder.path(), "three", |text| flat(text).replace("[prism]\n", "[prism]\nposition_mm = [0.3, 0.1, 0.0]\n"));
    let report = json(&biprism(
        folder.path(),
        &["compare", "one.toml", "two.toml", "three.toml", "--pictures", "all", "--json"],
    ));
    let designs = report["designs"].as_array().expect("designs");
    assert_eq!(designs.iter().map(|d| &d["name"]).collect::<Vec<_>>(), ["one", "two", "three"]);

    // Each is what it is alone.
    let alone = json(&biprism(folder.path(), &["compare", "one.toml", "--out", "alone", "--json"]));
    for (name, of) in [("freeform", 0), ("flat", 1)] {
        let alone = alone["designs"].as_array().expect("designs").iter().find(|d| d["name"] == name).expect("judged");
        for key in ["stereo", "pinhole", "geometry", "cameras", "corners"] {
            assert_eq!(alone[key], designs[of][key], "{name} {key}");
        }
    }
    assert_ne!(designs[1]["stereo"], designs[2]["stereo"]);
    for name in ["one.png", "two.exr", "three.exr", "comparison.png", "report.json", "cameras.yml", "corners.csv"] {
        assert!(folder.path().join("out").join(name).exists(), "{name}");
    }

    // The table of corners holds each, with differences that are its own.
    let table = rows(&fs::read_to_string(folder.path().join("out/corners.csv")).expect("written"));
    for design in designs {
        let name = design["name"].as_str().expect("a name");
        let own: Vec<_> = table.iter().filter(|row| row.0 == name).collect();
        let found = own.iter().filter(|row| row.3[0].is_some()).count() as u64;
        let counted = |key: &str| design["corners"][key].as_u64().expect("a count");
        assert_eq!(found, counted("found") + counted("partial"), "{name}");
        let mut squares = 0.0;
        for (_, _, _, cells) in &own {
            let Some(measured) = cells[0] else { continue };
            let [true_x, ideal_x] = [2, 4].map(|k| cells[k].expect("known"));
            // Positions of 200 px.
            for (cell, difference) in [(6, measured - true_x), (8, measured - ideal_x)] {
                assert!((cells[cell].expect("known") - difference).abs() < 1e-12, "{name}: {cells:?}");
            }
            squares += square(cells[6].expect("known")) + square(cells[7].expect("known"));
        }
        let rms = (squares / found as f64).sqrt();
        assert!((rms / design["corners"]["rms_error_px"].as_f64().expect("a number") - 1.0).abs() < 1e-6, "{name}");
        reprojected(design, &own);
    }
}

/// The cameras of a design see its true corners with the residual that they state.
fn reprojected(design: &Value, rows: &[&CornerRow]) {
    let cameras = &design["cameras"];
    let matrix = |value: &Value, i: usize, k: usize| value[i][k].as_f64().expect("a number");
    let (columns, square_mm, depth) = (21.0, 20.0, 1000.0);
    assert_eq!(cameras["depths_mm"], serde_json::json!([500.0, 2000.0]));
    for (half, first_column) in
        [("left", 0.0), ("right", cameras["right_half_first_column"].as_f64().expect("a number"))]
    {
        let camera = &cameras[half];
        let own: Vec<_> = rows.iter().filter(|row| row.1 == half && row.3[2].is_some()).collect();
        let (mut largest, mut sum): (f64, [f64; 2]) = (0.0, [0.0; 2]);
        for row in &own {
            let place = |k: usize| (row.2[k] - 0.5 * (columns - 2.0)) * square_mm;
            let world = [place(0), place(1), depth];
            let pose = &camera["camera_from_world"];
            let seen = [0, 1, 2].map(|i| {
                let turned: f64 = (0..3).map(|k| matrix(&pose["r"], i, k) * world[k]).sum();
                turned + pose["t_mm"][i].as_f64().expect("a number")
            });
            for (axis, sum) in sum.iter_mut().enumerate() {
                let px = (0..3).map(|k| matrix(&camera["k"], axis, k) * seen[k]).sum::<f64>() / seen[2];
                // OpenCV's px of the half itself.
                let expected = row.3[2 + axis].expect("known") - 0.5 - if axis == 0 { first_column } else { 0.0 };
                largest = largest.max((px - expected).abs());
                *sum += px - expected;
            }
        }
        // No residual is above sqrt(N) times the root mean square of N.
        let (rms, n) = (camera["rms_px"].as_f64().expect("a number"), camera["n"].as_f64().expect("a number"));
        assert!(own.len() > 20 && n > 2.0 * own.len() as f64, "{half}: {n}");
        // The fit leaves no mean over all depths, and little at one.
        let means = sum.map(|sum| sum / own.len() as f64);
        assert!(means.iter().all(|mean| mean.abs() < rms), "{half}: {means:?} {rms}");
        assert!(largest <= rms * n.sqrt() && largest > 0.1 * rms, "{half}: {largest} {rms}");
    }
    let t = &cameras["right_from_left"]["t_mm"];
    let length = (0..3).map(|k| square(t[k].as_f64().expect("a number"))).sum::<f64>().sqrt();
    let baseline = design["geometry"]["baseline_mm"]["true"].as_f64().expect("a number");
    assert!((length / baseline - 1.0).abs() < 1e-12, "{length} {baseline}");
}

#[test]
fn scenes_that_cannot_be_compared_are_refused_and_claims_are_held() {
    let folder = tempfile::tempdir().expect("a folder");
    let claim = |name: &str, max: f64| {
        format!("\n[[expect]]\nvalue = \"{name}/stereo/vertical_disparity_rms_px/true\"\nmax = {max}\n")
    };
    scene(folder.path(), "one", |text| text + &claim("freeform", 1e-9) + &claim("flat", 1e-9));
    scene(folder.path(), "two", |text| flat(text) + &claim("two", 100.0));
    fs::write(folder.path().join("none.toml"), "name = \"none\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 64\nheight_px = 36\npixel_pitch_um = 100.0\n[prism]\nkind = \"none\"\n[board]\ncolumns = 9\nrows = 9\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]\n").expect("written");
    for (args, words) in [
        (&["one.toml", "none.toml"][..], "no prism to judge"),
        (&["-", "two.toml", "-"], "stdin is read only once"),
        (&["one.toml"; 9], "at most 8 are compared"),
    ] {
        let out = biprism(folder.path(), &[&["compare"], args].concat());
        assert_eq!(out.status.code(), Some(2), "{}", text(&out.stderr));
        assert!(text(&out.stderr).contains(words), "{}", text(&out.stderr));
        assert!(!folder.path().join("out").exists());
    }
    let out = biprism(folder.path(), &["compare", "one.toml", "two.toml"]);
    assert_eq!(out.status.code(), Some(1), "{}", text(&out.stderr));
    let told = text(&out.stderr);
    assert!(told.contains("not as expected: freeform/stereo") && !told.contains("not as expected: two"), "{told}");
    assert!(told.contains("`flat/stereo/vertical_disparity_rms_px/true` is not judged beside other scenes"), "{told}");
}
