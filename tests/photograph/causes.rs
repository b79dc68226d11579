//! Why nothing was judged: each cause by its own name, with exit code 1.

use super::{FLAT, built, text};
use crate::command::biprism;
use biprism::render::render;
use serde_json::Value;
use std::fs;

const POSE: &str = "position_mm = [0.0, 0.0, 1000.0]\n";

/// A folder with the picture of a scene.
fn pictured(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, system) = built(text);
    let written = biprism::report::picture::write(&folder.path().join("a.png"), &scene, &system, &render(&system, &()));
    written.unwrap_or_else(|problem| panic!("{problem}"));
    folder
}

/// Cause and sentence when that picture is measured with a scene.
fn cause(folder: &tempfile::TempDir, scene: &str) -> (String, String) {
    fs::write(folder.path().join("scene.toml"), scene).expect("written");
    let told = biprism(folder.path(), &["measure", "a.png", "--scene", "scene.toml", "--json"]);
    assert_eq!(told.status.code(), Some(1), "{}", String::from_utf8_lossy(&told.stderr));
    let report: Value = serde_json::from_slice(&told.stdout).expect("JSON");
    let design = &report["designs"][0];
    let word = |key: &str| design[key].as_str().unwrap_or_else(|| panic!("no {key}: {design}")).to_owned();
    (word("not_judged_cause"), word("not_judged"))
}

#[test]
fn every_cause_has_its_name() {
    let board = |text: &str| format!("{text}square_mm = 20.0\n");
    let large = board("columns = 21\nrows = 21\n");
    let fit = format!("{POSE}pose = \"fit\"\n");
    let own = |board: &str, pose: &str| {
        let scene = text(FLAT, board, pose);
        cause(&pictured(&scene), &scene)
    };
    let same = format!("{large}black = 0.5\nwhite = 0.5\n");
    assert_eq!(own(&same, POSE).0, "no-contrast");
    let aside = "position_mm = [2000.0, 0.0, 1000.0]\n";
    assert_eq!(own(&large, aside).0, "board-outside");
    let blank = pictured(&text(FLAT, &large, aside));
    // Where the scene does not know where the board is, it cannot say so, nor where it says that there is one.
    assert_eq!(cause(&blank, &text(FLAT, &large, &format!("{aside}pose = \"fit\"\n"))).0, "none-in-either");
    assert_eq!(cause(&blank, &text(FLAT, &large, POSE)).0, "none-in-either");
    assert_eq!(own("columns = 31\nrows = 31\nsquare_mm = 1.0\n", POSE).0, "squares-too-small");
    // Two columns of corners in the right half.
    let (name, words) = own(&large, "position_mm = [-225.0, 0.0, 1000.0]\n");
    assert_eq!(name, "too-few-corners", "{words}");
    assert!(words.contains("right"), "{words}");
    // A board that ends between the halves.
    let (name, words) = own(&large, "position_mm = [-265.0, 0.0, 1000.0]\n");
    assert!(name == "board-outside" && words.contains("right"), "{name}: {words}");
    // With a prism that parts the views, each half sees its own part.
    let apart = FLAT.replace("thickness_mm = 8.545", "thickness_mm = 8.545\nfacet_angle_deg = 0.5");
    let picture = pictured(&text(&apart, &large, POSE));
    for pose in [POSE, &fit, "position_mm = [3.0, 5.0, 1040.0]\n"] {
        assert_eq!(cause(&picture, &text(&apart, &large, pose)).0, "nothing-in-common", "{pose}");
    }
}

/// A prism so far from its true place that it parts the views by most of a square more puts one half's corners between those
/// of the other.
#[test]
fn a_match_between_two_shifts_is_refused() {
    let large = "columns = 21\nrows = 21\nsquare_mm = 20.0\n";
    let picture = pictured(&text(FLAT, large, POSE));
    let (name, words) = cause(&picture, &text(&FLAT.replace("78.472", "190.0"), large, POSE));
    assert_eq!(name, "not-matched", "{words}");
    assert!(words.contains("squares beside"), "{words}");
}
