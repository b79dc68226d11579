//! Do the walls stand? Each rule takes the sources and tells its faults, and has a test with a text that breaks it.

mod source;

use source::{Source, bare, files, of_texts, paths, resolved, sources};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The rooms, each with the rooms that it uses, all of them above it in this list: so no room uses itself by a detour.
/// The list is the smallest that holds: a use that is not in it is a fault, and so is one of it that nobody has.
const ROOMS: [(&str, &[&str]); 23] = [
    ("error", &[]),
    ("accuracy", &[]),
    ("progress", &[]),
    ("num", &[]),
    ("geom", &[]),
    ("optics", &["num"]),
    ("surface", &["num", "geom", "optics"]),
    ("raster", &["error", "num"]),
    ("texture", &["num", "raster"]),
    ("vision", &["num", "raster"]),
    ("metrics", &["num", "geom"]),
    ("io", &["error", "geom", "surface", "raster", "vision"]),
    ("plot", &["num", "geom", "raster", "io"]),
    ("effect", &["num", "geom", "optics", "surface", "raster"]),
    ("scene", &["error", "accuracy", "num", "geom", "optics", "surface", "raster", "texture", "io", "effect"]),
    ("design", &["error", "num", "geom", "optics", "surface", "scene"]),
    ("prism", &["num", "geom", "optics", "surface", "effect", "scene", "design"]),
    (
        "system",
        &["error", "accuracy", "num", "geom", "optics", "surface", "texture", "effect", "scene", "design", "prism"],
    ),
    (
        "render",
        &[
            "accuracy", "progress", "num", "geom", "optics", "surface", "raster", "texture", "effect", "scene",
            "prism", "system",
        ],
    ),
    (
        "analysis",
        &[
            "error", "accuracy", "progress", "num", "geom", "optics", "surface", "raster", "vision", "metrics", "io",
            "effect", "scene", "design", "prism", "system", "render",
        ],
    ),
    ("golden", &["error", "num", "raster", "metrics", "io", "scene", "system", "render", "analysis"]),
    (
        "report",
        &[
            "error", "accuracy", "progress", "num", "geom", "optics", "surface", "raster", "vision", "metrics", "plot",
            "io", "effect", "scene", "system", "render", "analysis",
        ],
    ),
    (
        "cli",
        &[
            "error", "accuracy", "progress", "surface", "raster", "vision", "metrics", "plot", "io", "effect", "scene",
            "design", "system", "render", "analysis", "golden", "report",
        ],
    ),
];

/// What opens files, besides `io` and `cli`, and why.
const OPENS_FILES: [&str; 4] = [
    "io/",
    "cli/",
    // The text of a scene, of which errors quote lines.
    "scene/document.rs",
    // Goldens are folders of files.
    "golden/cases.rs",
];
/// What reads the clock.
const READS_THE_CLOCK: [&str; 2] = ["cli/", "analysis/cost/"];

/// No file has more lines than this.
const LINES: usize = 400;
/// Files that are longer, and why.
const LONG: [&str; 4] = [
    // Outlines of letters: data.
    "plot/glyphs.rs",
    // The keys of a scene file in one place, each with its meaning.
    "scene/schema.rs",
    // One hot kernel each, which to cut would cost inlining.
    "prism/packet.rs",
    "render/map.rs",
];

/// Type names that stand more than once, and why.
const TWICE: [&str; 1] = [
    // A surface that refracts, and which of two a point cloud is of.
    "Surface",
];

#[test]
fn every_room_uses_only_rooms_below_it() {
    none(room_faults(&sources()));
}

#[test]
fn only_io_and_the_command_open_files() {
    none(word_faults(&sources(), &["std::fs", "fs::", "File::open", "File::create", "OpenOptions"], &OPENS_FILES));
}

#[test]
fn only_the_command_and_the_cost_study_read_the_clock() {
    none(word_faults(&sources(), &["Instant", "SystemTime"], &READS_THE_CLOCK));
}

#[test]
fn no_files_import_each_other() {
    none(circle_faults(&sources()));
}

#[test]
fn no_child_imports_from_the_face_above_it() {
    none(upward_faults(&sources()));
}

#[test]
fn files_stay_short() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let lines = ["src", "tests"].iter().flat_map(|folder| files(&root.join(folder))).map(|path| {
        let place = path.strip_prefix(root).expect("inside").to_string_lossy().replace('\\', "/");
        (place, fs::read_to_string(&path).expect("a source file").lines().count())
    });
    none(long_faults(&lines.collect::<Vec<_>>()));
}

#[test]
fn a_type_name_stands_once() {
    none(name_faults(&sources()));
}

fn none(faults: Vec<String>) {
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Uses of rooms that [`ROOMS`] does not have, and uses of it that nobody has. A test may use all rooms before its own.
fn room_faults(sources: &[Source]) -> Vec<String> {
    let (mut faults, mut used) = (Vec::new(), BTreeSet::new());
    for source in sources {
        let Some(place) = ROOMS.iter().position(|(room, _)| *room == source.room()) else {
            faults.push(format!("{} lies in a room that this test does not know", source.path));
            continue;
        };
        let (room, allowed) = ROOMS[place];
        for target in rooms_used(&source.product) {
            if target != room && !allowed.contains(&target.as_str()) {
                faults.push(format!("{} uses {target}", source.path));
            }
            used.insert((room, target));
        }
        for target in rooms_used(&source.tests) {
            if !ROOMS[..=place].iter().any(|(below, _)| *below == target) {
                faults.push(format!("a test of {} uses {target}", source.path));
            }
        }
    }
    for (room, allowed) in ROOMS.iter().filter(|(room, _)| sources.iter().any(|s| s.room() == *room)) {
        let idle = allowed.iter().filter(|target| !used.contains(&(room, (**target).to_owned())));
        faults.extend(idle.map(|target| format!("{room} no longer uses {target}: take it from the list")));
    }
    faults
}

/// The rooms named after `crate::` in a bare text.
fn rooms_used(bare: &str) -> BTreeSet<String> {
    let of_crate = paths(bare).into_iter().filter(|path| path[0] == "crate");
    of_crate.filter_map(|path| path.get(1).cloned()).filter(|name| ROOMS.iter().any(|(room, _)| room == name)).collect()
}

/// Words in products outside of the places that may have them.
fn word_faults(sources: &[Source], words: &[&str], allowed: &[&str]) -> Vec<String> {
    let outside = sources.iter().filter(|source| !allowed.iter().any(|place| source.path.starts_with(place)));
    let has = |source: &Source| {
        let found = words.iter().filter(|word| source.product.contains(**word));
        found.map(|word| format!("{} has {word}", source.path)).collect::<Vec<_>>()
    };
    outside.flat_map(has).collect()
}

/// The modules of the product, each with those that it names; a face names its children too.
fn imports(sources: &[Source]) -> BTreeMap<Vec<String>, BTreeSet<Vec<String>>> {
    let built = || sources.iter().filter(|source| !source.product.is_empty());
    let known: BTreeSet<Vec<String>> = built().map(|source| source.module.clone()).collect();
    let named = |source: &Source| {
        let paths = paths(&source.product).into_iter().chain(of_children(&source.product));
        let all = paths.filter_map(|path| resolved(&path, &source.module, &known));
        all.filter(|target| *target != source.module).collect()
    };
    built().map(|source| (source.module.clone(), named(source))).collect()
}

/// The paths of `use child::Thing` and `pub use child::Thing` of a face.
fn of_children(bare: &str) -> Vec<Vec<String>> {
    let uses = bare.match_indices("use ").map(|(at, word)| &bare[at + word.len()..]);
    let first = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let names = uses.map(first).filter(|name| !["", "crate", "super", "self"].contains(&name.as_str()));
    names.map(|name| vec!["self".to_owned(), name]).collect()
}

/// Modules that import themselves by way of others.
fn circle_faults(sources: &[Source]) -> Vec<String> {
    let imports = imports(sources);
    let reached = |from: &Vec<String>| {
        let (mut seen, mut next) = (BTreeSet::new(), vec![from]);
        while let Some(module) = next.pop() {
            next.extend(imports.get(module).into_iter().flatten().filter(|target| seen.insert((*target).clone())));
        }
        seen
    };
    let all: BTreeMap<&Vec<String>, BTreeSet<Vec<String>>> = imports.keys().map(|m| (m, reached(m))).collect();
    let circles = all.iter().filter(|(module, reached)| reached.contains(**module));
    circles
        .map(|(module, reached)| {
            let others = reached.iter().filter(|other| other != module && all[other].contains(*module));
            let others: Vec<String> = others.map(|other| other.join("::")).collect();
            format!("{} is in a circle with {}", module.join("::"), others.join(", "))
        })
        .collect()
}

/// Modules that import what a face above them in their own room has, and not its file.
fn upward_faults(sources: &[Source]) -> Vec<String> {
    let upward = |(module, named): (Vec<String>, BTreeSet<Vec<String>>)| {
        let above = named.into_iter().filter(|target| module.starts_with(target)).collect::<Vec<_>>();
        above.into_iter().map(move |face| format!("{} imports from {} above it", module.join("::"), face.join("::")))
    };
    imports(sources).into_iter().flat_map(upward).collect()
}

/// Files, by path and count of lines, that are too long; and exceptions that are none.
fn long_faults(lines: &[(String, usize)]) -> Vec<String> {
    let excepted = |path: &str| LONG.iter().any(|long| path == format!("src/{long}"));
    let long = lines.iter().filter(|(path, count)| *count > LINES && !excepted(path));
    long.map(|(path, count)| format!("{path} has {count} lines, and may have {LINES}")).collect()
}

/// Names of types that stand in two places.
fn name_faults(sources: &[Source]) -> Vec<String> {
    let mut places: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for source in sources {
        for line in source.product.lines() {
            let words: Vec<&str> = line.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
            let open = !line.starts_with(char::is_whitespace);
            let kind = words.iter().position(|word| ["struct", "enum", "trait", "union"].contains(word));
            if let (true, Some(name)) = (open, kind.and_then(|kind| words.get(kind + 1))) {
                places.entry(name).or_default().push(&source.path);
            }
        }
    }
    let twice = places.into_iter().filter(|(name, places)| places.len() > 1 && !TWICE.contains(name));
    twice.map(|(name, places)| format!("{name} stands in {}", places.join(" and in "))).collect()
}

/// The test of the test: uses are seen in plain paths and in groups, of products and of tests; a room that no one knows,
/// and a use that nobody has.
#[test]
fn a_wrong_use_of_a_room_is_seen() {
    let faults = |path: &str, text: &str| room_faults(&of_texts(&[(path, text)])).join("; ");
    let told = faults("num/a.rs", "use crate::{geom, system::{self, Side}};\nfn f() -> crate::vision::Corner {}\n");
    assert_eq!(told, "num/a.rs uses geom; num/a.rs uses system; num/a.rs uses vision");
    assert_eq!(faults("num/a.rs", "// crate::cli\nconst A: &str = \"crate::cli\";\nuse crate::num::b;\n"), "");
    let tests = "#[cfg(test)]\nmod tests {\n    use crate::cli;\n}\nuse crate::render;\n";
    assert_eq!(faults("num/a.rs", tests), "num/a.rs uses render; a test of num/a.rs uses cli");
    assert_eq!(faults("num/a_tests.rs", "use crate::cli;"), "a test of num/a_tests.rs uses cli");
    assert!(faults("cellar/a.rs", "").contains("does not know"));
    assert!(faults("optics/a.rs", "").contains("optics no longer uses num"));
    let helper = [("num/mod.rs", "#[cfg(test)]\npub(crate) mod samples;\n"), ("num/samples.rs", "use crate::cli;")];
    assert_eq!(room_faults(&of_texts(&helper)), ["a test of num/samples.rs uses cli"]);
    // The list itself goes downwards.
    for (k, (room, uses)) in ROOMS.iter().enumerate() {
        assert!(uses.iter().all(|target| ROOMS[..k].iter().any(|(below, _)| below == target)), "{room}");
    }
}

#[test]
fn a_file_that_is_opened_and_a_clock_that_is_read_are_seen() {
    let told = |path: &str| word_faults(&of_texts(&[(path, "use std::fs;\n")]), &["std::fs"], &OPENS_FILES);
    assert_eq!(told("num/a.rs"), ["num/a.rs has std::fs"]);
    assert!(told("io/a.rs").is_empty());
    let clock = of_texts(&[("num/a.rs", "fn f() {\n    let now = Instant::now(); // Instant\n}\n")]);
    assert_eq!(word_faults(&clock, &["Instant"], &READS_THE_CLOCK), ["num/a.rs has Instant"]);
}

#[test]
fn a_circle_of_imports_is_seen() {
    let circle = [
        ("num/mod.rs", "mod a;\nmod b;\npub use a::A;\n"),
        ("num/a.rs", "use super::b::B;\n"),
        ("num/b.rs", "use crate::num::{a::A};\n#[cfg(test)]\nmod tests {\n    use super::*;\n}\n"),
    ];
    assert_eq!(
        circle_faults(&of_texts(&circle)),
        ["num::a is in a circle with num::b", "num::b is in a circle with num::a"]
    );
    // A child that imports from its face, which names it.
    let face = [("num/mod.rs", "mod a;\npub use a::A;\n"), ("num/a.rs", "use super::A;\n")];
    assert_eq!(circle_faults(&of_texts(&face)).len(), 2);
    assert_eq!(upward_faults(&of_texts(&face)), ["num::a imports from num above it"]);
    let through = [
        ("num/mod.rs", "mod a;\nmod b;\npub use a::A;\n"),
        ("num/a.rs", "use super::b::A;\n"),
        ("num/b.rs", "pub struct A;\n"),
    ];
    assert!(circle_faults(&of_texts(&through)).is_empty() && upward_faults(&of_texts(&through)).is_empty());
}

#[test]
fn a_long_file_and_a_name_of_two_types_are_seen() {
    let lines = [("src/num/a.rs", 401), ("src/num/b.rs", 400), ("src/plot/glyphs.rs", 2000), ("tests/a.rs", 999)];
    let told = long_faults(&lines.map(|(path, count)| (path.to_owned(), count)));
    assert_eq!(told, ["src/num/a.rs has 401 lines, and may have 400", "tests/a.rs has 999 lines, and may have 400"]);
    let types = [("num/a.rs", "pub struct Fit<T>(T);\n"), ("num/b.rs", "pub(crate) enum Fit {}\n    struct Own;\n")];
    assert_eq!(name_faults(&of_texts(&types)), ["Fit stands in num/a.rs and in num/b.rs"]);
}

#[test]
fn comments_and_literals_hold_no_code() {
    let text =
        "let a = \"x // \\\" {\"; // {\nlet b = '{'; let c = '\\''; fn f<'a>(x: &'a str) {}\nlet d = r#\"}\"{\"#;\n";
    assert_eq!(bare(text), "let a = \"\"; \nlet b = ' '; let c = ' '; fn f<'a>(x: &'a str) {}\nlet d = \"\";\n");
}
