//! Did any picture or corner move? Each case of `scenes/cases` is a test of its own name.
//!
//! `cargo test --release --test golden prism_flat` holds one case against its golden, `UPDATE_GOLDEN=1` before it writes
//! that golden anew. A case without a golden fails, and so does a golden without a case.

use biprism::golden::{Folders, GoldenOutcome, Mode, case_names, check, check_case, orphans};
use libtest_mimic::{Arguments, Failed, Trial};
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let mut trials = vec![
        Trial::test("no_golden_is_without_a_case", no_golden_is_without_a_case),
        of("a_shift_of_a_twentieth_of_a_pixel_fails", a_shift_of_a_twentieth_of_a_pixel_fails),
        of("a_random_case_is_judged_by_its_mean_and_its_noise", a_random_case_is_judged_by_its_mean_and_its_noise),
        of("a_case_without_a_golden_fails", a_case_without_a_golden_fails),
    ];
    match with_folders(case_names) {
        Ok(names) => trials.extend(names.into_iter().map(|name| Trial::test(name.clone(), move || case(&name)))),
        Err(problem) => {
            eprintln!("{problem}");
            return ExitCode::FAILURE;
        }
    }
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// A test that fails by a panic.
fn of(name: &str, test: fn()) -> Trial {
    Trial::test(name, move || {
        test();
        Ok(())
    })
}

/// The folders of this repository.
fn with_folders<T>(ask: impl FnOnce(&Folders<'_>) -> T) -> T {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    ask(&Folders {
        cases: &root.join("scenes/cases"),
        golden: &root.join("golden"),
        failures: &Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden"),
    })
}

fn case(name: &str) -> Result<(), Failed> {
    let variable = |name: &str| std::env::var(name).ok();
    let mode = Mode::of_variables(variable("UPDATE_GOLDEN").as_deref(), variable("CI").as_deref())?;
    let result = with_folders(|folders| check_case(folders, mode, name))?;
    match result.outcome {
        GoldenOutcome::Failed => Err(result.reasons.join("\n").into()),
        GoldenOutcome::Passed | GoldenOutcome::Updated => Ok(()),
    }
}

fn no_golden_is_without_a_case() -> Result<(), Failed> {
    let found = with_folders(orphans)?;
    if found.is_empty() { Ok(()) } else { Err(format!("delete them, or bring their cases back: {found:?}").into()) }
}

/// The harness itself: a case whose golden is not there is no passed case.
fn a_case_without_a_golden_fails() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folders = Folders {
        cases: &root.join("scenes/cases"),
        golden: &folder.path().join("golden"),
        failures: &folder.path().join("failures"),
    };
    let result = check_case(&folders, Mode::Check, "sensor_tiny").unwrap_or_else(|p| panic!("{p}"));
    assert_eq!(result.outcome, GoldenOutcome::Failed);
}

/// The harness itself: one square moved by 0.05 px must fail.
fn a_shift_of_a_twentieth_of_a_pixel_fails() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let cases = folder.path().join("cases");
    std::fs::create_dir(&cases).expect("a folder");
    let text = std::fs::read_to_string(root.join("scenes/cases/prism_flat.toml")).expect("the case is there");
    // A pixel sees 33 um / 35 mm of 1000 mm, less the glass: 0.05 px are about 0.047 mm on the board.
    let moved = text.replace("position_mm = [0.0, 0.0, 1000.0]", "position_mm = [0.047, 0.0, 1000.0]");
    assert_ne!(text, moved);
    std::fs::write(cases.join("prism_flat.toml"), moved).expect("written");
    let golden = folder.path().join("golden");
    std::fs::create_dir(&golden).expect("a folder");
    for ending in ["png", "json"] {
        let name = format!("prism_flat.{ending}");
        std::fs::copy(root.join("golden").join(&name), golden.join(&name)).expect("the golden is there");
    }
    let failures = folder.path().join("failures");
    let report = check(&Folders { cases: &cases, golden: &golden, failures: &failures }, Mode::Check);
    let report = report.unwrap_or_else(|p| panic!("{p}"));
    assert!(!report.passed());
    let shift = report.cases[0].record.as_ref().and_then(|r| r.largest_shift.clone()).expect("corners moved");
    assert!((0.03..0.08).contains(&shift.px), "{shift:?}");
    assert!(failures.join("prism_flat.strip.png").exists());
}

/// A case with noise: other frames pass; another specimen, a shift of 0.05 px, stronger read noise, and any parameter of the
/// noise that is 3 % off, do not.
fn a_random_case_is_judged_by_its_mean_and_its_noise() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("scenes/cases/effect_sensor.toml")).expect("the case is there");
    let judged = |old: &str, new: &str| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (cases, golden) = (folder.path().join("cases"), folder.path().join("golden"));
        std::fs::create_dir(&cases).and_then(|()| std::fs::create_dir(&golden)).expect("two folders");
        assert!(text.contains(old));
        std::fs::write(cases.join("effect_sensor.toml"), text.replace(old, new)).expect("written");
        for ending in ["png", "json"] {
            let name = format!("effect_sensor.{ending}");
            std::fs::copy(root.join("golden").join(&name), golden.join(&name)).expect("the golden is there");
        }
        let failures = folder.path().join("failures");
        let report = check(&Folders { cases: &cases, golden: &golden, failures: &failures }, Mode::Check);
        report.unwrap_or_else(|p| panic!("{p}"))
    };
    let later = judged("seed = 1\n", "seed = 1\nframe = 4000000\n");
    assert!(later.passed(), "{later}");
    let other = judged("seed = 1\n", "seed = 2\n").cases[0].reasons.join("\n");
    assert!(other.contains("the light of the region"), "another specimen: {other}");
    // What is true of the scene is judged exactly, and moves too; the light must tell by itself.
    let moved = judged("[0.0, 0.0, 1000.0]", "[0.047, 0.0, 1000.0]").cases[0].reasons.join("\n");
    assert!(moved.contains("the light of the region"), "{moved}");
    let noisier = judged("read_noise_e = 8.0", "read_noise_e = 20.0").cases[0].reasons.join("\n");
    assert!(noisier.contains("the variance of the region") && !noisier.contains("the light of"), "{noisier}");
    for (key, value, figure) in [
        ("white_e", 2000.0, "the light of the region"),
        ("prnu", 0.02, "pattern of all bright"),
        ("dark_e", 10.0, "light of all dark"),
        ("dsnu_e", 5.0, "pattern of all dark"),
        ("read_noise_e", 8.0, "variance of all dark"),
    ] {
        for factor in [0.97, 1.03] {
            let told = judged(&format!("{key} = {value:?}"), &format!("{key} = {:?}", value * factor));
            let reasons = told.cases[0].reasons.join("\n");
            assert!(reasons.contains(figure), "{key} times {factor}: {reasons}");
        }
    }
}
