//! `batch` and `merge`: lines, restarts, parts, errors as data, and a program that is killed.

use crate::command::{as_is, biprism, json, small_scene, text, tiny_scene, with_input};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Where rays go, of the quickest verb.
const QUICK: [&str; 4] = ["batch", "scene.toml", "--verb", "render"];

fn batch(folder: &Path, more: &[&str]) -> Value {
    json(&biprism(folder, &[&QUICK, more, &["--json"]].concat()))
}

/// The lines of a file without their times.
fn lines(folder: &Path, name: &str) -> Vec<Value> {
    let whole = fs::read_to_string(folder.join(name)).expect("the file");
    assert!(whole.ends_with('\n'), "{name} ends with a whole line");
    let line = |line: &str| {
        let mut value: Value = serde_json::from_str(line).expect("JSON");
        assert!(value["seconds"].take().as_f64().is_some_and(|s| s >= 0.0), "{line}");
        value
    };
    whole.lines().map(line).collect()
}

/// The picture of a job is that of the verb by itself, and only the verb `render` has one.
#[test]
fn pictures_are_those_of_the_verb() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let sweep = ["--sweep", "board.square_mm=20,18"];
    batch(folder.path(), &[&sweep[..], &["--pictures", "made", "--out", "a.jsonl"]].concat());
    let names: std::collections::BTreeSet<String> = fs::read_dir(folder.path().join("made"))
        .expect("the folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(names.into_iter().collect::<Vec<_>>(), ["000000.png", "000001.png", "run.txt"]);
    let one = ["render", "scene.toml", "--set", "board.square_mm=18", "--out", "one.png"];
    assert!(biprism(folder.path(), &one).status.success());
    let [own, alone] =
        ["made/000001.png", "one.png"].map(|name| fs::read(folder.path().join(name)).expect("a picture"));
    assert!(own == alone, "the picture of a job has other bytes than the verb's");
    // A folder holds the pictures of one run; of jobs that are done none is made again.
    refused(
        folder.path(),
        &[&QUICK[..], &["--pictures", "made", "--out", "b.jsonl"]].concat(),
        &["made", "another run"],
    );
    fs::remove_file(folder.path().join("made/000001.png")).expect("removed");
    let again = biprism(folder.path(), &[&QUICK[..], &sweep, &["--pictures", "made", "--out", "a.jsonl"]].concat());
    assert!(text(&again.stderr).contains("1 jobs that are done have no picture"), "{}", text(&again.stderr));
    fs::create_dir(folder.path().join("own")).expect("a folder");
    fs::write(folder.path().join("own/000000.png"), "my own").expect("written");
    refused(
        folder.path(),
        &[&QUICK[..], &["--pictures", "own", "--out", "b.jsonl"]].concat(),
        &["000000.png", "none of this run"],
    );
    // A picture that cannot be written ends the run, and is no line.
    fs::create_dir_all(folder.path().join("full/000000.png/in the way")).expect("a folder");
    fs::write(folder.path().join("full/run.txt"), fs::read(folder.path().join("made/run.txt")).expect("the run"))
        .expect("written");
    let full = [&QUICK[..], &sweep, &["--pictures", "full", "--threads", "1", "--out", "full.jsonl"]].concat();
    refused(folder.path(), &full, &["full/000000.png"]);
    assert_eq!(fs::read(folder.path().join("full.jsonl")).expect("the file"), b"");
    let other = ["batch", "scene.toml", "--verb", "design", "--pictures", "made"];
    refused(folder.path(), &other, &["--pictures", "the verb is design"]);
}

fn refused(folder: &Path, args: &[&str], words: &[&str]) {
    let out = biprism(folder, args);
    assert_eq!(out.status.code(), Some(2), "{args:?}");
    let told = text(&out.stderr);
    assert!(words.iter().all(|word| told.contains(word)), "{args:?}: {told}");
}

/// The lines are in the order of the jobs and the same for any number of threads, and each is what the verb says by itself.
#[test]
fn a_line_a_job_whatever_the_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let sweeps = ["--sweep", "prism.index=1.46:1.5:3", "--sweep", "board.square_mm=20,18", "--set", "name=swept"];
    let mut first: Option<Vec<Value>> = None;
    for threads in ["1", "2", "5"] {
        let out = format!("{threads}.jsonl");
        let told = batch(folder.path(), &[&sweeps[..], &["--threads", threads, "--out", &out]].concat());
        // Designs that jobs share are made once: of two boards one.
        assert_eq!((&told["made"], &told["designs"], &told["errors"]), (&json!(6), &json!(3), &json!(0)), "{told}");
        let found = lines(folder.path(), &out);
        assert!(first.get_or_insert_with(|| found.clone()) == &found, "{threads} threads");
    }
    let found = first.expect("lines");
    let sets: Vec<&Value> = found.iter().map(|line| &line["set"]).collect();
    let index = |k: usize| sets[k]["prism.index"].as_f64().expect("a number");
    assert_eq!([0, 1, 2, 3, 4, 5].map(index), [1.46, 1.46, 1.48, 1.48, 1.5, 1.5], "the last sweep changes first");
    assert_eq!([0, 1].map(|k| sets[k]["board.square_mm"].as_f64()), [Some(20.0), Some(18.0)]);
    assert!(
        found.iter().enumerate().all(|(k, line)| line["job"] == k && line["jobs"] == 6 && line["scene"] == "swept")
    );
    let set = ["--set", "prism.index=1.5", "--set", "board.square_mm=18"];
    let alone =
        json(&biprism(folder.path(), &[&["render", "scene.toml", "--out", "a.png", "--json"], &set[..]].concat()));
    assert_eq!(found[5]["figures"]["counts/rays"], alone["counts"]["rays"]);
    assert_eq!(found[5]["figures"]["fates/missed"], alone["fates"]["missed"]);
    assert_eq!(found[5]["figures"]["accuracy/achieved_px"], alone["accuracy"]["achieved_px"]);
}

/// Every verb has its figures, with the values that it has by itself.
#[test]
fn figures_are_those_of_the_verb() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let figures = |verb: &str, more: &[&str]| {
        let args = [&["batch", "scene.toml", "--verb", verb, "--out", "one.jsonl"], more].concat();
        let out = biprism(folder.path(), &args);
        assert!(out.status.success(), "{verb}: {}", text(&out.stderr));
        let found = lines(folder.path(), "one.jsonl").remove(0)["figures"].take();
        fs::remove_file(folder.path().join("one.jsonl")).expect("removed");
        found
    };
    let alone = |args: &[&str]| json(&biprism(folder.path(), &[args, &["--json"]].concat()));
    let report = alone(&["compare", "scene.toml", "--pictures", "none"]);
    let compared = figures("compare", &[]);
    for (k, name) in ["flat", "freeform"].into_iter().enumerate() {
        let figure = &report["designs"][k]["stereo"]["vertical_disparity_rms_px"];
        let path = format!("{name}/stereo/vertical_disparity_rms_px");
        assert_eq!(compared[&path], figure["measured"]);
        assert_eq!(compared[&format!("{path}/true")], figure["true"]);
        assert!(figure["true"].as_f64().is_some_and(|px| px > 0.0));
    }
    assert!(compared.as_object().is_some_and(|map| !map.keys().any(|path| path.contains("/halves/"))));
    let some = figures("compare", &["--figure", "flat/halves/left/corners"]);
    assert_eq!(some["flat/halves/left/corners/found"], report["designs"][0]["halves"]["left"]["corners"]["found"]);
    assert!(some.as_object().is_some_and(|map| map.keys().all(|path| path.starts_with("flat/halves/left/corners/"))));

    let design = alone(&["design", "scene.toml", "--degree", "7"]);
    let designed = figures("design --degree 7", &[]);
    assert_eq!(designed["front/rms_mm"], design["front"]["rms_mm"]);
    assert_eq!(designed["cutter/residuals/0/rms_px"], design["cutter"]["residuals"][0]["rms_px"]);
    let study = alone(&["analyse", "reprojection", "scene.toml", "--grid", "9"]);
    let studied = figures("analyse reprojection --grid 9", &[]);
    let sheet = study["sheets"].as_object().and_then(|sheets| sheets.iter().find(|(name, _)| *name == "reprojection"));
    let (_, sheet) = sheet.expect("a sheet");
    let numbers = sheet["rows"][0].as_object().expect("a row").iter().filter(|(_, value)| value.is_number());
    let mut seen = 0;
    for (key, value) in numbers {
        assert_eq!(&studied[format!("reprojection/flat-right/{key}")], value, "{key}");
        seen += 1;
    }
    assert!(seen > 3, "{seen}");
}

/// A restart does what is missing; a line that was cut off is made anew; another run is refused.
#[test]
fn a_restart_does_what_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = tiny_scene(folder.path(), as_is);
    let sweep = ["--sweep", "prism.index=1.46:1.5:5", "--out", "r.jsonl"];
    assert_eq!(batch(folder.path(), &sweep)["made"], 5);
    let whole = fs::read_to_string(folder.path().join("r.jsonl")).expect("the file");
    assert_eq!(batch(folder.path(), &sweep)["made"], 0);
    assert_eq!(fs::read_to_string(folder.path().join("r.jsonl")).expect("the file"), whole, "nothing is touched");

    // Two lines and a piece of the third are left, and one line is out of order.
    let kept: Vec<&str> = whole.split_inclusive('\n').collect();
    let torn = format!("{}{}{}", kept[3], kept[0], &kept[1][..kept[1].len() / 2]);
    fs::write(folder.path().join("r.jsonl"), torn).expect("written");
    let out = biprism(folder.path(), &[&QUICK, &sweep[..], &["--json"]].concat());
    assert!(text(&out.stderr).contains("its last line was cut off"), "{}", text(&out.stderr));
    assert_eq!(json(&out)["made"], 3);
    let again = fs::read_to_string(folder.path().join("r.jsonl")).expect("the file");
    let again_lines: Vec<&str> = again.split_inclusive('\n').collect();
    assert_eq!((again_lines[3], again_lines[0]), (kept[3], kept[0]), "lines that were there stay, in their order");
    let strip = |line: &str| line.split(",\"seconds\"").next().expect("a line").to_owned();
    assert_eq!(again.lines().map(strip).collect::<Vec<_>>(), whole.lines().map(strip).collect::<Vec<_>>());

    // Another verb, other jobs, another scene.
    let refuse = |args: &[&str], word: &str| refused(folder.path(), args, &["r.jsonl:1", "another run", word]);
    refuse(&[&["batch", "scene.toml", "--verb", "compare"], &sweep[..]].concat(), "`verb`");
    refuse(&[&QUICK[..], &["--sweep", "prism.index=1.46:1.5:6", "--out", "r.jsonl"]].concat(), "`jobs`");
    refuse(&[&QUICK[..], &["--sweep", "prism.index=1.46:1.51:5", "--out", "r.jsonl"]].concat(), "a scene");
    refuse(&[&QUICK[..], &sweep[..], &["--figure", "counts"]].concat(), "figures");
    let scene = fs::read_to_string(&path).expect("the scene");
    fs::write(&path, format!("# a comment changes nothing\n{scene}")).expect("written");
    assert_eq!(batch(folder.path(), &sweep)["made"], 0);
    fs::write(&path, scene.replace("thickness_mm = 8.545", "thickness_mm = 8.5")).expect("written");
    refuse(&[&QUICK[..], &sweep[..]].concat(), "a scene");
    // A file that is none of a batch stays as it is.
    refused(folder.path(), &[&QUICK[..], &["--out", "scene.toml"]].concat(), &["scene.toml"]);
    fs::write(folder.path().join("note.txt"), "a note\n").expect("written");
    refused(folder.path(), &[&QUICK[..], &["--out", "note.txt"]].concat(), &["note.txt:1", "no job of a batch"]);
    assert_eq!(fs::read_to_string(folder.path().join("note.txt")).expect("there"), "a note\n");
}

/// The parts put together are the whole; what is missing or said twice in two ways is refused.
#[test]
fn parts_are_put_together() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let sweep = ["--sweep", "prism.index=1.46:1.5:3", "--sweep", "board.square_mm=18:20:2"];
    batch(folder.path(), &[&sweep[..], &["--out", "whole.jsonl"]].concat());
    for part in ["1/2", "2/2"] {
        let told = batch(folder.path(), &[&sweep[..], &["--shard", part]].concat());
        assert_eq!(told["own"], 3, "{told}");
    }
    let parts = ["out/batch_1_of_2.jsonl", "out/batch_2_of_2.jsonl"];
    let merged = json(&biprism(folder.path(), &["merge", parts[0], parts[1], "--out", "m", "--json"]));
    assert_eq!((&merged["jobs"], &merged["again"]), (&json!(6), &json!(0)));
    assert_eq!(lines(folder.path(), "m/batch.jsonl"), lines(folder.path(), "whole.jsonl"));
    // A job that two machines did is no fault where both say the same.
    fs::write(folder.path().join("empty.jsonl"), "").expect("written");
    let with_empty = ["merge", "empty.jsonl", "whole.jsonl", "--out", "m", "--json"];
    assert_eq!(json(&biprism(folder.path(), &with_empty))["jobs"], 6, "a part without jobs is no fault");
    let again = json(&biprism(folder.path(), &["merge", parts[0], "whole.jsonl", "--out", "m", "--json"]));
    assert_eq!(again["again"], 3);
    refused(folder.path(), &["merge", parts[0]], &["of 6 jobs 3 are in no file", "the first of them 1"]);
    let other =
        fs::read_to_string(folder.path().join(parts[1])).expect("a part").replace("counts/rays\":", "counts/rays\":1");
    fs::write(folder.path().join("other.jsonl"), other).expect("written");
    refused(
        folder.path(),
        &["merge", "whole.jsonl", "other.jsonl"],
        &["is in whole.jsonl as well, and says something else"],
    );
    batch(folder.path(), &["--sweep", "prism.index=1.46:1.5:6", "--out", "strange.jsonl"]);
    refused(folder.path(), &["merge", "whole.jsonl", "strange.jsonl"], &["strange.jsonl:1", "another run", "`run`"]);
    refused(folder.path(), &["merge", "whole.jsonl", "--budget", "vertical_px=1"], &["--budget"]);

    // A figure over both keys is a map, over one a line each.
    let figure = ["--figure", "counts/rays"];
    let chart = |over: &[&str]| {
        let out = biprism(folder.path(), &[&["merge", "whole.jsonl", "--out", "c"], &figure[..], over].concat());
        assert!(out.status.success(), "{}", text(&out.stderr));
        assert!(fs::read(folder.path().join("c/sweep_counts_rays.png")).expect("drawn").starts_with(b"\x89PNG"));
        fs::read_to_string(folder.path().join("c/sweep_counts_rays.svg")).expect("drawn")
    };
    let map = chart(&[]);
    assert!(map.contains("prism.index") && map.contains("board.square_mm") && !map.contains("square_mm 18"), "{map}");
    let one = chart(&["--over", "prism.index"]);
    assert!(one.contains("square_mm 18") && one.contains("square_mm 20"), "{one}");
    refused(folder.path(), &["merge", "whole.jsonl", "--figure", "counts/ray"], &["no job has a figure"]);
}

/// Jobs of a file have scenes, values and words of their own; what goes wrong in one is told in its line, and the others go on.
#[test]
fn errors_are_data() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    fs::create_dir(folder.path().join("jobs")).expect("a folder");
    fs::copy(folder.path().join("scene.toml"), folder.path().join("jobs/other.toml")).expect("copied");
    let jobs = "{\"set\": {\"prism.index\": 1.5}}\n\n{\"id\": \"bad\", \"set\": {\"prism.index\": \"abc\"}}\n\
                {\"id\": \"none\", \"set\": {\"prism.indx\": 2}}\n{\"scene\": \"other.toml\", \"set\": {\"board.tilt_deg[1]\": 5}}\n\
                {\"id\": \"physics\", \"set\": {\"board.position_mm\": [0, 0, 10]}}\n";
    fs::write(folder.path().join("jobs/list.jsonl"), jobs).expect("written");
    let args = [&QUICK[..], &["--jobs", "jobs/list.jsonl", "--out", "r.jsonl", "--json"]].concat();
    let out = biprism(folder.path(), &args);
    assert_eq!(out.status.code(), Some(1), "{}", text(&out.stderr));
    assert!(text(&out.stderr).contains("3 jobs ended in an error"), "{}", text(&out.stderr));
    let told: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert_eq!((&told["made"], &told["errors"]), (&json!(5), &json!(3)));
    let found = lines(folder.path(), "r.jsonl");
    let error = |k: usize| &found[k]["error"];
    assert!(found[0]["figures"]["counts/rays"].as_f64().is_some_and(|rays| rays > 0.0) && error(0).is_null());
    assert_eq!((&found[1]["id"], &error(1)["key"]), (&json!("bad"), &json!("prism.index")));
    assert_eq!(error(1)["rule"], "`prism.index` is a string, \"abc\", and must be a number");
    assert!(error(2)["help"].as_str().is_some_and(|help| help.contains("did you mean `index`?")), "{}", error(2));
    assert!(found[3]["figures"].is_object() && found[3]["set"]["board.tilt_deg[1]"] == 5);
    assert!(error(4)["rule"].is_string() && error(4)["key"].is_string(), "{}", error(4));
    // The same from stdin; errors are not tried again.
    let out = with_input(
        folder.path(),
        &args.iter().map(|a| if *a == "jobs/list.jsonl" { "-" } else { a }).collect::<Vec<_>>(),
        jobs,
    );
    assert_eq!(out.status.code(), Some(2), "{}", text(&out.stderr));
    assert!(text(&out.stderr).contains("other.toml"), "relative to the present folder: {}", text(&out.stderr));
    assert_eq!(biprism(folder.path(), &args).status.code(), Some(1));
    assert_eq!(lines(folder.path(), "r.jsonl").len(), 5);

    // What is no file of jobs is told with its line.
    for (jobs, rule) in [
        ("{\"set\": {}}\n{\"sett\": {}}\n", "list.jsonl:2"),
        ("{\"id\": \"a\"}\n{\"id\": \"a\"}\n", "the job 1 has the id of another one"),
        ("{\"set\": {\"a b\": 1}}\n", "is no key of a scene"),
        ("\n", "the file has no job"),
    ] {
        fs::write(folder.path().join("jobs/list.jsonl"), jobs).expect("written");
        refused(folder.path(), &[&QUICK[..], &["--jobs", "jobs/list.jsonl", "--out", "x.jsonl"]].concat(), &[rule]);
    }
}

/// What a verb exits 1 for is told in the line, and by the exit code of the run and of each that goes on.
#[test]
fn what_is_not_kept_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    for verb in ["render --target-px 1e-12", "compare --target-px 1e-12"] {
        let out = format!("{}.jsonl", &verb[..6]);
        for _ in 0..2 {
            let run = biprism(folder.path(), &["batch", "scene.toml", "--verb", verb, "--out", &out, "--json"]);
            assert_eq!(run.status.code(), Some(1), "{verb}");
            let told: Value = serde_json::from_slice(&run.stdout).expect("JSON");
            assert_eq!((&told["unmet"], &told["errors"]), (&json!(1), &json!(0)), "{verb}");
        }
        let unmet = lines(folder.path(), &out)[0]["unmet"].take();
        assert!(unmet[0].as_str().is_some_and(|words| words.contains("not kept to 1e-12 px")), "{unmet}");
    }
}

#[test]
fn what_is_no_batch_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let verb = |verb: &str, word: &str| refused(folder.path(), &["batch", "scene.toml", "--verb", verb], &[word]);
    verb("measure", "the verbs of a batch are");
    verb("compare --out x", "--out has no place here");
    verb("compare --set=a=1", "--set=a=1 has no place here");
    verb("compare scene.toml", "the scene is that of the job");
    verb("analyse paper", "it has scenes of its own");
    verb("analyse stereo --gird 3", "--gird");
    let million = ["--sweep", "prism.index=1:2:1000000", "--sweep", "board.columns=1,2"];
    refused(folder.path(), &[&QUICK[..], &million].concat(), &["more than 1000000 jobs"]);
    let twice = ["--sweep", "prism.index=1:2:2", "--sweep", "prism.index=3,4"];
    refused(folder.path(), &[&QUICK[..], &twice].concat(), &["`prism.index` is swept twice"]);
    refused(folder.path(), &[&QUICK[..], &["--sweep", "prism.index=1:2:0"]].concat(), &["number of values"]);
    refused(
        folder.path(),
        &[&QUICK[..], &["--sweep", "prism.index=nan:2:3"]].concat(),
        &["ends of a range are numbers"],
    );
    let both = ["--set", "prism.index=1.7", "--sweep", "prism.index=1.5,1.6"];
    refused(folder.path(), &[&QUICK[..], &both].concat(), &["`prism.index` is both set and swept"]);
    let from_stdin = ["batch", "--jobs", "-", "--verb", "render"];
    let out = with_input(folder.path(), &from_stdin, "{\"scene\": \"-\"}\n");
    assert!(out.status.code() == Some(2) && text(&out.stderr).contains("from stdin"), "{}", text(&out.stderr));
    let none = ["--figure", "counts/ray", "--out", "none.jsonl"];
    refused(folder.path(), &[&QUICK[..], &none].concat(), &["no figure of `render` is called counts/ray"]);
    fs::remove_file(folder.path().join("none.jsonl")).expect("removed");
    assert!(!folder.path().join("out").exists(), "nothing is written");
}

/// Killed at any moment, a run loses the jobs in flight at most, and its file is as good as before.
#[test]
#[cfg(unix)]
fn a_run_that_is_killed_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    small_scene(folder.path(), as_is);
    let args = [&QUICK[..], &["--sweep", "prism.index=1.46:1.5:40", "--threads", "2", "--out", "r.jsonl"]].concat();
    let count =
        || fs::read(folder.path().join("r.jsonl")).map_or(0, |bytes| bytes.iter().filter(|b| **b == b'\n').count());
    let mut kills = 0;
    for wanted in [1, 4, 9] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biprism"));
        let mut child = command
            .current_dir(folder.path())
            .args(&args)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        let started = Instant::now();
        while count() < wanted && started.elapsed() < Duration::from_secs(60) {
            sleep(Duration::from_millis(2));
        }
        // SIGKILL: nothing of the program runs any more.
        kills += usize::from(child.try_wait().expect("asked").is_none());
        child.kill().expect("killed");
        child.wait().expect("it ends");
        let there = count();
        assert!(there >= wanted, "lines that were there stay: {there} of {wanted}");
        let whole = fs::read_to_string(folder.path().join("r.jsonl")).expect("the file");
        let good = whole.split_inclusive('\n').filter(|line| line.ends_with('\n'));
        assert!(good.clone().all(|line| serde_json::from_str::<Value>(line).is_ok()), "every whole line is JSON");
    }
    assert!(kills > 0, "the runs were too short to be killed");
    let there = count();
    let told = json(&biprism(folder.path(), &[&args[..], &["--json"]].concat()));
    assert_eq!(told["made"], 40 - there, "what was there is not done again");
    let found = lines(folder.path(), "r.jsonl");
    assert!(found.len() == 40 && found.iter().enumerate().all(|(k, line)| line["job"] == k));
}
