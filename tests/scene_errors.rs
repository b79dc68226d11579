//! Is every bad scene told with its line, key, value, rule and next step, and is every hard one accepted?

use crate::command::repository;
use biprism::error::Error;
use biprism::scene::{self, PrismSpec, Scene};
use glam::DVec3;
use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

const PAPER: &str = include_str!("../scenes/paper.toml");

/// A scene as small as it can be.
const SMALL: &str = r#"
name = "small"
[camera]
focal_length_mm = 35
width_px = 64
height_px = 36
pixel_pitch_um = 165
[prism]
kind = "flat"
index = 1.48
ridge_distance_mm = 78.472
thickness_mm = 8.545
[board]
columns = 9
rows = 7
square_mm = 30
position_mm = [0, 0, 1000]
"#;

fn accepted(text: &str) -> Scene {
    scene::parse(text, "test.toml", None).unwrap_or_else(|problem| panic!("{problem}\n{text}"))
}

/// `base` with each `old` replaced by its `new`; every `old` must be there.
fn changed(base: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(base.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old} is not in the scene");
        text.replacen(old, new, 1)
    })
}

/// The line, from 1, that a problem points at.
fn line(problem: &Error) -> usize {
    let (text, span) = problem.source.as_deref().expect("a problem with a scene's text points into it");
    problem.first_line + text[..span.start].matches('\n').count()
}

/// Each file of `tests/bad_scenes` says in its first lines what is to be told of it.
#[test]
fn bad_scenes_are_told_as_their_first_lines_say() {
    let mut files: Vec<PathBuf> =
        fs::read_dir(repository("tests/bad_scenes")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty());
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let wanted = |key: &str| {
            let found = text.lines().find_map(|l| l.strip_prefix("# ")?.strip_prefix(key)?.strip_prefix(' '));
            found.unwrap_or_else(|| panic!("{} lacks its line `# {key}`", file.display())).trim()
        };
        let Err(problem) = scene::load(&file) else { panic!("{} was accepted", file.display()) };
        let told = problem.render(false);
        assert_eq!(problem.place, file.display().to_string());
        assert_eq!(line(&problem).to_string(), wanted("line"), "{told}");
        assert!(problem.rule.contains(wanted("rule")), "{}\nwanted: {}\n{told}", file.display(), wanted("rule"));
        assert!(problem.help.contains(wanted("help")), "{}\nwanted: {}\n{told}", file.display(), wanted("help"));
        assert!(told.contains(&format!("{}:{}:", file.display(), wanted("line"))) && told.contains('^'), "{told}");
    }
}

#[test]
fn files_that_are_no_scene_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let told = |name: &str, bytes: Option<&[u8]>| {
        let path = folder.path().join(name);
        if let Some(bytes) = bytes {
            fs::write(&path, bytes).unwrap();
        }
        let problem = scene::load(&path).unwrap_err();
        assert_eq!(problem.place, path.display().to_string());
        assert!(!problem.help.is_empty());
        problem
    };
    assert!(told("missing.toml", None).rule.contains("missing.toml` cannot be read"));
    assert!(told("", None).rule.contains("is a directory"));
    assert!(told("empty.toml", Some(b"")).rule.contains("is empty"));
    assert!(told("blank.toml", Some(b" \r\n\n\t")).rule.contains("is empty"));
    assert!(told("comment.toml", Some(b"# nothing yet\n")).rule.contains("`name` is missing"));
    let latin = told("latin.toml", Some(b"name = \"caf\xe9\"\n"));
    assert!(latin.rule.contains("not UTF-8 text: byte 11 is 0xe9") && line(&latin) == 1, "{latin}");
    assert!(told("utf16.toml", Some(b"\xff\xfen\0a\0m\0e\0")).rule.contains("not UTF-8"));
    assert!(told("large.toml", Some(&vec![b'#'; (4 << 20) + 1])).rule.contains("at most 4194304"));
}

/// A file that has no length of its own, such as a pipe or a device, is read no further than the limit.
#[cfg(unix)]
#[test]
fn endless_file_is_not_read_to_its_end() {
    assert!(scene::load(Path::new("/dev/zero")).unwrap_err().rule.contains("at most 4194304"));
}

/// A paper scene that was cut anywhere is either told or, cut between its optional tables, still whole.
#[test]
fn truncation_anywhere_is_told() {
    for (end, _) in PAPER.char_indices().filter(|(end, _)| *end < PAPER.find("position_mm").unwrap()) {
        let problem = scene::parse(&PAPER[..end], "cut.toml", None).unwrap_err();
        assert!(!problem.render(false).is_empty());
    }
}

#[test]
fn byte_order_mark_and_windows_line_ends_are_no_hindrance() {
    let plain = accepted(PAPER);
    assert_eq!(accepted(&format!("\u{feff}{PAPER}")), plain);
    assert_eq!(accepted(&PAPER.replace('\n', "\r\n")), plain);
    let text = format!("\u{feff}{}", PAPER.replace("rows = 41", "rows = 0").replace('\n', "\r\n"));
    let problem = scene::parse(&text, "bom.toml", None).unwrap_err();
    let wanted = 1 + PAPER[..PAPER.find("rows = 41").unwrap()].matches('\n').count();
    assert_eq!(line(&problem), wanted);
    // The mark takes no column of the first line.
    let told = scene::parse("\u{feff}nam = 1", "bom.toml", None).unwrap_err().render(false);
    assert!(told.contains("bom.toml:1:1"), "{told}");
}

#[test]
fn defaults_and_units_are_filled_in() {
    let scene = accepted(SMALL);
    let PrismSpec::Flat(prism) = scene.prism else { panic!("the small scene has a flat prism") };
    assert_eq!(scene.camera.pitch_mm, 0.165);
    assert_eq!((prism.body.outer_index, prism.facet_angle_rad), (1.0, None));
    assert!(prism.body.world_from_prism.is_identity());
    assert_eq!((scene.board.margin_mm, scene.board.black, scene.board.white), (30.0, 0.05, 0.85));
    assert_eq!((scene.analysis.depths_mm.as_slice(), scene.analysis.grid), (&[500.0, 1000.0, 2000.0][..], 33));
    let tilted = changed(SMALL, &[("thickness_mm = 8.545", "thickness_mm = 8.545\nfacet_angle_deg = 9")]);
    let PrismSpec::Flat(prism) = accepted(&tilted).prism else { panic!("the tilted scene has a flat prism") };
    assert_eq!(prism.facet_angle_rad, Some(std::f64::consts::PI / 20.0));
}

/// Scenes at the edge of sense, each with a meaning of its own: none may be refused.
#[test]
fn hard_scenes_are_accepted() {
    let thickness = "thickness_mm = 8.545";
    let facet = |angle: &str, rest: &str| format!("{thickness}\nfacet_angle_deg = {angle}\n{rest}");
    let cases: [&[(&str, &str)]; 19] = [
        &[(thickness, &facet("0", ""))],
        &[(thickness, &facet("-0.0", ""))],
        &[(thickness, &facet("1e-300", ""))],
        &[(thickness, &facet("-12", ""))],
        &[(thickness, "thickness_mm = 1e-300\nfacet_angle_deg = 0")],
        &[("index = 1.48", "index = 1"), (thickness, &facet("9", ""))],
        &[("index = 1.48", "index = 1\nouter_index = 1.5"), (thickness, &facet("9", ""))],
        &[("index = 1.48", "index = 1.48\nouter_index = 1.48"), (thickness, &facet("9", ""))],
        &[("index = 1.48", "index = 1\nouter_index = 1.48"), (thickness, &facet("-9", ""))],
        &[("[0, 0, 1000]", "[0, 0, 1e9]")],
        &[("[0, 0, 1000]", "[0, 0, 1000]\ntilt_deg = [0, 90, 0]")],
        &[("[0, 0, 1000]", "[0, 0, 88]\ntilt_deg = [0, 180, 0]")],
        &[("square_mm = 30", "square_mm = 1e-6")],
        &[("square_mm = 30", "square_mm = 30\nmargin_mm = 0")],
        &[("columns = 9", "columns = 100000")],
        &[("columns = 9", "columns = 1"), ("rows = 7", "rows = 1")],
        &[("width_px = 64", "width_px = 1"), ("height_px = 36", "height_px = 1")],
        &[("rows = 7", "rows = 7\nblack = 1\nwhite = 0\nbackground = 0")],
        &[("index = 1.48", "index = 1.48\ntilt_deg = [3, -2, 5]\nposition_mm = [1, 2, 3]")],
    ];
    for changes in cases {
        accepted(&changed(SMALL, changes));
    }
}

/// The facet of the paper's flat prism, z = D + |x| tan(alpha), meets the ray of the picture's edge at
/// z = D / (1 - t tan(alpha)) with t = 1920 x 0.0055 / (2 x 35); the base must lie beyond.
#[test]
fn least_thickness_is_that_of_the_closed_form() {
    let (distance, t) = (78.472, 1920.0 * 0.0055 / 70.0);
    let least = distance / (1.0 - t * libm::tan(9f64.to_radians())) - distance;
    let of = |thickness: f64| {
        let glass = format!("thickness_mm = {thickness}\nfacet_angle_deg = 9");
        changed(PAPER, &[("kind = \"freeform\"", "kind = \"flat\""), ("thickness_mm = 8.545", &glass)])
            .replace("[prism.design]\norder = \"x-then-y\"\ndegree = 5\n", "")
    };
    accepted(&of(least + 1e-9));
    assert!(scene::parse(&of(least - 1e-9), "t", None).unwrap_err().rule.contains("the facet crosses the base"));
}

/// On the axis, glass of index n reflects totally at the base once alpha - asin(sin(alpha) / n) > asin(1 / n).
#[test]
fn total_reflection_begins_at_the_critical_angle() {
    let n = 1.9;
    let inside = |alpha: f64| alpha - libm::asin(libm::sin(alpha) / n) - libm::asin(1.0 / n);
    let (mut low, mut high) = (0.1, 1.5);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if inside(middle) < 0.0 { low = middle } else { high = middle }
    }
    let of = |angle: f64| {
        let glass = format!("thickness_mm = 8.545\nfacet_angle_deg = {}", angle.to_degrees());
        let one_pixel = [("width_px = 64", "width_px = 1"), ("height_px = 36", "height_px = 1")];
        let rest =
            [("pixel_pitch_um = 165", "pixel_pitch_um = 1e-3"), ("1.48", "1.9"), ("thickness_mm = 8.545", &glass)];
        changed(&changed(SMALL, &one_pixel), &rest)
    };
    // The sensor is 1 nm wide, so that its rays keep within 2e-8 rad of the axis.
    accepted(&of(low - 1e-6));
    assert!(scene::parse(&of(low + 1e-6), "t", None).unwrap_err().rule.contains("totally reflected"));
}

#[test]
fn point_cloud_names_files_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let glass = "thickness_mm = 8.545\n";
    let clouds = "[prism.front]\nfile = \"a.csv\"\ndegree = 5\n[prism.back]\nfile = \"b.csv\"\ndegree = 4\n";
    let text =
        changed(SMALL, &[("\"flat\"", "\"point_cloud\""), ("ridge_distance_mm = 78.472\n", ""), (glass, clouds)]);
    let path = folder.path().join("scene.toml");
    fs::write(&path, &text).unwrap();
    fs::write(folder.path().join("a.csv"), "x,y,z\n1,2,3\n").unwrap();
    assert!(scene::load(&path).unwrap_err().rule.contains("`prism.back.file` is \"b.csv\""));
    fs::write(folder.path().join("b.csv"), "x,y,z\n4,5,6\n").unwrap();
    let PrismSpec::PointCloud(prism) = scene::load(&path).unwrap().prism else { panic!("the scene has a point cloud") };
    assert_eq!((prism.front.points_mm, prism.back.degree), (vec![DVec3::new(1.0, 2.0, 3.0)], 4));
    assert!(scene::parse(&text, "t", None).unwrap_err().rule.contains("without a folder"));
}

/// Nested without end in every way that TOML has: told, and the stack holds.
#[test]
fn endless_nesting_is_told() {
    let many = 500_000;
    let keys = vec!["a"; many].join(".");
    for text in [format!("{keys} = 1"), format!("[{keys}]"), format!("a = {}", "[".repeat(many)), "a={".repeat(many)] {
        scene::parse(&text, "deep.toml", None).unwrap_err();
    }
}

/// Every number of an accepted scene is finite, and every length that must be positive is.
fn assert_in_range(scene: &Scene) {
    let camera = &scene.camera;
    assert!(camera.focal_length_mm > 0.0 && camera.pitch_mm > 0.0 && camera.position_mm.is_finite());
    assert!((1..=16384).contains(&camera.width_px) && (1..=16384).contains(&camera.height_px));
    assert!((camera.width_px as f64 * camera.pitch_mm / camera.focal_length_mm).is_finite());
    let board = &scene.board;
    assert!((1..=100_000).contains(&board.columns) && (1..=100_000).contains(&board.rows));
    assert!(board.square_mm > 0.0 && board.margin_mm >= 0.0 && board.world_from_board.translation_mm.is_finite());
    assert!((board.columns as f64 * board.square_mm + 2.0 * board.margin_mm).is_finite());
    assert!([board.black, board.white, board.background].iter().all(|r| (0.0..=1e6).contains(r)));
    assert!((1..=16).contains(&scene.analysis.depths_mm.len()));
    assert!(scene.analysis.depths_mm.iter().all(|d| *d > 0.0 && d.is_finite()));
    let PrismSpec::Freeform(prism, design) = &scene.prism else { panic!("the mutations keep the kind of prism") };
    assert!((0.1..=10.0).contains(&prism.body.index) && (0.1..=10.0).contains(&prism.body.outer_index));
    assert!(prism.ridge_distance_mm > 0.0 && prism.thickness_mm > 0.0 && prism.thickness_mm.is_finite());
    assert!((1..=15).contains(&design.degree) && design.step_px > 0.0);
    let lengths =
        [camera.focal_length_mm, camera.pitch_mm, board.square_mm, prism.ridge_distance_mm, prism.thickness_mm];
    assert!(lengths.iter().chain(&scene.analysis.depths_mm).all(|mm| *mm <= 1e12), "{lengths:?}");
}

/// Parse and print: neither may panic, whatever the text.
fn judged(text: &str) -> Option<Scene> {
    scene::parse(text, "any.toml", None).map_err(|problem| problem.render(true)).ok()
}

fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// The lines of the paper's scene that hold one number.
fn number_lines() -> Vec<usize> {
    let holds = |line: &str| line.split_once(" = ").is_some_and(|(_, v)| v.as_bytes()[0].is_ascii_digit());
    PAPER.lines().enumerate().filter(|(_, line)| holds(line)).map(|(i, _)| i).collect()
}

/// The paper's scene with another number in one line.
fn with_number(chosen: usize, number: &str) -> String {
    let edited = |(i, line): (usize, &str)| match line.split_once(" = ") {
        Some((key, _)) if i == chosen => format!("{key} = {number}\n"),
        _ => format!("{line}\n"),
    };
    PAPER.lines().enumerate().map(edited).collect()
}

/// Every number of the paper's scene at its extremes: refused, or finite and in range.
#[test]
fn extreme_numbers_are_refused_or_in_range() {
    for line in number_lines() {
        for number in
            ["-0.0", "5e-324", "1e-300", "1e13", "1e300", "-1e12", "1e12", "1.0", "inf", "-inf", "nan", "16384"]
        {
            if let Some(scene) = judged(&with_number(line, number)) {
                assert_in_range(&scene);
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn any_text_is_judged(text in proptest::collection::vec(any::<char>(), 0..200)) {
        judged(&text.into_iter().collect::<String>());
    }

    /// Pieces of TOML in any order reach further into the reader than letters do.
    #[test]
    fn any_pieces_of_a_scene_are_judged(pieces in proptest::collection::vec(proptest::sample::select(vec![
        "[", "]", "[[", "]]", "{", "}", "=", ".", ",", "\n", "\"", "'", "#", " ", "-", "1", "0x", "1e999", "nan", "_",
        "name", "camera", "prism", "board", "kind", "terms", "front", "expect", "\"freeform\"", "\u{feff}", "\u{e9}",
        "\n[prism]\n", "\n[camera]\n", "\nkind = \"polynomial\"\n", "\nterms = [[0, 0, 1]]\n", "\r", "\0", "\"\"\"",
    ]), 0..60)) {
        judged(&pieces.concat());
    }

    /// The paper's scene with some characters changed, dropped or doubled.
    #[test]
    fn mutated_paper_is_judged(
        edits in proptest::collection::vec((any::<prop::sample::Index>(), any::<char>(), 0..4u8), 1..6)
    ) {
        let mut letters: Vec<char> = PAPER.chars().collect();
        for (index, letter, edit) in edits {
            let i = index.index(letters.len());
            match edit {
                0 => letters[i] = letter,
                1 => letters.insert(i, letter),
                2 => { letters.remove(i); }
                _ => letters.insert(i, letters[i]),
            }
        }
        if let Some(scene) = judged(&letters.into_iter().collect::<String>()) {
            assert_in_range(&scene);
        }
    }

    /// The paper's scene with one number replaced: refused, or finite and in range.
    #[test]
    fn any_number_is_refused_or_in_range(which in any::<prop::sample::Index>(), number in prop_oneof![
        any::<f64>().prop_map(|x| format!("{x:?}").replace("NaN", "nan")),
        any::<i64>().prop_map(|i| i.to_string()),
        (-3i32..40).prop_map(|i| i.to_string()),
        (-20.0f64..20.0).prop_map(|x| libm::exp10(x).to_string()),
        prop::sample::select(vec!["-0.0", "5e-324", "1e-300", "1e300", "-1e12", "1e12", "1.0", "inf", "-inf", "16384"])
            .prop_map(str::to_owned),
    ]) {
        let places = number_lines();
        if let Some(scene) = judged(&with_number(places[which.index(places.len())], &number)) {
            assert_in_range(&scene);
        }
    }
}
