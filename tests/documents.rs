//! Do the documents say what the program does? Pages that are made are as their generators make them, every block of
//! commands and of scene text runs from a fresh folder, and every command in a sentence is one that the program knows.
//!
//! What stands on the line before a block says how it is taken:
//! - `<!-- not run: WHY -->`: it is left out;
//! - `<!-- file: NAME -->`: it is the file NAME, for the blocks behind it;
//! - nothing, before `sh`: it runs in the document's folder, which holds `scenes/` and what the blocks before left there;
//! - nothing, before `toml`: its tables take the place of those in the scene that the line above names, `scenes/paper.toml`
//!   where it names none, and `biprism check` takes the whole.

use biprism::cli::args::Args;
use clap::Parser;
use clap::error::ErrorKind;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

#[path = "../examples/maintainers/metrics_page.rs"]
mod metrics_page;
#[path = "../examples/maintainers/scene_page.rs"]
mod scene_page;

/// A block between fences.
struct Block {
    /// Document and line of the fence.
    place: String,
    language: String,
    /// The comment on the line before the fence.
    mark: Option<String>,
    /// The scene that the line above names.
    scene: Option<String>,
    text: String,
}

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The documents, each with its text.
fn documents() -> Vec<(String, String)> {
    let folder = fs::read_dir(repository("docs")).expect("the folder of documents");
    let mut names: Vec<String> = folder
        .map(|entry| format!("docs/{}", entry.expect("an entry").file_name().display()))
        .filter(|name| name.ends_with(".md"))
        .chain(["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(String::from))
        .collect();
    names.sort();
    names
        .into_iter()
        .map(|name| (fs::read_to_string(repository(&name)).expect("a document"), name))
        .map(|(t, n)| (n, t))
        .collect()
}

fn blocks(name: &str, text: &str) -> Vec<Block> {
    let mut found = Vec::new();
    let mut before = "";
    let mut sentence = "";
    let mut lines = text.lines().enumerate();
    while let Some((k, line)) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            let inside: Vec<&str> = lines.by_ref().map(|(_, line)| line).take_while(|line| *line != "```").collect();
            let mark = before.strip_prefix("<!-- ").and_then(|mark| mark.strip_suffix(" -->"));
            found.push(Block {
                place: format!("{name}:{}", k + 1),
                language: language.to_owned(),
                mark: mark.map(str::to_owned),
                scene: sentence.split('`').find(|span| span.starts_with("scenes/")).map(str::to_owned),
                text: inside.join("\n") + "\n",
            });
        }
        before = line;
        sentence = if line.trim().is_empty() { sentence } else { line };
    }
    found
}

#[test]
fn page_of_the_scene_is_current() {
    let path = repository("docs/scene.md");
    let text = fs::read_to_string(&path).unwrap_or_default();
    let command = "cargo run --release --example scene_page";
    assert!(text == scene_page::page(), "{} is not as the schema has it: `{command}` writes it anew", path.display());
}

#[test]
fn page_of_the_metrics_is_current() {
    let path = repository("docs/metrics.md");
    let text = fs::read_to_string(&path).unwrap_or_default();
    let command = "cargo run --release --example metrics_page";
    assert!(text == metrics_page::page(), "{} is not as the meanings say: `{command}` writes it anew", path.display());
}

#[test]
fn every_block_runs_from_a_fresh_folder() {
    for (name, text) in documents() {
        let folder = tempfile::tempdir().expect("a folder");
        copy(&repository("scenes"), &folder.path().join("scenes"));
        for block in blocks(&name, &text) {
            take(&block, folder.path());
        }
    }
}

/// Runs or writes one block.
fn take(block: &Block, folder: &Path) {
    let place = &block.place;
    match (block.mark.as_deref().and_then(|mark| mark.split_once(": ")), block.language.as_str()) {
        (Some(("not run", why)), _) => assert!(why.len() > 3, "{place} does not say why it is not run"),
        (Some(("file", name)), _) => fs::write(folder.join(name), &block.text).expect("written"),
        (None, "sh") => {
            let program = Path::new(env!("CARGO_BIN_EXE_biprism")).parent().expect("the program is in a folder");
            let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
            let mut shell = Command::new("sh");
            let run =
                shell.args(["-euc", &block.text]).env("PATH", path).current_dir(folder).output().expect("sh runs");
            assert!(run.status.success(), "{place}: {}\n{}", run.status, String::from_utf8_lossy(&run.stderr));
        }
        (None, "toml") => {
            let base = folder.join(block.scene.as_deref().unwrap_or("scenes/paper.toml"));
            let base = fs::read_to_string(base).unwrap_or_else(|error| panic!("{place}: the scene above: {error}"));
            let mut scene: toml::Table = base.parse().expect("the scene is TOML");
            let own: toml::Table = block.text.parse().unwrap_or_else(|error| panic!("{place}: {error}"));
            scene.extend(own);
            fs::write(folder.join("block.toml"), scene.to_string()).expect("written");
            let mut check = Command::new(env!("CARGO_BIN_EXE_biprism"));
            let run = check.args(["check", "block.toml"]).current_dir(folder).output().expect("it runs");
            assert!(run.status.success(), "{place}: {}", String::from_utf8_lossy(&run.stderr));
        }
        (None, "text") => {}
        other => panic!("{place}: nobody knows how to take a block of {other:?}"),
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry").path();
        let target = to.join(entry.file_name().expect("a name"));
        if entry.is_dir() {
            copy(&entry, &target);
        } else {
            fs::copy(&entry, &target).expect("copied");
        }
    }
}

/// A command in a sentence may leave out what it needs; what it says must be known.
#[test]
fn every_command_in_a_sentence_is_known() {
    let mut seen = 0;
    for (name, text) in documents() {
        for (k, line) in text.lines().enumerate() {
            let spans = line.split('`').skip(1).step_by(2);
            for span in spans.filter(|span| span.starts_with("biprism ")) {
                seen += 1;
                let known = Args::try_parse_from(words(span)).err().is_none_or(|error| {
                    matches!(
                        error.kind(),
                        ErrorKind::MissingRequiredArgument | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
                    )
                });
                assert!(known, "{name}:{}: `{span}` is no command of the program", k + 1);
            }
        }
    }
    assert!(seen > 30, "only {seen} commands were seen");
}

/// A file or a folder of the repository that a sentence or a link names.
#[test]
fn every_path_in_a_sentence_exists() {
    const FOLDERS: [&str; 9] =
        ["src/", "tests/", "docs/", "scenes/", "schemas/", "tools/", "benches/", "examples/", "fuzz/"];
    let plain = |span: &&str| span.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c));
    let mut faults = Vec::new();
    for (name, text) in documents() {
        let folder = repository(&name).parent().expect("a document is in a folder").to_owned();
        for (k, line) in text.lines().enumerate() {
            let spans = line.split('`').skip(1).step_by(2);
            let named = spans.filter(plain).filter(|span| FOLDERS.iter().any(|folder| span.starts_with(folder)));
            let links = line.split("](").skip(1).filter_map(|rest| rest.split(')').next()).filter(plain);
            let paths = named.map(repository).chain(links.map(|link| folder.join(link)));
            faults.extend(
                paths.filter(|path| !path.exists()).map(|path| format!("{name}:{}: {}", k + 1, path.display())),
            );
        }
    }
    assert!(faults.is_empty(), "not there:\n{}", faults.join("\n"));
}

/// The words of a command: quotes keep words together, `[X]` is an X that may be left out.
fn words(command: &str) -> Vec<String> {
    let quoted = command.split('"').enumerate();
    quoted
        .flat_map(|(k, part)| match k % 2 {
            0 => part.split_whitespace().map(|word| word.trim_matches(['[', ']']).to_owned()).collect(),
            _ => vec![part.to_owned()],
        })
        .collect()
}

/// The test of the test.
#[test]
fn blocks_are_recognised() {
    let text = "words\n\n```sh\nbiprism check a\n```\n<!-- file: a.toml -->\n```toml\nx = 1\n```\n";
    let found = blocks("page", text);
    let short: Vec<_> = found.iter().map(|b| (b.place.as_str(), b.language.as_str(), b.mark.as_deref())).collect();
    assert_eq!(short, [("page:3", "sh", None), ("page:7", "toml", Some("file: a.toml"))]);
    assert_eq!(found[1].text, "x = 1\n");
    assert_eq!(
        words("biprism analyse stability --only \"fit from\""),
        ["biprism", "analyse", "stability", "--only", "fit from"]
    );
}
