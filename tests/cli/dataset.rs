//! `dataset`: whether its pictures are those of their scenes, whether a run that was stopped goes on, and what is refused.

use crate::command::{as_is, biprism, json, quarter, text, tiny_scene};
use biprism::io::{CurveSource, corners, read};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// What `biprism dataset scene.toml` does with more arguments.
fn dataset(folder: &Path, args: &str) -> std::process::Output {
    let all: Vec<&str> = ["dataset", "scene.toml"].into_iter().chain(args.split(' ')).collect();
    biprism(folder, &all)
}

/// The files of a folder, by name.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entry = |entry: std::io::Result<fs::DirEntry>| {
        let path = entry.expect("an entry").path();
        (path.file_name().expect("a name").to_string_lossy().into_owned(), fs::read(&path).expect("a file"))
    };
    fs::read_dir(folder).expect("a folder").map(entry).collect()
}

fn same(a: &Path, b: &Path) {
    let (a, b) = (contents(a), contents(b));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    let other: Vec<&String> = a.iter().filter(|(name, bytes)| b[*name] != **bytes).map(|(name, _)| name).collect();
    assert!(other.is_empty(), "{other:?} differ");
}

/// The lines of a manifest: its head, and a line a picture.
fn manifest(folder: &Path) -> (Value, Vec<Value>) {
    let all = fs::read_to_string(folder.join("manifest.jsonl")).expect("a manifest");
    let mut lines = all.lines().map(|line| serde_json::from_str(line).expect("JSON"));
    (lines.next().expect("a head"), lines.collect())
}

/// Every level of a picture.
fn levels(path: &Path) -> Vec<f32> {
    read(path, CurveSource::FileOrStored).expect("a picture").0.data().to_vec()
}

/// The picture of each pose, bit for bit, is that of its scene: plain; in another light with a look and noise of its own; with effects
/// that a scene keeps or leaves out by itself.
#[test]
fn a_picture_is_that_of_its_scene() {
    let sensor = "\n[effect.sensor]\nwhite_e = 5000\nseed = 3\n";
    let auto = |scene: String| format!("effects = \"auto\"\n{scene}\n[effect.cos4]\n{sensor}");
    let cases: [(&str, &dyn Fn(String) -> String); 3] = [
        ("", &as_is),
        (" --texture squares,noise,chart --noise 0.01:0.02 --exposure 0.3:1.4", &quarter),
        (" --noise 0.01", &auto),
    ];
    for (args, change) in cases {
        let folder = tempfile::tempdir().expect("a folder");
        tiny_scene(folder.path(), change);
        let found = json(&dataset(folder.path(), &format!("--poses 3 --out set --json{args}")));
        assert_eq!((found["poses"].as_u64(), found["made"].as_u64()), (Some(3), Some(3)));
        for k in 0..3 {
            let scene = format!("set/00000{k}.toml");
            json(&biprism(folder.path(), &["render", &scene, "--out", "own.png", "--json"]));
            let [set, own] =
                [format!("set/00000{k}.png"), "own.png".to_owned()].map(|n| levels(&folder.path().join(n)));
            assert!(set == own, "{scene} {args}");
            assert!(set.iter().any(|v| *v > 0.1), "{scene} is dark");
        }
    }
}

/// With `--halves` the two halves of the same picture, with their truth as `render --stereo` has it.
#[test]
fn halves_and_truth_are_those_of_render() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let at = |name: &str| folder.path().join(name);
    json(&dataset(folder.path(), "--poses 1 --out set --halves --truth --json"));
    let render =
        ["render", "set/000000.toml", "--halves", "--stereo", "--out", "own.png", "--out", "own.exr", "--json"];
    json(&biprism(folder.path(), &render));
    for half in ["left", "right"] {
        let [set, own] = ["set/000000", "own"].map(|name| levels(&at(&format!("{name}_{half}.png"))));
        assert!(set == own, "{half}");
        let [set, own] = ["set/000000", "own"].map(|name| fs::read(at(&format!("{name}_{half}.exr"))).expect("an EXR"));
        assert!(set == own, "the truth of {half}");
    }
}

/// Pictures depend on seed and number alone: not on how many are made, in how many runs, or by how many threads.
#[test]
fn a_picture_does_not_depend_on_the_others() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let at = |name: &str| folder.path().join(name);
    let by_threads = |threads: &str, out: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biprism"));
        command.current_dir(folder.path()).env("RAYON_NUM_THREADS", threads);
        let args = ["dataset", "scene.toml", "--poses", "5", "--noise", "0:0.02", "--out", out];
        assert!(command.args(args).stderr(Stdio::null()).stdout(Stdio::null()).status().expect("it runs").success());
    };
    by_threads("1", "one");
    by_threads("3", "three");
    same(&at("one"), &at("three"));
    for poses in [2, 5] {
        let found = json(&dataset(folder.path(), &format!("--poses {poses} --noise 0:0.02 --out steps --json")));
        assert_eq!(found["poses"].as_u64(), Some(poses));
    }
    same(&at("one"), &at("steps"));

    // Another seed draws others, and no two pictures are alike.
    let (_, lines) = manifest(&at("one"));
    json(&dataset(folder.path(), "--poses 5 --noise 0:0.02 --seed 2 --out other --json"));
    let (_, others) = manifest(&at("other"));
    let places: Vec<String> =
        lines.iter().chain(&others).map(|line| line["values"]["board.position_mm"].to_string()).collect();
    assert!((0..10).all(|i| (0..i).all(|j| places[i] != places[j])), "{places:?}");
    let frames: Vec<&Value> = lines.iter().chain(&others).map(|line| &line["values"]["effect.sensor.frame"]).collect();
    assert!((0..10).all(|i| frames[i].is_u64() && (0..i).all(|j| frames[i] != frames[j])), "{frames:?}");
    // Fewer than there are is no loss.
    let fewer = dataset(folder.path(), "--poses 1 --noise 0:0.02 --out one");
    assert!(text(&fewer.stderr).contains("already has 5 pictures"), "{}", text(&fewer.stderr));
    same(&at("one"), &at("three"));
}

/// The true corners are where `trace --back` puts them, and the detector finds them there.
#[test]
fn corners_are_the_true_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    json(&dataset(folder.path(), "--poses 2 --distance-mm 900:1100 --tilt-deg 10:20 --detect --out set --json"));
    for k in 0..2 {
        let at = |what: &str| folder.path().join(format!("set/00000{k}_{what}.csv"));
        let [exact, found] =
            [corners::read(&at("corners")), corners::read(&at("detected"))].map(|f| f.expect("corners"));
        let mut nearby = 0;
        for (exact, found) in exact.iter().zip(&found) {
            assert_eq!(exact.name, found.name);
            assert!(exact.index_origin == Some(corners::IndexOrigin::Board) && exact.corners.len() > 10);
            // Ask the inverse trace, by places on the board of 21 x 21 squares of 20 mm.
            let asked: Vec<String> = (exact.corners.iter())
                .map(|c| c.index.map(|n| f64::from(n - 9) * 20.0 - 10.0))
                .map(|[u, v]| format!("{},{u},{v}\n", exact.name))
                .collect();
            fs::write(folder.path().join("asked.csv"), asked.concat()).expect("written");
            let scene = format!("set/00000{k}.toml");
            let traced = biprism(folder.path(), &["trace", &scene, "--back", "--points", "asked.csv", "--json"]);
            let traced = json(&traced);
            for (corner, answer) in exact.corners.iter().zip(traced.as_array().expect("a list")) {
                let px = [0, 1].map(|k| answer["pixel_px"][k].as_f64().expect("a position"));
                // The last Newton step of the exact level's aim, many times over.
                assert!(corner.position_px.distance(px.into()) < 1e-6 && answer["seen"] == true, "{answer}");
            }
            let by_index: BTreeMap<[i32; 2], _> = exact.corners.iter().map(|c| (c.index, c.position_px)).collect();
            for corner in &found.corners {
                // 0.01 px is what the detector is held to in plain pictures; those at the rim of so small a one may be worse.
                let off = corner.position_px.distance(by_index[&corner.index]);
                assert!(off < 0.1, "{off} px at {:?}", corner.index);
                nearby += 1;
            }
        }
        assert!(nearby > 20, "{nearby} corners found");
    }
}

/// A line that was cut off, a file that is gone and files without a line are made again as they were; and so after a kill at any moment.
#[test]
fn a_stopped_run_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let at = |name: &str| folder.path().join(name);
    let run = |out: &str| json(&dataset(folder.path(), &format!("--poses 12 --out {out} --json")));
    run("whole");

    // Cut its last line but one in the middle, and take away a file of an earlier one.
    run("cut");
    let path = at("cut/manifest.jsonl");
    let lines = fs::read_to_string(&path).expect("a manifest");
    let from_last = lines.trim_end().rfind('\n').expect("lines");
    let cut = lines[..from_last].rfind('\n').expect("lines") + 30;
    fs::write(&path, &lines[..cut]).expect("written");
    fs::remove_file(at("cut/000004.png")).expect("it was there");
    let again = run("cut");
    assert_eq!((again["poses"].as_u64(), again["made"].as_u64()), (Some(12), Some(3)), "{again}");
    same(&at("whole"), &at("cut"));
    let nothing = run("cut");
    assert_eq!((nothing["poses"].as_u64(), nothing["made"].as_u64()), (Some(12), Some(0)));

    // Kill it when some pictures are there.
    let mut child = Command::new(env!("CARGO_BIN_EXE_biprism"))
        .current_dir(folder.path())
        .args(["dataset", "scene.toml", "--poses", "12", "--out", "killed"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it runs");
    let there = || fs::read_to_string(at("killed/manifest.jsonl")).is_ok_and(|text| text.lines().count() > 2);
    while !there() && child.try_wait().expect("a child").is_none() {
        std::thread::yield_now();
    }
    child.kill().expect("it is ours");
    child.wait().expect("it ends");
    run("killed");
    same(&at("whole"), &at("killed"));
}

/// A folder is of one set: what belongs to another is refused with the key that differs, and stays as it is.
#[test]
fn another_set_does_not_go_into_the_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let set = folder.path().join("set");
    json(&dataset(folder.path(), "--poses 1 --out set --json"));
    let before = contents(&set);
    let refused = |args: &str, key: &str| {
        let output = dataset(folder.path(), &format!("--poses 2 --out set {args}"));
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains(&format!("`{key}`")) && told.contains("--out"), "{told}");
        assert!(contents(&set) == before, "{args}");
    };
    refused("--seed 2", "seed");
    refused("--tilt-deg 0:10", "places");
    refused("--exposure 1:2", "exposure");
    refused("--halves", "files");
    tiny_scene(folder.path(), |scene| scene.replace("index = 1.48", "index = 1.49"));
    refused("--seed 1", "instrument");
}

/// The places of a file are taken as they are; a longer file adds to the folder, and one with another place is refused.
#[test]
fn places_come_from_a_file() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let places = |lines: &[&str]| {
        let head = "x_mm,y_mm,z_mm,tilt_x_deg,tilt_y_deg,tilt_z_deg\n# said\n";
        fs::write(folder.path().join("places.csv"), format!("{head}{}\n", lines.join("\n"))).expect("written");
        dataset(folder.path(), "--pose-file places.csv --out set --json")
    };
    let [first, second] = ["1.5,-2,1000,0,0,0", "0,0.1,1200.25,5,-10,90"];
    json(&places(&[first]));
    let found = json(&places(&[first, second]));
    assert_eq!((found["poses"].as_u64(), found["made"].as_u64()), (Some(2), Some(1)));
    let (head, lines) = manifest(&folder.path().join("set"));
    assert_eq!(head["places"], "listed");
    assert_eq!(lines[1]["values"]["board.position_mm"], serde_json::json!([0.0, 0.1, 1200.25]));
    assert_eq!(lines[1]["values"]["board.tilt_deg"], serde_json::json!([5.0, -10.0, 90.0]));
    let told = |output: std::process::Output, words: &[&str]| {
        let told = text(&output.stderr);
        assert!(output.status.code() == Some(2) && words.iter().all(|word| told.contains(word)), "{told}");
    };
    told(places(&[second, first]), &["manifest.jsonl:2", "file of places"]);
    told(places(&[first, "1,2,3"]), &["places.csv:4", "3 fields"]);
    told(places(&[first, "1,2,x,0,0,0"]), &["places.csv:4", "`z_mm`"]);
    told(places(&[]), &["no place"]);
    told(places(&[first, second, "0,0,-5,0,0,0"]), &["pose 2", "board.position_mm"]);
    told(dataset(folder.path(), "--pose-file places.csv --tilt-deg 3 --out set"), &["--tilt-deg"]);
}

/// With `--in-view whole` both halves of every picture show all inner corners of the board.
#[test]
fn boards_are_seen_whole_where_that_is_asked() {
    let folder = tempfile::tempdir().expect("a folder");
    let board = |scene: String| {
        scene.replace("columns = 21\nrows = 21\nsquare_mm = 20.0", "columns = 5\nrows = 4\nsquare_mm = 16")
    };
    tiny_scene(folder.path(), board);
    let found = json(&dataset(folder.path(), "--poses 6 --in-view whole --roll-deg -180:180 --out set --json"));
    for half in ["left", "right"] {
        assert_eq!(found["corners"][half], serde_json::json!({ "least": 12, "most": 12 }));
    }
    let (_, lines) = manifest(&folder.path().join("set"));
    for line in lines {
        let within = |key: &str, low: f64, high: f64| (low..=high).contains(&line[key].as_f64().expect("a number"));
        assert!(within("distance_mm", 700.0, 1500.0) && within("tilt_deg", 0.0, 40.0), "{line}");
        assert!(within("roll_deg", -180.0, 180.0) && line["texture"] == "scene", "{line}");
    }
    // A board that is larger than what the halves see is told, with what to do.
    let large = dataset(folder.path(), "--poses 1 --in-view whole --distance-mm 200:210 --out near");
    let told = text(&large.stderr);
    assert!(large.status.code() == Some(2) && told.contains("pose 0") && told.contains("--in-view centre"), "{told}");
}

/// `cameras.yml` is the designed pair: its baseline is that of the summary and of the distance of the centres.
#[test]
fn cameras_are_the_designed_pair() {
    let folder = tempfile::tempdir().expect("a folder");
    let exact = |scene: String| {
        scene
            .replace("[prism.design]", "[prism.design]\nobjective = \"epipolar\"\nrear = \"even\"")
            .replace("order = \"x-then-y\"\ndegree = 5", "degree = 7")
    };
    tiny_scene(folder.path(), exact);
    let found = json(&dataset(folder.path(), "--poses 1 --distance-mm 600:2000 --out set --json"));
    let yaml = fs::read_to_string(folder.path().join("set/cameras.yml")).expect("written");
    let values = |key: &str| -> Vec<f64> {
        let (_, rest) = yaml.split_once(&format!("\n{key}: !!opencv-matrix\n")).unwrap_or_else(|| panic!("no {key}"));
        let data = rest.split_once("data: [").expect("data").1.split(']').next().expect("an end");
        data.split(',').map(|v| v.trim().parse().expect("a number")).collect()
    };
    let baseline_mm = found["baseline_mm"].as_f64().expect("a number");
    let t = values("T");
    assert!((t.iter().map(|v| v * v).sum::<f64>().sqrt() - baseline_mm).abs() < 1e-12 && t[0] < 0.0, "{t:?}");
    // Parallel cameras beside one another, each in the world at half the baseline.
    assert_eq!(values("R"), [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    assert!((values("T_left")[0] - 0.5 * baseline_mm).abs() < 1e-12);
    // The exact prism is a pinhole but for its rows: 0.8 px of 5.5 um at the corners, an eighth of it here; and 1e-4 px when they
    // are shifted back, which is what polynomials of degree 7 leave, ten times over.
    for row in found["deviation"].as_array().expect("rows") {
        for half in ["left", "right"] {
            let most = |which: &str| row[which][half]["max_px"].as_f64().expect("a number");
            assert!(most("raw") > 0.05 && most("rows_shifted_back") < 1e-4, "{row}");
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), |scene| format!("effects = \"none\"\n{scene}"));
    for (args, words) in [
        ("--out set", "--poses"),
        ("--poses 0 --out set", "--poses"),
        ("--poses 1000001 --out set", "1000000"),
        ("--poses 1 --distance-mm 1500:500 --out set", "500:1500"),
        ("--poses 1 --tilt-deg 0:90 --out set", "85"),
        ("--poses 1 --noise 0.1 --out set", "effects = \"none\""),
        ("--poses 1 --detect --texture noise --out set", "--texture squares"),
        ("--poses 1 --exposure 1:1e9 --out set", "1000"),
        ("--poses 1 --distance-mm 10:20 --out set", "give other distances"),
    ] {
        let output = dataset(folder.path(), args);
        let told = text(&output.stderr);
        assert!(output.status.code() == Some(2) && told.contains(words), "{args}: {told}");
        let pictures = fs::read_dir(folder.path().join("set")).map_or(0, |all| {
            all.filter(|entry| entry.as_ref().expect("an entry").path().extension().is_some_and(|e| e == "png")).count()
        });
        assert_eq!(pictures, 0, "{args}");
    }
}
