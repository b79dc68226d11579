//! `analyse stereo`: what is left of the halves as they are, after a warp, after the maps, and after the shift of rows.

use crate::command::{biprism, json, repository, text};
use serde_json::Value;

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} in {row}"))
}

/// Warps were fitted and measured by another program, through corners of its own choice: largest deviations of the flat prism 1.08 px at
/// 600 mm, 0.81 at 2000 mm and 0.16 on a board tilted by 55 deg, and up to a third of that of its root mean squares along x and y.
/// Of the exact prism nothing is left but what polynomials of degree 7 leave, 1e-5 px.
#[test]
fn treatments_leave_what_other_programs_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = repository("scenes/paper.toml");
    let args = ["analyse", "stereo", scene.to_str().expect("a name"), "--json"];
    let found = json(&biprism(folder.path(), &args));
    let rows = found["sheets"]["stereo"]["rows"].as_array().expect("rows");
    let row = |prism: &str, treatment: &str, depth_mm: f64, tilt_deg: f64| {
        let at = |row: &&Value| {
            row["prism"] == prism
                && row["treatment"] == treatment
                && number(row, "depth_mm") == depth_mm
                && (number(row, "tilt_deg") - tilt_deg).abs() < 1e-9
        };
        rows.iter().find(at).unwrap_or_else(|| panic!("{prism} {treatment} {depth_mm} {tilt_deg}"))
    };

    // The rival: right at one depth alone.
    for (prism, depth_mm, tilt_deg, x, y, largest) in [
        ("flat", 600.0, 0.0, 0.217, 0.475, 1.08),
        ("flat", 2000.0, 0.0, 0.162, 0.356, 0.81),
        ("flat", 1000.0, 55.0, 0.028, 0.042, 0.16),
        ("freeform", 600.0, 0.0, 0.0001, 0.0038, 0.011),
        ("freeform", 2000.0, 0.0, 0.0001, 0.0029, 0.008),
    ] {
        let warp = row(prism, "warp", depth_mm, tilt_deg);
        for (key, other) in [("x_rms_px", x), ("y_rms_px", y), ("largest_px", largest)] {
            let own = number(warp, key);
            assert!(own < 1.34 * other && other < 1.34 * own, "{prism} {depth_mm} {tilt_deg} {key}: {own} {other}");
        }
        assert!(number(row(prism, "map", depth_mm, tilt_deg), "largest_px") < largest);
    }

    // As they are the rows of the freeform are those of a pair, and its columns are not: kappa of the rows, 0.77 px a half.
    for depth_mm in [600.0, 1000.0, 2000.0] {
        let raw = row("freeform", "raw", depth_mm, 0.0);
        assert!(number(raw, "vertical_rms_px") < 0.02 && (number(raw, "x_rms_px") - 0.77).abs() < 0.03, "{raw}");
        let shifted = row("exact", "row shift", depth_mm, 0.0);
        assert!(number(shifted, "largest_px") < 1e-4 && number(shifted, "depth_max_percent") < 1e-4, "{shifted}");
        let raw = row("exact", "raw", depth_mm, 0.0);
        assert!(number(raw, "vertical_max_px") < 1e-5 && number(raw, "x_rms_px") > 0.7, "{raw}");
        assert!(number(row("flat", "raw", depth_mm, 0.0), "vertical_rms_px") > 1.0);
    }
    assert!(rows.iter().all(|row| row["treatment"] != "row shift" || row["prism"] == "exact"));
    for name in ["stereo.json", "stereo.csv", "stereo_pairs.csv", "stereo.png", "stereo.svg"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn what_cannot_be_studied_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = repository("scenes/paper.toml");
    let scene = scene.to_str().expect("a name");
    let many = vec!["700"; 65].join(",");
    for (args, rule) in [
        (["--depths-mm", &many], "there are 65 depths, and at most 64"),
        (["--tilt-deg", "90"], "give an angle from -80 to 80"),
        (["--depths-mm", "0"], "give a depth in mm above 0"),
        (["--fit-depth-mm", "30"], "no point 30 mm from the camera is seen by both halves"),
    ] {
        let run = biprism(folder.path(), &[&["analyse", "stereo", scene], &args[..]].concat());
        assert!(run.status.code() == Some(2) && text(&run.stderr).contains(rule), "{rule}: {}", text(&run.stderr));
    }
    assert!(!folder.path().join("out").exists());
}
