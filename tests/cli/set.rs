//! `--set`, a scene from stdin, `--threads`: for every verb that takes a scene.

use crate::command::{as_is, biprism, json, repository, text, tiny_scene, with_input};
use biprism::cli::args::Args;
use clap::{Command, CommandFactory};
use std::fs;
use std::path::Path;
use std::process::Command as Process;

/// Every verb and study that takes a scene, by the words that call it.
fn verbs_with_scenes() -> Vec<(Vec<String>, Command)> {
    fn below(command: &Command, words: &[String], found: &mut Vec<(Vec<String>, Command)>) {
        for sub in command.get_subcommands() {
            let words = [words, &[sub.get_name().to_owned()]].concat();
            let takes = |name: &str| sub.get_arguments().any(|argument| argument.get_id() == name);
            if takes("scene") || takes("scenes") {
                found.push((words.clone(), sub.clone()));
            }
            below(sub, &words, found);
        }
    }
    let mut found = Vec::new();
    below(&Args::command(), &[], &mut found);
    found
}

#[test]
fn every_verb_that_takes_a_scene_takes_its_values() {
    let verbs = verbs_with_scenes();
    assert!(verbs.len() > 18, "{}", verbs.len());
    for (words, command) in verbs {
        let has = |long: &str| command.get_arguments().any(|argument| argument.get_long() == Some(long));
        assert!(has("set"), "{words:?}");
        let scene = command.get_arguments().find(|a| a.get_id() == "scene" || a.get_id() == "scenes").expect("a scene");
        assert!(scene.get_help().expect("help").to_string().contains("`-` is stdin"), "{words:?}");
    }
}

/// A value that is given is as one in the text, through the same rules; and so is a scene from stdin.
#[test]
fn a_value_that_is_given_is_as_one_in_the_text() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = tiny_scene(folder.path(), as_is);
    let whole = fs::read_to_string(&path).expect("the scene");
    let changed = whole.replace("index = 1.48", "index = 1.5").replace("[0.0, 0.0, 1000.0]", "[0.0, 0.0, 900.0]");
    assert_ne!(whole, changed);
    fs::write(folder.path().join("changed.toml"), &changed).expect("written");
    let set = ["--set", "prism.index=1.5", "--set", "board.position_mm[2]=900"];
    let picture = |scene: &str, more: &[&str], input: &str| {
        let out = with_input(folder.path(), &[&["render", scene, "--out", "a.png"], more].concat(), input);
        assert!(out.status.success(), "{}", text(&out.stderr));
        fs::read(folder.path().join("a.png")).expect("written")
    };
    let wanted = picture("changed.toml", &[], "");
    assert!(picture("scene.toml", &set, "") == wanted, "values that are given");
    assert!(picture("-", &set, &whole) == wanted, "a scene from stdin with values");
    assert!(picture("-", &["--threads", "3"], &changed) == wanted, "other threads");
    assert!(picture("scene.toml", &[], "") != wanted, "the values matter");

    // Pictures of a set state what was given, too.
    let set_of = |args: &[&str]| {
        let out = biprism(folder.path(), &[&["dataset"], args, &["--poses", "1", "--out", "set"]].concat());
        assert!(out.status.success(), "{}", text(&out.stderr));
        let picture = fs::read(folder.path().join("set/000000.png")).expect("a picture");
        fs::remove_dir_all(folder.path().join("set")).expect("removed");
        picture
    };
    assert!(set_of(&["changed.toml"]) == set_of(&[&["scene.toml"], &set[..]].concat()), "a set");
}

/// Files that a scene from stdin names are sought in the present folder, those of a file beside it.
#[test]
fn files_of_a_scene_from_stdin_lie_in_the_present_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = fs::read_to_string(tiny_scene(folder.path(), as_is)).expect("the scene");
    let other = folder.path().join("other");
    fs::create_dir(&other).expect("a folder");
    for name in ["front.ply", "back.obj"] {
        fs::copy(repository("scenes/cases/prism_mesh").join(name), folder.path().join(name)).expect("copied");
    }
    let mesh = "prism={kind = \"mesh\", index = 1.48, front = \"front.ply\", back = \"back.obj\"}";
    let code = |folder: &Path, scene: &str, input: &str| {
        let out = with_input(folder, &["check", scene, "--set", mesh], input);
        assert!(out.status.success() || text(&out.stderr).contains("front.ply"), "{}", text(&out.stderr));
        out.status.code()
    };
    assert_eq!(code(folder.path(), "-", &scene), Some(0));
    assert_eq!(code(&other, "-", &scene), Some(2));
    assert_eq!(code(&other, "../scene.toml", ""), Some(0));
}

#[test]
fn what_is_wrong_with_a_value_is_told_with_its_words() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let told = |args: &[&str]| {
        let out = biprism(folder.path(), args);
        assert_eq!(out.status.code(), Some(2), "{args:?}");
        text(&out.stderr)
    };
    let cases = [
        ("prism.index=abc", "`prism.index` is a string, abc, and must be a number", "write the number alone"),
        ("prism.indx=1.5", "`prism.indx` is not a key", "did you mean `index`?"),
        ("prism.index=-1", "`prism.index` is -1, and must be", "change `index`"),
    ];
    for (value, rule, help) in cases {
        for verb in [&["check", "scene.toml"][..], &["compare", "scene.toml"], &["analyse", "spot", "scene.toml"]] {
            let said = told(&[verb, &["--set", value]].concat());
            assert!(said.contains(&format!("--set {value}")) && said.contains(rule) && said.contains(help), "{said}");
        }
    }
    assert!(told(&["check", "scene.toml", "--set", "prism"]).contains("give a key and its value"));
    assert!(!folder.path().join("out").exists(), "nothing is written");
    fs::write(folder.path().join("a.png"), "no picture").expect("written");
    let said = told(&["corners", "a.png", "--set", "prism.index=1.5"]);
    assert!(said.contains("it changes a scene, and there is none"), "{said}");
}

#[test]
fn threads_have_a_limit_and_beat_the_environment() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    for wrong in ["0", "257", "-1", "many"] {
        assert_eq!(
            biprism(folder.path(), &["check", "scene.toml", "--threads", wrong]).status.code(),
            Some(2),
            "{wrong}"
        );
    }
    let bits = |args: &[&str]| {
        let mut command = Process::new(env!("CARGO_BIN_EXE_biprism"));
        let out =
            command.current_dir(folder.path()).env("RAYON_NUM_THREADS", "300").args(args).output().expect("it runs");
        let told = text(&out.stderr);
        (json(&out)["designs"][1]["stereo"].to_string(), told)
    };
    let (one, told) = bits(&["compare", "scene.toml", "--pictures", "none", "--json", "--threads", "1"]);
    let (five, _) = bits(&["compare", "scene.toml", "--pictures", "none", "--json", "--threads", "5"]);
    assert!(one == five && !told.contains("300"), "{told}");
}
