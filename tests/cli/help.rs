//! Help, manual and completions: the examples run, every verb has its page, shells take what they are given.

use crate::command::{biprism, repository, text};
use biprism::cli::args::Args;
use clap::{Command, CommandFactory};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;

/// Every verb and study, by the words that call it.
fn verbs() -> Vec<(Vec<String>, Command)> {
    fn below(command: &Command, words: &[String], found: &mut Vec<(Vec<String>, Command)>) {
        for sub in command.get_subcommands() {
            let words = [words, &[sub.get_name().to_owned()]].concat();
            found.push((words.clone(), sub.clone()));
            below(sub, &words, found);
        }
    }
    let mut found = Vec::new();
    below(&Args::command(), &[], &mut found);
    assert!(found.len() > 20, "{}", found.len());
    found
}

/// The commands at the end of a verb's help.
fn examples(command: &Command) -> Vec<String> {
    let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let lines = help.strip_prefix("Example:\n").map(str::lines).into_iter().flatten();
    lines.map(|line| line.trim().to_owned()).collect()
}

fn copied(folder: &str, to: &Path, wanted: impl Fn(&str) -> bool) {
    fs::create_dir_all(to.join(folder)).expect("a folder");
    for entry in fs::read_dir(repository(folder)).expect("a folder") {
        let entry = entry.expect("an entry");
        let name = format!("{folder}/{}", entry.file_name().display());
        if wanted(&name) {
            fs::copy(entry.path(), to.join(&name)).expect("copied");
        }
    }
}

#[test]
fn every_verb_ends_its_help_with_an_example_that_runs() {
    let program = Path::new(env!("CARGO_BIN_EXE_biprism")).parent().expect("a folder");
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
    for (words, command) in verbs() {
        let examples = examples(&command);
        let own = format!("biprism {}", words.join(" "));
        assert!(examples.iter().any(|line| line.contains(&own)), "{words:?} has no example: {examples:?}");
        // The whole study of the paper takes seconds; it has tests of its own.
        if own.ends_with("analyse paper") {
            continue;
        }
        let folder = tempfile::tempdir().expect("a folder");
        copied("scenes/cases", folder.path(), |name| name.ends_with(".toml"));
        copied("golden", folder.path(), |name| name.contains("/prism_flat."));
        for line in examples {
            let mut shell = std::process::Command::new("sh");
            let done =
                shell.args(["-c", &line]).env("PATH", &path).current_dir(folder.path()).output().expect("sh runs");
            assert!(done.status.success(), "{line}\n{}", text(&done.stderr));
        }
    }
}

#[test]
fn a_verb_shows_its_example() {
    let folder = tempfile::tempdir().expect("a folder");
    for flag in ["-h", "--help"] {
        let help = text(&biprism(folder.path(), &["render", flag]).stdout);
        let last = help.trim_end().lines().last().expect("a line");
        assert_eq!(last, "  biprism render scenes/cases/prism_flat.toml --out picture.png --out picture.exr", "{flag}");
    }
}

#[test]
fn every_verb_has_a_page_of_the_manual() {
    let folder = tempfile::tempdir().expect("a folder");
    let done = biprism(folder.path(), &["man", "--out", "man"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let page = |words: &[String]| {
        let name = format!("man/biprism{}.1", words.iter().map(|word| format!("-{word}")).collect::<String>());
        fs::read_to_string(folder.path().join(&name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    let verbs = verbs();
    for (words, command) in &verbs {
        let page = page(words);
        assert!(page.contains(".SH NAME") && page.contains(".SH SYNOPSIS") && page.contains("Example:"), "{words:?}");
        for option in command.get_arguments().filter_map(clap::Arg::get_long).filter(|name| *name != "version") {
            assert!(page.contains(&option.replace('-', "\\-")), "{words:?}: {option}");
        }
    }
    assert_eq!(fs::read_dir(folder.path().join("man")).expect("the folder").count(), verbs.len() + 1);
    // Without a folder the page of the command goes to stdout; the machine that made it is not told.
    let printed = text(&biprism(folder.path(), &["man"]).stdout);
    assert_eq!(printed, page(&[]));
    assert!(!printed.contains("vectors"));
}

/// The script for a shell.
fn script(shell: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let done = biprism(folder.path(), &["completions", shell]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    text(&done.stdout)
}

#[test]
fn bash_completes_verbs_and_formats() {
    let script = script("bash");
    let asked = format!(
        "{script}\nCOMP_WORDS=(biprism exp); COMP_CWORD=1; _biprism biprism exp biprism; echo \"${{COMPREPLY[*]}}\"\n\
         COMP_WORDS=(biprism export a.toml --format zem); COMP_CWORD=4; _biprism biprism zem --format; echo \"${{COMPREPLY[*]}}\"\n"
    );
    let run = |args: &[&str], input: &str| {
        let mut bash = std::process::Command::new("bash");
        let mut child =
            bash.args(args).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().ok()?;
        child.stdin.take().expect("a pipe").write_all(input.as_bytes()).expect("written");
        child.wait_with_output().ok()
    };
    let Some(checked) = run(&["-n"], &script) else {
        println!("there is no bash here: its completions are not looked at");
        return;
    };
    assert!(checked.status.success() && checked.stderr.is_empty(), "{}", text(&checked.stderr));
    let done = run(&["--norc"], &asked).expect("it ran before");
    assert_eq!(text(&done.stdout), "export\nzemax-grid zemax-extended\n", "{}", text(&done.stderr));
}

#[test]
fn other_shells_are_given_every_verb() {
    for shell in ["zsh", "fish", "elvish", "powershell"] {
        let script = script(shell);
        for (words, _) in verbs() {
            assert!(script.contains(words.last().expect("a word").as_str()), "{shell}: {words:?}");
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let done = biprism(folder.path(), &["completions", "csh"]);
    assert!(done.status.code() == Some(2) && text(&done.stderr).contains("possible values: bash"));
}

#[test]
fn the_version_tells_the_build() {
    let folder = tempfile::tempdir().expect("a folder");
    let told = |flag: &str| text(&biprism(folder.path(), &[flag]).stdout);
    assert_eq!(told("-V"), format!("biprism {}\n", env!("CARGO_PKG_VERSION")));
    let long = told("--version");
    assert!(long.starts_with(&told("-V")), "{long}");
    for key in ["target:", "profile:", "opt-level", "vectors:", "rustc 1.", env!("CARGO_PKG_RUST_VERSION")] {
        assert!(long.contains(key), "{key}: {long}");
    }
    assert!(long.contains(std::env::consts::ARCH) && !long.contains("unknown,"), "{long}");
}
