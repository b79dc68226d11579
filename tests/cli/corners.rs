//! `corners` and `measure`: pictures and lists of corners from files.

use crate::command::{as_is, biprism, json, small_scene, text, tiny_scene, with_input};
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
    let table = text(&told.stdout);
    assert_eq!(table.matches("\n-: too few depths of the board: 1").count(), 1, "{table}");
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

/// By the scene, the index of every corner is its column and row on the board: where `trace --back` says that this corner of the
/// board is seen, there it was found.
#[test]
fn corners_are_numbered_by_the_board_of_a_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |args: &[&str]| biprism(folder.path(), args);
    let flat = |text: String| {
        let text = text.replace("kind = \"freeform\"", "kind = \"flat\"");
        let (head, tail) = text.split_once("[prism.design]").expect("the paper's scene has a design");
        format!("{head}{}", &tail[tail.find("\n[").expect("another table")..])
    };
    for roll in [0, 90] {
        let rolled = format!("[board]\ntilt_deg = [0.0, 0.0, {roll}.0]");
        let scene = |text: String| flat(text).replace("[board]", &rolled);
        tiny_scene(folder.path(), scene);
        assert!(run(&["render", "scene.toml", "--out", "a.png"]).status.success());
        let found = run(&["corners", "a.png", "--scene", "scene.toml", "--json"]);
        let found = json(&found);
        let mut asked = "side,u_mm,v_mm\n".to_owned();
        let mut positions = Vec::new();
        for half in found["halves"].as_array().expect("two") {
            for corner in half["corners"].as_array().expect("a list") {
                // 21 x 21 squares of 20 mm, the board's centre its origin.
                let [u, v] = [0, 1].map(|k| 20.0 * (corner["index"][k].as_f64().expect("a number") + 1.0 - 10.5));
                asked += &format!("{},{u},{v}\n", half["half"].as_str().expect("a name"));
                positions.push([0, 1].map(|k| corner["position_px"][k].as_f64().expect("a number")));
            }
        }
        assert!(positions.len() > 60, "{}", positions.len());
        let seen = json(&with_input(folder.path(), &["trace", "scene.toml", "--back", "--json"], &asked));
        for (seen, found) in seen.as_array().expect("a list").iter().zip(&positions) {
            for k in [0, 1] {
                let px = seen["pixel_px"][k].as_f64().expect("it is seen");
                // A hundredth of a square of some 15 px.
                assert!((px - found[k]).abs() < 0.15, "rolled by {roll}: {seen}, found at {found:?}");
            }
        }

        // Lists get the same numbers, whatever their own are, and every format holds them.
        assert!(run(&["corners", "a.png", "--out", "own.csv"]).status.success());
        let lines = fs::read_to_string(folder.path().join("own.csv")).expect("it was written");
        let head = "# pixel centre: (i + 0.5, j + 0.5)\nhalf,column,row,x_px,y_px\n";
        let foreign = lines.lines().filter(|line| !line.starts_with(['#', 'h'])).map(|line| {
            let f: Vec<&str> = line.split(',').collect();
            format!("{},{},{},{},{}\n", f[0], f[2], f[1], f[3], f[4])
        });
        fs::write(folder.path().join("b.csv"), foreign.fold(head.to_owned(), |all, l| all + &l)).expect("written");
        for list in ["own.csv", "b.csv"] {
            let again = json(&run(&["corners", list, "--scene", "scene.toml", "--json"]));
            for (half, other) in [0, 1].map(|k| (&found["halves"][k]["corners"], &again["halves"][k]["corners"])) {
                let pairs = half.as_array().expect("a list").iter().zip(other.as_array().expect("a list"));
                assert!(half.as_array().map(Vec::len) == other.as_array().map(Vec::len), "{list}");
                for (a, b) in pairs {
                    assert!(a["index"] == b["index"] && a["position_px"] == b["position_px"], "{list}: {a} and {b}");
                    assert!(list == "b.csv" || a["polarity"] == b["polarity"], "{list}: {a} and {b}");
                }
            }
        }
    }
    for file in ["a.csv", "a.yml", "a.json"] {
        assert!(run(&["corners", "a.png", "--scene", "scene.toml", "--out", file]).status.success(), "{file}");
        assert!(run(&["measure", file, "--scene", "scene.toml"]).status.success(), "{file}");
    }
}

/// What has no place on the board is left out, counted and told, by half.
#[test]
fn corners_that_the_scene_does_not_place_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |args: &[&str]| biprism(folder.path(), args);
    let none = |text: String| {
        let (head, tail) = text.split_once("[prism]").expect("the paper's scene has a prism");
        format!("{head}[prism]\nkind = \"none\"\n\n{}", &tail[tail.find("[board]").expect("a board")..])
    };
    tiny_scene(folder.path(), none);
    assert!(run(&["render", "scene.toml", "--out", "a.png"]).status.success());
    let all = json(&run(&["corners", "a.png", "--scene", "scene.toml", "--json"]));
    let count = |halves: &Value, k: usize| halves["halves"][k]["corners"].as_array().map_or(0, Vec::len);
    assert!(count(&all, 0) > 30 && count(&all, 1) > 30, "{all}");

    // Half a square aside: the scene tells nothing.
    tiny_scene(folder.path(), |text| {
        none(text).replace("position_mm = [0.0, 0.0, 1000.0]", "position_mm = [10.0, 10.0, 1000.0]")
    });
    let lost = run(&["corners", "a.png", "--scene", "scene.toml", "--json"]);
    let told = text(&lost.stderr);
    assert_eq!(lost.status.code(), Some(1), "{told}");
    assert!(
        told.contains("left: the scene does not tell") && told.contains("right: the scene does not tell"),
        "{told}"
    );
    let halves: Value = serde_json::from_slice(&lost.stdout).expect("JSON all the same");
    assert!(count(&halves, 0) == 0 && halves["halves"][0]["rejected"]["not-indexed"] == count(&all, 0), "{halves}");

    // A board of fewer squares than are seen.
    tiny_scene(folder.path(), |text| none(text).replace("columns = 21\nrows = 21", "columns = 7\nrows = 7"));
    let fewer = run(&["corners", "a.png", "--scene", "scene.toml", "--json"]);
    let found = json(&fewer);
    assert!(text(&fewer.stderr).contains("lie where the scene's board has none"), "{}", text(&fewer.stderr));
    let indices = found["halves"][0]["corners"].as_array().expect("a list").iter();
    assert!(
        indices.clone().count() > 5 && indices.clone().all(|c| (0..6).contains(&c["index"][0].as_i64().expect("i")))
    );
    let off = found["halves"][0]["rejected"]["off-board"].as_u64().expect("a count") as usize;
    assert_eq!(off + count(&found, 0), count(&all, 0));

    small_scene(folder.path(), none);
    let refused = run(&["corners", "a.png", "--scene", "scene.toml"]);
    assert!(refused.status.code() == Some(2) && text(&refused.stderr).contains("the picture is 240 x 135"));
    let whole = run(&["corners", "a.png", "--scene", "scene.toml", "--whole"]);
    assert_eq!(whole.status.code(), Some(2));
}

/// A picture of an earlier version tells its instrument in another form: that is noted, and it is measured all the same.
#[test]
fn a_picture_of_an_earlier_version_is_noted_and_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let path = folder.path().join("a.png");
    assert!(biprism(folder.path(), &["render", "scene.toml", "--out", "a.png"]).status.success());
    let (picture, metadata) = biprism::io::read(&path, None).expect("a picture");
    let mut notes: Value = metadata.texts["biprism"].parse().expect("JSON");
    notes["instrument"] = serde_json::json!({ "camera": "32de115be9f41af6", "prism": "ca17ae0be3fa70d8" });
    let notes = notes.to_string();
    let notes = biprism::io::Notes { json: &notes, pitch_mm: None };
    biprism::io::png::write_grey16(&path, &picture, biprism::raster::transfer::Transfer::Srgb, &notes)
        .expect("written");
    for own in [&["--own"][..], &[]] {
        let told = biprism(folder.path(), &[&["measure", "a.png", "--scene", "scene.toml"], own].concat());
        let words = text(&told.stderr);
        assert!(told.status.success() && words.contains("note: a.png was written by another version"), "{words}");
        assert!(!words.contains("has another"), "{words}");
    }
}
