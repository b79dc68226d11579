//! Does the harness fail when it must? Cases are rendered by a stand-in: one vertical edge at the place that the case
//! file states, and its corner.

use super::record::Tolerance;
use super::*;
use crate::error::Error;
use crate::io::png;
use crate::raster::Raster;
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};

struct Room {
    root: tempfile::TempDir,
    request: GoldenRequest,
}

impl Room {
    /// Two cases with their goldens.
    fn new() -> Self {
        let room = Self { root: tempfile::tempdir().unwrap(), request: GoldenRequest::default() };
        fs::create_dir(room.folder("cases")).unwrap();
        room.case("one", 7.3);
        room.case("two", 4.8);
        let report = room.run(Mode::Update, &|output| output);
        assert!(report.cases.iter().all(|case| case.outcome == GoldenOutcome::Updated));
        assert!(room.check(&|output| output).passed());
        room
    }

    fn folder(&self, name: &str) -> PathBuf {
        self.root.path().join(name)
    }

    fn case(&self, name: &str, edge_px: f64) {
        fs::write(self.folder("cases").join(format!("{name}.toml")), edge_px.to_string()).unwrap();
    }

    fn golden(&self, name: &str) -> PathBuf {
        self.folder("golden").join(name)
    }

    fn evidence(&self, name: &str) -> PathBuf {
        self.folder("failures").join(name)
    }

    fn run(&self, mode: Mode, change: &dyn Fn(GoldenOutput) -> GoldenOutput) -> GoldenReport {
        let (cases, golden, failures) = (self.folder("cases"), self.folder("golden"), self.folder("failures"));
        let folders = Folders { cases: &cases, golden: &golden, failures: &failures };
        run(&folders, mode, &self.request, &tolerance, &|path| render(path).map(change)).unwrap()
    }

    fn check(&self, change: &dyn Fn(GoldenOutput) -> GoldenOutput) -> GoldenReport {
        self.run(Mode::Check, change)
    }
}

fn tolerance(path: &str) -> Tolerance {
    if path.ends_with("_px") { Tolerance::Px(1e-9) } else { Tolerance::Exact }
}

/// White left of the edge, black right of it, the pixel that it crosses by area.
fn render(path: &Path) -> Result<GoldenOutput, Error> {
    let text = fs::read_to_string(path).unwrap();
    let edge: f64 =
        text.parse().map_err(|_| Error::new(path.display(), format!("{text} is no number"), "write one"))?;
    let light = (0..16 * 12).map(|k| (edge - f64::from(k % 16)).clamp(0.0, 1.0) as f32).collect();
    let record = json!({"found": 1, "corners": [{"x_px": edge, "y_px": 6.0}], "fates": {"missed": 0}});
    Ok(GoldenOutput { picture: Raster::from_data(16, 12, light), record, noise: None })
}

fn reasons(report: &GoldenReport, name: &str) -> String {
    report.cases.iter().find(|case| case.name == name).unwrap().reasons.join("\n")
}

#[test]
fn one_changed_pixel_fails_and_leaves_a_strip() {
    let room = Room::new();
    let level = 1.0 / 65535.0;
    for change in [-1.02 * level, 1.02 * level, f64::NAN] {
        let report = room.check(&|mut output| {
            let light = &mut output.picture.data_mut()[5 * 16 + 4];
            *light = (f64::from(*light) + change) as f32;
            output
        });
        assert!(!report.passed());
        assert!(reasons(&report, "one").starts_with("1 of 192 pixels changed"), "{report}");
        assert!(reasons(&report, "one").contains("(4, 5)"), "{report}");
    }
    let strip = png::read(&room.evidence("one.strip.png"), None).unwrap().0;
    assert_eq!((strip.width(), strip.height()), (3 * 16 + 2 * 4, 12));
    assert!(fs::read_to_string(room.evidence("one.diff.txt")).unwrap().contains("expected | difference x"));
    // The evidence goes when the case passes again.
    assert!(room.check(&|output| output).passed());
    assert!(!room.evidence("one.strip.png").exists() && !room.evidence("one.diff.txt").exists());
}

#[test]
fn rounding_noise_passes() {
    let room = Room::new();
    let noise = |mut output: GoldenOutput| {
        output.picture = output.picture.map(|light| light.next_down().max(0.0));
        output.record["corners"][0]["y_px"] = json!(6.0 + 5e-10);
        output
    };
    assert!(room.check(&noise).passed());
}

#[test]
fn an_edge_that_moves_by_a_twentieth_of_a_pixel_fails_by_picture_and_by_corner() {
    let room = Room::new();
    room.case("one", 7.35);
    let report = room.check(&|output| output);
    let case = &report.cases[0];
    assert_eq!(case.outcome, GoldenOutcome::Failed);
    assert_eq!(report.cases[1].outcome, GoldenOutcome::Passed);
    // The edge crosses one pixel of each of 12 rows, whose light changes by 0.05.
    let picture = case.picture.as_ref().unwrap();
    assert_eq!(picture.over_threshold, 12);
    assert!((picture.max_abs - 0.05).abs() < PIXEL_TOLERANCE);
    let shift = case.record.as_ref().unwrap().largest_shift.as_ref().unwrap();
    assert!((shift.px - 0.05).abs() < 1e-12 && shift.path == "/corners/0");
    let text = fs::read_to_string(room.evidence("one.diff.txt")).unwrap();
    assert!(text.contains("largest corner shift: 5.000e-2 px at /corners/0"), "{text}");
    // Either of the two is enough.
    let original = Room::new();
    let only_picture = original.check(&|output| GoldenOutput { picture: shifted(), ..output });
    assert!(!only_picture.passed() && reasons(&only_picture, "one").starts_with("12 of"));
    let only_record = original.check(&|mut output| {
        output.record["corners"][0]["x_px"] = json!(7.35);
        output
    });
    assert!(!only_record.passed() && only_record.cases[0].picture.as_ref().unwrap().passes());
}

fn shifted() -> Raster<f32> {
    Raster::from_data(16, 12, (0..192).map(|k| (7.35 - f64::from(k % 16)).clamp(0.0, 1.0) as f32).collect())
}

#[test]
fn a_changed_count_fails() {
    let room = Room::new();
    let report = room.check(&|mut output| {
        output.record["found"] = json!(2);
        output
    });
    assert_eq!(reasons(&report, "two"), "/found was 1 and is 2");
}

#[test]
fn a_missing_or_damaged_golden_fails_and_is_not_made_up() {
    let room = Room::new();
    fs::remove_file(room.golden("one.png")).unwrap();
    fs::remove_file(room.golden("two.json")).unwrap();
    let report = room.check(&|output| output);
    assert!(reasons(&report, "one").contains("no golden picture"));
    assert!(reasons(&report, "two").contains("cannot be read"));
    assert!(!room.golden("one.png").exists() && !room.golden("two.json").exists());

    fs::write(room.golden("one.png"), b"no picture").unwrap();
    fs::write(room.golden("two.json"), b"{").unwrap();
    let report = room.check(&|output| output);
    assert!(reasons(&report, "one").contains("damaged"));
    assert!(reasons(&report, "two").contains("no JSON"));
}

#[test]
fn a_golden_without_a_case_fails() {
    let room = Room::new();
    fs::remove_file(room.folder("cases").join("two.toml")).unwrap();
    let report = room.run(Mode::Update, &|output| output);
    assert_eq!(report.orphans, ["two.json", "two.png"]);
    assert!(!report.passed());
    assert!(room.golden("two.png").exists(), "nothing is deleted");
}

#[test]
fn a_picture_of_another_size_fails_with_a_strip() {
    let room = Room::new();
    let report = room.check(&|output| GoldenOutput { picture: Raster::filled(8, 12, 0.5), ..output });
    assert!(reasons(&report, "one").contains("16 x 12 and 8 x 12"));
    assert!(room.evidence("one.strip.png").exists());
}

#[test]
fn an_update_rewrites_failing_goldens_only() {
    let room = Room::new();
    room.case("one", 9.1);
    // A passing golden in another spelling shows whether it is written.
    let spelled = fs::read_to_string(room.golden("two.json")).unwrap() + "\n\n";
    fs::write(room.golden("two.json"), &spelled).unwrap();
    let report = room.run(Mode::Update, &|output| output);
    assert!(report.passed());
    assert_eq!((report.cases[0].outcome, report.cases[1].outcome), (GoldenOutcome::Updated, GoldenOutcome::Passed));
    assert_eq!(fs::read_to_string(room.golden("two.json")).unwrap(), spelled);
    assert!(room.check(&|output| output).passed());
}

#[test]
fn what_cannot_be_rendered_or_kept_fails_even_on_update() {
    let room = Room::new();
    let before = fs::read(room.golden("one.png")).unwrap();
    let report = room.run(Mode::Update, &|output| GoldenOutput { picture: output.picture.map(|v| 2.0 * v), ..output });
    assert!(!report.passed() && reasons(&report, "one").contains("leaves the range"));
    fs::write(room.folder("cases").join("one.toml"), "seven").unwrap();
    let report = room.run(Mode::Update, &|output| output);
    assert!(!report.passed() && reasons(&report, "one").contains("seven is no number"));
    assert_eq!(fs::read(room.golden("one.png")).unwrap(), before);
}

#[test]
fn an_update_must_be_asked_for_and_never_where_ci_is_set() {
    assert_eq!(Mode::of_variables(None, None), Ok(Mode::Check));
    assert_eq!(Mode::of_variables(Some("0"), Some("true")), Ok(Mode::Check));
    assert_eq!(Mode::of_variables(Some("1"), None), Ok(Mode::Update));
    assert!(Mode::of_variables(Some("1"), Some("true")).unwrap_err().rule.contains("CI"));
    assert!(Mode::of_variables(Some("yes"), None).is_err());
}

#[test]
fn a_folder_of_goldens_that_is_not_there_is_told_once() {
    let room = Room::new();
    fs::remove_dir_all(room.folder("golden")).unwrap();
    let report = room.check(&|_| panic!("nothing is rendered"));
    assert!(!report.passed() && report.cases.is_empty());
    let told = report.to_string();
    assert!(
        told.lines().count() == 3
            && told.contains("UPDATE_GOLDEN=1 biprism golden")
            && told.contains("no such folder")
            && told.contains("2 cases"),
        "{told}"
    );
    assert!(room.run(Mode::Update, &|output| output).passed());
}

/// One case alone is rendered, judged and rewritten; a name that there is not is told with those that there are.
#[test]
fn named_cases_are_judged_and_rewritten_alone() {
    let mut room = Room::new();
    let before = fs::read(room.golden("two.png")).unwrap();
    room.case("one", 9.1);
    room.case("two", 3.3);
    room.request.only = vec!["one.toml".to_owned()];
    let named = |report: &GoldenReport| report.cases.iter().map(|case| case.name.clone()).collect::<Vec<_>>();
    let report = room.check(&|output| output);
    assert!(!report.passed() && named(&report) == ["one"]);
    let report = room.run(Mode::Update, &|output| output);
    assert!(report.passed() && named(&report) == ["one"], "{report}");
    assert!(room.check(&|output| output).passed() && fs::read(room.golden("two.png")).unwrap() == before);
    room.request.only = vec!["onne".to_owned()];
    let (cases, golden, failures) = (room.folder("cases"), room.folder("golden"), room.folder("failures"));
    let folders = Folders { cases: &cases, golden: &golden, failures: &failures };
    let told = run(&folders, Mode::Check, &room.request, &tolerance, &render).unwrap_err();
    assert!(told.rule.contains("\"onne\"") && told.help.ends_with("one, two"), "{told}");
    assert!(Mode::of_named(None) == Ok(Mode::Update) && Mode::of_named(Some("1")).unwrap_err().place == "--bless");
}

/// A golden that is not there: one sentence with the next step, and the picture to look at.
#[test]
fn a_case_without_a_golden_says_how_to_keep_it() {
    let room = Room::new();
    room.case("three", 5.5);
    let report = room.check(&|output| output);
    assert!(reasons(&report, "three").ends_with("keep it with --bless three"), "{report}");
    assert_eq!(reasons(&report, "three").lines().count(), 1);
    let (picture, _) = png::read(&room.evidence("three.actual.png"), None).unwrap();
    assert!((picture.get(5, 0) - 0.5).abs() < 1e-4);
    assert!(room.run(Mode::Update, &|output| output).passed());
    assert!(!room.evidence("three.actual.png").exists());
}

/// An edge that moves by 0.05 px changes a pixel of each row by 0.05 of full scale: both must be allowed, each by its own
/// tolerance, and a hair less is not enough.
#[test]
fn tolerances_allow_what_they_say() {
    let mut room = Room::new();
    room.case("one", 7.35);
    for (px, grey, passes) in
        [(0.0501, 0.0501, true), (0.0499, 0.0501, false), (0.0501, 0.0499, false), (0.0, 0.0, false)]
    {
        (room.request.slack_px, room.request.slack_grey) = (px, grey);
        assert_eq!(room.check(&|output| output).passed(), passes, "{px} px, {grey}");
    }
    // Work is not held where corners may move; what was found still is.
    let changed = |key: &'static str| {
        move |mut output: GoldenOutput| {
            output.record[key] = json!({"rays": 7});
            output
        }
    };
    room.case("one", 7.3);
    room.request.slack_grey = 0.0;
    for (px, passes) in [(0.0, false), (1e-3, true)] {
        room.request.slack_px = px;
        assert!(room.run(Mode::Update, &|o| changed("counts")(o)).passed());
        let more = |output| {
            let mut output = changed("counts")(output);
            output.record["counts"]["rays"] = json!(8);
            output
        };
        assert_eq!(room.check(&more).passed(), passes, "{px}");
        let found = |output| {
            let mut output = changed("counts")(output);
            output.record["found"] = json!(2);
            output
        };
        assert!(!room.check(&found).passed());
    }
}

#[test]
fn a_folder_without_cases_is_a_problem() {
    let root = tempfile::tempdir().unwrap();
    let missing = root.path().join("none");
    for cases in [root.path(), &missing] {
        let folders = Folders { cases, golden: cases, failures: cases };
        assert!(run(&folders, Mode::Check, &GoldenRequest::default(), &tolerance, &render).is_err());
    }
}

/// The stand-in's picture with noise of 1 %, drawn from a seed.
fn noisy(output: &GoldenOutput, seed: u64) -> GoldenOutput {
    let draw = |replicate: u64, k: usize| {
        let normal = crate::num::deviates::Stream::new(seed + replicate, 0, 0, k as u32).normals()[0];
        0.2 + 0.5 * output.picture.data()[k] + 0.01 * normal as f32
    };
    let picture = |r: u64| Raster::from_data(16, 12, (0..192).map(|k| draw(r, k)).collect());
    let pictures: Vec<_> = (0..noise::REPLICATES as u64).map(picture).collect();
    let quiet = output.picture.map(|value| 0.2 + 0.5 * value);
    GoldenOutput::of_random(&pictures, &quiet, output.record.clone())
}

#[test]
fn random_pictures_are_judged_by_mean_and_variance() {
    let room = Room::new();
    assert!(room.run(Mode::Update, &|output| noisy(&output, 1)).passed());
    let golden = fs::read(room.golden("one.json")).unwrap();
    for seed in [1, 1000, 2000] {
        let report = room.check(&|output| noisy(&output, seed));
        assert!(report.passed(), "{report}");
    }
    // An edge that moves by 0.05 px; a deterministic picture; a changed count: each fails.
    room.case("one", 7.35);
    let moved = room.check(&|output| noisy(&output, 3000));
    assert!(reasons(&moved, "one").contains("the light of the region at pixel (0, 0)"), "{moved}");
    assert!(room.evidence("one.strip.png").exists() && !reasons(&moved, "one").contains("pixels changed"));
    room.case("one", 7.3);
    assert!(!room.check(&|output| output).passed());
    let count = room.check(&|mut output| {
        output.record["found"] = json!(2);
        noisy(&output, 1)
    });
    assert_eq!(reasons(&count, "one"), "/found was 1 and is 2");
    // A case that becomes random has no noise in its golden.
    let deterministic = Room::new();
    assert!(reasons(&deterministic.check(&|o| noisy(&o, 1)), "one").contains("no noise to compare with"));
    assert_eq!(fs::read(room.golden("one.json")).unwrap(), golden);
}
