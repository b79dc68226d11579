//! Do the walls stand? A room may use the rooms below it and no other.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Each room with the rooms it may use. `problem`, `accuracy` and `num` are leaves that every room may use.
const ROOMS: [(&str, &[&str]); 17] = [
    ("problem", &[]),
    ("accuracy", &[]),
    ("num", &[]),
    ("geom", &[]),
    ("optics", &["geom"]),
    ("trace", &["geom", "optics"]),
    ("raster", &["geom"]),
    ("effect", &["geom", "optics", "raster"]),
    ("scene", &["geom", "optics", "effect"]),
    ("design", &["geom", "optics", "trace", "scene"]),
    ("system", &["geom", "optics", "trace", "effect", "scene", "design"]),
    ("render", &["geom", "optics", "trace", "effect", "scene", "system", "raster"]),
    ("vision", &["geom", "raster"]),
    ("metrics", &["geom", "raster", "vision"]),
    (
        "analysis",
        &["geom", "optics", "trace", "effect", "scene", "design", "system", "raster", "render", "vision", "metrics"],
    ),
    ("report", &["geom", "optics", "scene", "design", "raster", "vision", "metrics", "analysis"]),
    (
        "cli",
        &[
            "geom", "optics", "trace", "effect", "scene", "design", "system", "raster", "render", "vision", "metrics",
            "analysis", "report",
        ],
    ),
];
const LEAVES: [&str; 3] = ["problem", "accuracy", "num"];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The code of a file without comments and without the tests at its end.
fn code(path: &Path) -> String {
    code_of(&fs::read_to_string(path).expect("a source file"))
}

fn code_of(text: &str) -> String {
    let text = text.split("\n#[cfg(test)]\nmod tests {").next().expect("the first part");
    text.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// The product's files by room; files of tests only are left out.
fn rooms() -> BTreeMap<String, Vec<PathBuf>> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut rooms: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for path in sources(&src) {
        let inside = path.strip_prefix(&src).expect("inside src");
        let first = inside.components().next().expect("a name").as_os_str().to_string_lossy().into_owned();
        let room = first.trim_end_matches(".rs").to_owned();
        let stem = path.file_stem().expect("a name").to_string_lossy().into_owned();
        if room != "lib" && room != "main" && !stem.ends_with("tests") {
            rooms.entry(room).or_default().push(path);
        }
    }
    rooms
}

/// The rooms named after `crate::` in a text, in plain paths and in groups.
fn used(text: &str) -> BTreeSet<String> {
    let name = |s: &str| s.chars().take_while(|c| c.is_ascii_lowercase() || *c == '_').collect::<String>();
    let mut found = BTreeSet::new();
    for rest in text.split("crate::").skip(1) {
        match rest.strip_prefix('{') {
            None => {
                found.insert(name(rest));
            }
            Some(group) => {
                let mut depth = 0;
                let mut start = true;
                for (k, c) in group.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => start = true,
                        c if start && c.is_ascii_lowercase() => {
                            found.insert(name(&group[k..]));
                            start = false;
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    found.remove("");
    found
}

#[test]
fn every_room_uses_only_rooms_below_it() {
    let allowed: BTreeMap<&str, BTreeSet<&str>> =
        ROOMS.iter().map(|(room, uses)| (*room, uses.iter().chain(&LEAVES).copied().collect())).collect();
    let mut faults = Vec::new();
    for (room, files) in rooms() {
        let Some(allowed) = allowed.get(room.as_str()) else {
            faults.push(format!("src/{room} is a room that this test does not know"));
            continue;
        };
        for file in files {
            for target in used(&code(&file)) {
                let own = target == room;
                if !own && ROOMS.iter().any(|(name, _)| *name == target) && !allowed.contains(target.as_str()) {
                    faults.push(format!("{} uses {target}", file.display()));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn only_four_rooms_touch_files() {
    outside(&["scene", "raster", "report", "cli"], None, &["std::fs", "File::", "OpenOptions"]);
}

#[test]
fn only_the_command_and_the_cost_study_read_the_clock() {
    outside(&["cli"], Some("analysis/cost/"), &["Instant", "SystemTime"]);
}

/// No file outside the rooms and the folder that are allowed holds any of `words`.
fn outside(allowed: &[&str], folder: Option<&str>, words: &[&str]) {
    let mut faults = Vec::new();
    for (room, files) in rooms() {
        let inside = |file: &Path| folder.is_some_and(|folder| file.to_string_lossy().contains(folder));
        for file in files.iter().filter(|file| !inside(file)) {
            let text = code(file);
            faults.extend(
                words
                    .iter()
                    .filter(|word| !allowed.contains(&room.as_str()) && text.contains(**word))
                    .map(|word| format!("{} has {word}", file.display())),
            );
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn files_stay_short() {
    let tables = ["glyphs.rs"];
    let long = |path: &PathBuf| {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        fs::read_to_string(path).expect("a source").lines().count() > 420 && !tables.contains(&name.as_str())
    };
    let found: Vec<PathBuf> = rooms().into_values().flatten().filter(long).collect();
    assert!(found.is_empty(), "over 420 lines: {found:?}");
}

/// The test of the test: a use of a higher room, plain or in a group, is seen.
#[test]
fn uses_are_recognised() {
    let text = "use crate::{raster, system::{self, Side}};\nfn f() -> crate::vision::Corner {}\nuse crate::num::stats;";
    assert_eq!(used(text), ["num", "raster", "system", "vision"].map(String::from).into());
}

/// The test of the test: a helper of the tests in the middle of a file hides nothing behind it.
#[test]
fn code_behind_a_test_helper_is_seen() {
    let text = "#[cfg(test)]\nmod tests;\nuse crate::num;\n    #[cfg(test)]\n    fn f() {}\nuse crate::render;\n\
                #[cfg(test)]\nmod tests {\n    use crate::cli;\n}\n";
    assert_eq!(used(&code_of(text)), ["num", "render"].map(String::from).into());
}
