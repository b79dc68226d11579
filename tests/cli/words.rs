//! `new`, and how much the command says, in which colours.

use crate::command::{as_is, biprism, text, tiny_scene, with_input};
use std::fs;
use std::process::Command;

#[test]
fn new_writes_a_scene_that_can_be_judged_and_loses_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let new = |more: &[&str]| {
        let flags = ["new", "mine.toml", "--width-px", "320", "--height-px", "180", "--pixel-um", "24"];
        biprism(folder.path(), &[&flags[..], more].concat())
    };
    let output = new(&["--focal-mm", "25", "--distance-mm", "800", "--prism", "flat"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("next: `biprism check mine.toml`"));
    let check = biprism(folder.path(), &["check", "mine.toml"]);
    assert!(check.status.success(), "{}", text(&check.stderr));
    let judged = biprism(folder.path(), &["compare", "mine.toml", "-q"]);
    assert!(judged.status.success() && judged.stderr.is_empty(), "{}", text(&judged.stderr));
    assert!(text(&judged.stdout).contains("vertical disparity, RMS, px"));

    // A file that is there stays as it is.
    let before = fs::read(folder.path().join("mine.toml")).expect("the scene");
    let again = new(&["--focal-mm", "50"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("mine.toml") && text(&again.stderr).contains("not written over"));
    assert_eq!(fs::read(folder.path().join("mine.toml")).expect("the scene"), before);
}

#[test]
fn new_asks_where_it_is_told_to() {
    let folder = tempfile::tempdir().expect("a folder");
    let answers = "640\n480\n7.5\n\n\nflat\n1.52\n\n";
    let output = with_input(folder.path(), &["new", "-", "--ask"], answers);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let scene = text(&output.stdout);
    for line in ["width_px = 640", "pixel_pitch_um = 7.5", "kind = \"flat\"", "index = 1.52", "focal_length_mm = 35.0"]
    {
        assert!(scene.contains(line), "{line} is not in\n{scene}");
    }
    assert!(text(&output.stderr).contains("focal length of the lens, mm [35]?"));

    // A lens too wide for the glass, and an answer that is none, end in one sentence and no file.
    let wrong = with_input(folder.path(), &["new", "a.toml", "--ask"], "many\n");
    assert_eq!(wrong.status.code(), Some(2));
    assert!(text(&wrong.stderr).contains("`many` is no number"), "{}", text(&wrong.stderr));
    let wide = biprism(folder.path(), &["new", "a.toml", "--focal-mm", "2"]);
    assert_eq!(wide.status.code(), Some(2), "{}", text(&wide.stderr));
    assert!(!folder.path().join("a.toml").exists());
}

#[test]
fn quiet_says_why_the_exit_code_is_1_and_verbose_how_long_each_stage_took() {
    let folder = tempfile::tempdir().expect("a folder");
    let claim = "\n[[expect]]\nvalue = \"flat/stereo/vertical_disparity_rms_px/true\"\nmax = 1e-9\n";
    tiny_scene(folder.path(), |scene| scene + claim);
    let quiet = biprism(folder.path(), &["compare", "scene.toml", "--quiet"]);
    assert_eq!(quiet.status.code(), Some(1));
    let said = text(&quiet.stderr);
    assert!(said.lines().count() == 1 && said.contains("vertical_disparity_rms_px"), "{said}");

    tiny_scene(folder.path(), as_is);
    let verbose = text(&biprism(folder.path(), &["-v", "render", "scene.toml", "--out", "a.png"]).stderr);
    let timed = |stage: &str| verbose.lines().any(|line| line.contains(stage) && line.ends_with(" s"));
    assert!(timed("design"), "{verbose}");
    let both = biprism(folder.path(), &["-q", "-v", "check", "scene.toml"]);
    assert_eq!(both.status.code(), Some(2));
}

#[test]
fn colours_are_there_when_they_are_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = |words: &[&str], no_color: bool| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biprism"));
        command.current_dir(folder.path()).args(words);
        if no_color {
            command.env("NO_COLOR", "1");
        }
        let output = command.output().expect("it runs");
        text(&output.stdout) + &text(&output.stderr)
    };
    for words in [&["check", "absent.toml"][..], &["check", "--nonsense"], &["--help"]] {
        let with = |when: &'static str| [words, &["--color", when]].concat();
        assert!(said(&with("always"), true).contains('\u{1b}'), "{words:?}");
        assert!(!said(&with("never"), false).contains('\u{1b}'), "{words:?}");
        assert!(!said(words, false).contains('\u{1b}'), "no terminal: {words:?}");
    }
}
