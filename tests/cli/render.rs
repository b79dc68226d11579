//! `render` and `check`: plans, levels, refusals.

use crate::command::{as_is, biprism, json, small_scene, text, tiny_scene};
use serde_json::Value;
use std::fs;
use std::path::Path;

#[test]
fn a_target_chooses_the_level_and_says_what_was_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
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
    let stored = Some(biprism::raster::transfer::Transfer::Linear);
    let (picture, _) = biprism::io::read(&folder.path().join("a.png"), stored).expect("a picture");
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
