//! Does docs/json.md have every key that a verb prints?

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// A scene with effects of every hook, and one that is left out; of few pixels.
const SCENE: &str = "name = \"small\"\neffects = \"auto\"\naccuracy = { target_px = 0.01 }\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 240\n\
    height_px = 135\npixel_pitch_um = 44.0\n[prism]\nkind = \"freeform\"\nindex = 1.48\nridge_distance_mm = 78.472\n\
    thickness_mm = 8.545\n[prism.design]\nstep_px = 4.0\n[board]\ncolumns = 21\nrows = 21\nsquare_mm = 20.0\n\
    position_mm = [0.0, 0.0, 1000.0]\n[analysis]\ndepths_mm = [800.0, 1000.0]\n[effect.cos4]\n\
    [effect.absorption]\nper_mm = 1e-9\n[effect.sensor]\n";

fn page() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/json.md")).expect("the page is there")
}

/// The words between backticks in the part of the page under a heading.
fn documented(page: &str, heading: &str) -> BTreeSet<String> {
    let start = page.find(&format!("\n## {heading}\n")).unwrap_or_else(|| panic!("no part is called {heading:?}"));
    let part = page[start + 4..].split("\n## ").next().expect("a part");
    part.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Every key in a JSON value.
fn keys(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            for (key, inner) in map {
                found.insert(key.clone());
                keys(inner, found);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| keys(item, found)),
        _ => {}
    }
}

#[test]
fn every_key_of_every_verb_stands_on_the_page() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("scene.toml"), SCENE).expect("it is written");
    fs::create_dir(folder.path().join("cases")).expect("a folder");
    fs::write(folder.path().join("cases/small.toml"), SCENE).expect("it is written");
    let run = |args: &str, input: &str, update: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biprism"));
        command.current_dir(folder.path()).args(args.split(' ')).env("UPDATE_GOLDEN", update).env_remove("CI");
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        let _ = child.stdin.take().expect("a pipe").write_all(input.as_bytes());
        let output = child.wait_with_output().expect("it ends");
        assert!(matches!(output.status.code(), Some(0 | 1)), "{args}: {}", String::from_utf8_lossy(&output.stderr));
        let value: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{args}: {error}"));
        let mut found = BTreeSet::new();
        keys(&value, &mut found);
        found
    };
    let page = page();
    let common = documented(&page, "Common to several verbs");
    let mut faults = Vec::new();
    let mut hold = |heading: &str, found: BTreeSet<String>| {
        let own = documented(&page, heading);
        assert!(!found.is_empty(), "{heading} printed no key");
        let missing = found.into_iter().filter(|key| !own.contains(key) && !common.contains(key));
        faults.extend(missing.map(|key| format!("{heading}: {key}")));
    };
    hold("render", run("render scene.toml --out a.exr --out a.png --json", "", "0"));
    hold("check", run("check scene.toml --json", "", "0"));
    hold("trace", run("trace scene.toml --json", "20,30\n200,100\n1e9,1e9\n", "0"));
    hold("trace", run("trace scene.toml --back --json", "left,10,20\nright,1e9,1e9\n", "0"));
    hold("rectify", run("rectify scene.toml --json", "", "0"));
    for format in ["stl", "zemax-grid", "zemax-extended", "optiland", "cameras-yml", "npy"] {
        hold("export", run(&format!("export scene.toml --format {format} --out export --json"), "", "0"));
    }
    hold(
        "dataset",
        run("dataset scene.toml --poses 1 --tilt-deg 0:5 --detect --noise 0:0.01 --out set --json", "", "0"),
    );
    let manifest = fs::read_to_string(folder.path().join("set/manifest.jsonl")).expect("a manifest");
    let mut found = BTreeSet::new();
    for line in manifest.lines() {
        // The keys of its values are those of a scene, and those of its instrument and name are parts of one.
        let mut line: Value = serde_json::from_str(line).expect("JSON");
        ["values", "instrument"].iter().for_each(|own| drop(line.get_mut(own).map(Value::take)));
        keys(&line, &mut found);
    }
    hold("dataset", found);
    let batch = "batch scene.toml --verb render --sweep prism.index=1.48,x --out r.jsonl --json";
    hold("batch and merge", run(batch, "", "0"));
    for line in fs::read_to_string(folder.path().join("r.jsonl")).expect("the lines").lines() {
        // The keys of its figures are those of the verb, and its values have the keys of a scene.
        let mut line: Value = serde_json::from_str(line).expect("JSON");
        ["set", "figures"].iter().for_each(|own| drop(line.get_mut(own).map(Value::take)));
        let mut found = BTreeSet::new();
        keys(&line, &mut found);
        hold("batch and merge", found);
    }
    hold("batch and merge", run("merge r.jsonl --json", "", "0"));
    hold("corners", run("corners a.exr --json", "", "0"));
    hold("corners", run("corners a.exr --out a.csv --json", "", "0"));
    hold("design", run("design scene.toml --json", "", "0"));
    hold("compare and measure", run("compare scene.toml --budget --json", "", "0"));
    hold("compare and measure", run("measure a.exr --scene scene.toml --own --budget --json", "", "0"));
    hold("compare and measure", run("measure a.csv --scene scene.toml --json", "", "0"));
    hold("analyse", run("analyse tolerance scene.toml --criterion vertical_px --budget vertical_px=1 --json", "", "0"));
    let trials = "analyse tolerance scene.toml --criterion vertical_px --trials 4 --budget vertical_px=1 --json";
    hold("analyse", run(trials, "", "0"));
    hold(
        "cost",
        run(
            "cost scene.toml --quick --repetitions 1 --set camera.width_px=120 --set camera.height_px=68 --json",
            "",
            "0",
        ),
    );
    hold("analyse", run("analyse stability --only parallel --json", "", "0"));
    for study in
        ["spot", "field-curvature", "mtf", "reprojection", "surface", "layout", "stereo", "convergence --finest-um 40"]
    {
        hold("analyse", run(&format!("analyse {study} scene.toml --json"), "", "0"));
    }
    hold("analyse", run("analyse paper --finest-um 80 --json", "", "0"));
    hold("golden", run("golden cases --golden none --json", "", "0"));
    hold("corners", run("corners a.exr --scene scene.toml --json", "", "0"));
    hold("golden", run("golden cases --json", "", "1"));
    fs::write(folder.path().join("cases/small.toml"), SCENE.replace("1.48", "1.5")).expect("it is written");
    hold("golden", run("golden cases --json", "", "0"));
    assert!(faults.is_empty(), "docs/json.md lacks {faults:#?}");
}
