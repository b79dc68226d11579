//! `rectify`: the files, what they hold, and what is refused.

use crate::command::{as_is, biprism, json, text, tiny_scene};
use biprism::io::exr;
use biprism::io::exr::ChannelSamples;
use std::fs;
use std::path::Path;

/// A plane of an NPY file, with its rows and columns.
fn plane(path: &Path) -> ([usize; 2], Vec<f32>) {
    let bytes = fs::read(path).expect("written");
    let head = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let dictionary = str::from_utf8(&bytes[10..head]).expect("ASCII");
    assert!(dictionary.contains("'descr': '<f4'") && dictionary.contains("'fortran_order': False"), "{dictionary}");
    let shape = dictionary.split(['(', ')']).nth(1).expect("a shape");
    let size: Vec<usize> = shape.split(", ").map(|n| n.parse().expect("a number")).collect();
    let values = bytes[head..].chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("four"))).collect();
    (size.try_into().expect("two"), values)
}

/// A matrix of OpenCV's YAML.
fn matrix<const M: usize, const N: usize>(yaml: &str, key: &str) -> [[f64; N]; M] {
    let (_, rest) = yaml.split_once(&format!("\n{key}: !!opencv-matrix\n")).unwrap_or_else(|| panic!("no {key}"));
    let field = |name: &str| rest.split_once(name).expect("a field").1.trim_start();
    let count = |name: &str| field(name).lines().next().expect("a line").parse::<usize>().expect("a number");
    assert_eq!([count("rows:"), count("cols:")], [M, N], "{key}");
    let data = field("data: [").split(']').next().expect("an end");
    let values: Vec<f64> = data.split(',').map(|v| v.trim().parse().expect("a number")).collect();
    assert_eq!(values.len(), M * N, "{key}");
    std::array::from_fn(|i| std::array::from_fn(|j| values[N * i + j]))
}

fn times<const M: usize, const N: usize>(a: &[[f64; N]; M], v: [f64; N]) -> [f64; M] {
    std::array::from_fn(|i| (0..N).map(|j| a[i][j] * v[j]).sum())
}

#[test]
fn maps_and_cameras_are_written() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let found = json(&biprism(folder.path(), &["rectify", "scene.toml", "--out", "maps", "--json"]));
    let at = |name: &str| folder.path().join("maps").join(name);
    assert_eq!(json_of(&at("rectify.json")), found);

    // The arrays are the channels of the EXR, of the size of a half, and point into their half of the picture or nowhere.
    let names = ["left.x", "left.y", "right.x", "right.y"];
    let channels = exr::read_channels(&at("maps.exr"), &names).expect("an EXR of these channels");
    for channel in &channels {
        let (size, values) = plane(&at(&format!("{}.npy", channel.name.replace('.', "_"))));
        let ChannelSamples::F32(raster) = &channel.samples else { panic!("f32") };
        assert_eq!((size, &values[..]), ([135, 120], raster.data()), "{}", channel.name);
        let range = match channel.name.as_str() {
            "left.x" => -0.5..119.5,
            "right.x" => 119.5..239.5,
            _ => -0.5..134.5,
        };
        let unseen = values.iter().filter(|v| **v == -1.0).count();
        assert!(values.iter().all(|v| *v == -1.0 || range.contains(v)), "{}", channel.name);
        let half = &found["halves"][channel.name.split('.').next().expect("a half")];
        assert_eq!(half["seen_px"].as_u64().expect("a count") as usize, values.len() - unseen);
        assert!(unseen < values.len() / 10, "{unseen} of {} not seen", channel.name);
    }

    // A point seen through P1 and P2 has one row, and Q takes its disparity back to it.
    let yaml = fs::read_to_string(at("stereo.yml")).expect("written");
    let (p1, p2): ([[f64; 4]; 3], [[f64; 4]; 3]) = (matrix(&yaml, "P1"), matrix(&yaml, "P2"));
    let (r, t): ([[f64; 3]; 3], [[f64; 1]; 3]) = (matrix(&yaml, "R"), matrix(&yaml, "T"));
    let (m1, m2): ([[f64; 3]; 3], [[f64; 3]; 3]) = (matrix(&yaml, "M1"), matrix(&yaml, "M2"));
    let q: [[f64; 4]; 4] = matrix(&yaml, "Q");
    for key in ["D1", "D2"] {
        assert_eq!(matrix::<1, 5>(&yaml, key), [[0.0; 5]]);
    }
    for point in [[10.0, -20.0, 700.0], [-30.0, 5.0, 1500.0]] {
        let [x, y, z] = point;
        let seen = |v: [f64; 3]| [v[0] / v[2], v[1] / v[2]];
        let moved = times(&r, point);
        let pair = [seen(times(&m1, point)), seen(times(&m2, [0, 1, 2].map(|k| moved[k] + t[k][0])))];
        for (by, p) in pair.iter().zip([p1, p2]) {
            let projected = seen(times(&p, [x, y, z, 1.0]));
            assert!((0..2).all(|k| (projected[k] - by[k]).abs() < 1e-9), "{projected:?} {by:?}");
        }
        assert!((pair[0][1] - pair[1][1]).abs() < 1e-9);
        let back = times(&q, [pair[0][0], pair[0][1], pair[0][0] - pair[1][0], 1.0]);
        assert!((0..3).all(|k| (back[k] / back[3] - point[k]).abs() < 1e-8), "{back:?}");
    }
    assert!((t[0][0] + found["baseline_mm"].as_f64().expect("a number")).abs() < 1e-12);

    // The cameras are in the world where the JSON says.
    let (turn, shift): ([[f64; 3]; 3], [[f64; 1]; 3]) = (matrix(&yaml, "R_left"), matrix(&yaml, "T_left"));
    let centre: [f64; 3] = std::array::from_fn(|k| found["halves"]["left"]["centre_mm"][k].as_f64().expect("a number"));
    let moved = times(&turn, centre);
    assert!((0..3).all(|k| (moved[k] + shift[k][0]).abs() < 1e-9));
}

fn json_of(path: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(path).expect("written")).expect("JSON")
}

#[test]
fn depths_are_those_that_are_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), |text| {
        let flat = text.replace("kind = \"freeform\"", "kind = \"flat\"");
        flat.replace("[prism.design]\norder = \"x-then-y\"\ndegree = 5", "")
    });
    let args = ["rectify", "scene.toml", "--depth-mm", "700", "--residuals-at-mm", "700,50,5000", "--json"];
    let found = json(&biprism(folder.path(), &args));
    assert_eq!((&found["map_depth_mm"], &found["exact"]), (&700.0.into(), &false.into()));
    let rows = found["residuals"].as_array().expect("rows");
    let depths: Vec<Option<f64>> = rows.iter().map(|row| row["depth_mm"].as_f64()).collect();
    assert_eq!(depths, [Some(700.0), Some(50.0), Some(5000.0), None]);
    let largest = |k: usize| rows[k]["deviation_max_px"].as_f64().expect("a number");
    assert!(largest(0) < 1e-9 && largest(2) > 0.01 && largest(3) > largest(2), "{rows:#?}");
    // 50 mm from the camera is before the prism.
    assert!(rows[1]["pairs"] == 0 && rows[1]["vertical_max_px"].is_null(), "{}", rows[1]);
}

#[test]
fn what_cannot_be_rectified_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let refused = |change: &dyn Fn(String) -> String, more: &[&str], words: &[&str]| {
        tiny_scene(folder.path(), change);
        let args = [&["rectify", "scene.toml", "--out", "none"], more].concat();
        let done = biprism(folder.path(), &args);
        let told = text(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{told}");
        assert!(words.iter().all(|word| told.contains(word)), "{told}");
        assert!(!folder.path().join("none").exists());
    };
    let no_prism = |text: String| {
        let (camera, rest) = text.split_once("[prism]").expect("a prism");
        format!("{camera}[prism]\nkind = \"none\"\n{}", &rest[rest.find("[board]").expect("a board")..])
    };
    refused(&no_prism, &[], &["scene.toml: prism", "there is no prism"]);
    let telecentric = |text: String| format!("{text}\n[effect.telecentric]\nmagnification = 0.1\nfocus_mm = 1000.0\n");
    refused(&telecentric, &[], &["scene.toml: camera", "telecentric"]);
    refused(&as_is, &["--depth-mm", "80"], &["scene.toml: prism", "no point 80 mm", "both halves", "--depth-mm"]);
    for bad in ["0", "-5", "nan", "1e7", "near"] {
        refused(&as_is, &[&format!("--depth-mm={bad}")], &["--depth-mm", "as in 1000"]);
    }
}
