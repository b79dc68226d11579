//! `analyse tolerance` and `merge` through the command.

use crate::command::{as_is, biprism, json, small_scene, text};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Trials of the small scene into `out`.
fn trials(folder: &Path, out: &str, more: &[&str]) -> std::process::Output {
    let args = ["analyse", "tolerance", "scene.toml", "--criterion", "vertical_px", "--trials", "60", "--out", out];
    biprism(folder, &[&args, more].concat())
}

/// Every file of a folder by name, with what is in it.
/// The files of a folder, but for the page, which names its command.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found: Vec<_> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_none_or(|ending| ending != "html"))
        .map(|path| (path.file_name().expect("a name").to_string_lossy().into_owned(), fs::read(&path).expect("bytes")))
        .collect();
    found.sort();
    found
}

#[test]
fn parts_make_exactly_the_whole_and_a_stopped_run_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    small_scene(at, as_is);
    let budget = ["--budget", "vertical_px=0.3"];
    assert!(trials(at, "whole", &budget).status.success());
    for part in ["2/3", "3/3", "1/3"] {
        assert!(trials(at, "parts", &["--shard", part]).status.success());
    }
    let parts = [1, 2, 3].map(|i| format!("parts/tolerance_trials_{i}_of_3.jsonl"));
    let [a, b, c] = parts.each_ref().map(String::as_str);
    let merged = biprism(at, &["merge", c, a, b, "--out", "merged", budget[0], budget[1]]);
    assert!(merged.status.success(), "{}", text(&merged.stderr));
    let whole = contents(&at.join("whole"));
    assert!(whole == contents(&at.join("merged")), "the parts give other files than the whole");

    // Cut the file within a line: what is there is kept, and the rest is made.
    let file = at.join("whole/tolerance_trials.jsonl");
    let bytes = fs::read(&file).expect("bytes");
    fs::write(&file, &bytes[..2 * bytes.len() / 3]).expect("it is written");
    let again = trials(at, "whole", &budget);
    assert!(text(&again.stderr).contains("goes on after"), "{}", text(&again.stderr));
    assert!(whole == contents(&at.join("whole")));

    // What does not belong together is refused, each with its cause.
    for (args, cause) in [
        (vec![a, b], "is in no file"),
        (vec![a, b, c, b], "as well"),
        (vec!["scene.toml"], "no run of trials"),
        (vec!["absent.jsonl"], "cannot be read"),
    ] {
        let refused = biprism(at, &[&["merge", "--out", "never"], &args[..]].concat());
        let told = text(&refused.stderr);
        assert!(refused.status.code() == Some(2) && told.contains(cause), "{args:?}: {told}");
    }
    let other = trials(at, "whole", &["--seed", "2"]);
    assert!(other.status.code() == Some(2) && text(&other.stderr).contains("`seed`"), "{}", text(&other.stderr));
    assert!(!at.join("never").exists());
}

#[test]
fn sensitivities_come_as_tables_and_tornado_charts() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let args =
        ["analyse", "tolerance", "scene.toml", "--criterion", "vertical_px", "--criterion", "pinhole_px", "--json"];
    let found = json(&biprism(folder.path(), &[&args[..], &["--budget", "vertical_px=5"]].concat()));
    let rows = found["sheets"]["worse"]["rows"].as_array().expect("rows");
    let of = |prism: &str, error: &str| -> &Value {
        rows.iter().find(|row| row["prism"] == prism && row["error"] == error).unwrap_or_else(|| panic!("{error}"))
    };
    // A rolled prism tilts the line between the two views; a shift along y moves both alike before flat glass.
    let vertical = |row: &Value| row["vertical_px"].as_f64().expect("a figure");
    assert!(vertical(of("freeform", "prism roll")) > vertical(of("freeform", "none")));
    assert!((vertical(of("flat", "TEDY 1-2")) - vertical(of("flat", "none"))).abs() < 1e-9);
    assert!(rows.iter().all(|row| row["prism"] != "flat" || row["error"] != "TFRN 1"));
    assert!(found["sheets"]["inverse"]["rows"].as_array().is_some_and(|rows| rows.len() == 30));
    for name in ["tolerance.json", "tolerance_vertical_px.png", "tolerance_pinhole_px.svg", "inverse.csv"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
    for (more, cause) in [
        (["--operand", "TEDX 9=1"], "no error is called"),
        (["--criterion", "sharpness"], "no criterion is called"),
        (["--shard", "4/3"], "as in 2/8"),
        (["--trials", "2000000"], "1000000"),
    ] {
        let refused = biprism(folder.path(), &[&args[..], &more[..]].concat());
        let told = text(&refused.stderr);
        assert!(refused.status.code() == Some(2) && told.contains(cause), "{more:?}: {told}");
    }
}
