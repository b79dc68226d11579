//! Goldens: pictures and numbers that were judged right once and must not move.
//!
//! Each case is a scene `<case>.toml`; its golden is `<case>.png` (16-bit grey, linear) and `<case>.json` (numbers) in
//! another folder. A case without a golden fails, and so does a golden without a case. A failing case leaves
//! `<case>.strip.png` (expected | difference | actual) and `<case>.diff.txt` in a third folder.
//!
//! What is random is drawn several times with different seeds; the golden picture is then the mean, and means and
//! variances are judged region by region ([`noise`]). Everything else must be as it was.

pub mod noise;
pub mod record;

use crate::problem::Problem;
use crate::raster::compare::{self, Difference};
use crate::raster::safe::write_bytes;
use crate::raster::transfer::Transfer;
use crate::raster::{Notes, Raster, png};
use noise::Regions;
use record::{RecordDifference, Tolerance};
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

/// A pixel may be this far, in linear light, from its golden: half a 16-bit level, by which the golden itself was
/// rounded, and a hundredth for the rounding of f32. A pixel that changes by 1.02 levels (1.6e-5) always fails.
pub const PIXEL_TOLERANCE: f64 = 0.51 / 65535.0;

/// At most this many mismatches of a record are told.
const TOLD: usize = 10;

/// What a case gives.
#[derive(Debug, Clone, PartialEq)]
pub struct GoldenOutput {
    /// Linear light in [0, 1]: the picture, or the mean of random ones.
    pub picture: Raster<f32>,
    /// Corners, residuals, fates, counts: nothing that changes from run to run.
    pub record: Value,
    /// What the pictures of a case with random effects are like.
    pub noise: Option<Regions>,
}

impl GoldenOutput {
    /// The output of a case that is drawn at random, from its pictures (at least two) by different seeds.
    pub fn of_random(pictures: &[Raster<f32>], record: Value) -> Self {
        Self { picture: noise::mean_picture(pictures), record, noise: Some(Regions::of(pictures)) }
    }
}

/// The key under which a golden record keeps the noise.
const NOISE: &str = "noise";

/// Where things are.
#[derive(Debug, Clone, Copy)]
pub struct Folders<'a> {
    /// The cases, `*.toml`.
    pub cases: &'a Path,
    /// Their goldens.
    pub golden: &'a Path,
    /// What failing cases leave behind; made when needed.
    pub failures: &'a Path,
}

/// Whether goldens are only checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Goldens are read only.
    Check,
    /// The goldens of failing cases are written anew, all others are left alone.
    Update,
}

impl Mode {
    /// The mode that the values of the variables `UPDATE_GOLDEN` and `CI` ask for.
    ///
    /// # Errors
    /// A value of `UPDATE_GOLDEN` other than 0 and 1, and an update where `CI` is set: there, nobody looks.
    pub fn of_variables(update: Option<&str>, ci: Option<&str>) -> Result<Self, Problem> {
        match (update, ci.is_some_and(|value| !value.is_empty())) {
            (None | Some("" | "0"), _) => Ok(Self::Check),
            (Some("1"), false) => Ok(Self::Update),
            (Some("1"), true) => Err(Problem::new(
                "UPDATE_GOLDEN",
                "goldens are not rewritten where CI is set",
                "run it on your own machine, look at the pictures, and commit them",
            )),
            (Some(other), _) => {
                Err(Problem::new("UPDATE_GOLDEN", format!("the value is {other:?}, and must be 0 or 1"), "set it to 1"))
            }
        }
    }
}

/// How it went with one case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// As its golden.
    Passed,
    /// Not as its golden, or without one.
    Failed,
    /// It failed, and its golden was written anew.
    Updated,
}

/// The judgement of one case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseResult {
    /// Its name, without an ending.
    pub name: String,
    /// How it went.
    pub outcome: Outcome,
    /// Why it failed, one sentence each.
    pub reasons: Vec<String>,
    /// How far the picture is from its golden, where both are there and of one size.
    pub picture: Option<Difference>,
    /// How far the record is from its golden, where both are there.
    pub record: Option<RecordDifference>,
}

/// The judgement of all cases.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GoldenReport {
    /// One entry a case, by name.
    pub cases: Vec<CaseResult>,
    /// Golden files without a case.
    pub orphans: Vec<String>,
}

impl GoldenReport {
    /// Whether no case failed and no golden is left over.
    pub fn passed(&self) -> bool {
        self.orphans.is_empty() && self.cases.iter().all(|case| case.outcome != Outcome::Failed)
    }
}

impl fmt::Display for GoldenReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for case in self.cases.iter().filter(|case| case.outcome != Outcome::Passed) {
            let word = if case.outcome == Outcome::Updated { "updated" } else { "FAILED" };
            writeln!(f, "{word} {}", case.name)?;
            for reason in &case.reasons {
                writeln!(f, "    {reason}")?;
            }
        }
        for orphan in &self.orphans {
            writeln!(f, "FAILED {orphan}\n    no case has this golden: delete it, or bring its case back")?;
        }
        let count = |outcome| self.cases.iter().filter(|case| case.outcome == outcome).count();
        write!(
            f,
            "{} cases: {} passed, {} failed, {} updated; {} goldens without a case",
            self.cases.len(),
            count(Outcome::Passed),
            count(Outcome::Failed),
            count(Outcome::Updated),
            self.orphans.len()
        )
    }
}

/// Renders every case and holds it against its golden.
///
/// `render` is given the path of the case; `tolerance` says for each leaf of a record, by its JSON pointer, how far it
/// may move.
///
/// # Errors
/// A folder that cannot be read or holds no case, and files that cannot be written. What is wrong with a case is in
/// the report.
pub fn run(
    folders: &Folders<'_>,
    mode: Mode,
    tolerance: &dyn Fn(&str) -> Tolerance,
    render: &dyn Fn(&Path) -> Result<GoldenOutput, Problem>,
) -> Result<GoldenReport, Problem> {
    let names = stems(folders.cases, "toml")?;
    if names.is_empty() {
        let place = folders.cases.display();
        return Err(Problem::new(place, "the folder has no case (*.toml)", "add a small scene to it"));
    }
    let cases = names
        .iter()
        .map(|name| judge(folders, mode, tolerance, name, render(&file(folders.cases, name, "toml"))))
        .collect::<Result<_, _>>()?;
    let left_over = |ending: &'static str| {
        let found = if folders.golden.exists() { stems(folders.golden, ending)? } else { BTreeSet::new() };
        Ok(found.into_iter().filter(|name| !names.contains(name)).map(move |name| format!("{name}.{ending}")))
    };
    let orphans = left_over("json")?.chain(left_over("png")?).collect();
    Ok(GoldenReport { cases, orphans })
}

/// Holds one case against its golden; on failure leaves the evidence or writes the golden anew.
fn judge(
    folders: &Folders<'_>,
    mode: Mode,
    tolerance: &dyn Fn(&str) -> Tolerance,
    name: &str,
    rendered: Result<GoldenOutput, Problem>,
) -> Result<CaseResult, Problem> {
    let mut case =
        CaseResult { name: name.to_owned(), outcome: Outcome::Failed, reasons: vec![], picture: None, record: None };
    let actual = match rendered {
        Ok(output) => output,
        Err(problem) => {
            case.reasons.push(format!("it cannot be rendered: {problem}"));
            return Ok(case);
        }
    };
    let expected_picture = compare_picture(folders, &actual, &mut case);
    compare_record(folders, &actual, tolerance, &mut case);

    if case.reasons.is_empty() {
        case.outcome = Outcome::Passed;
        forget(folders, name);
    } else if mode == Mode::Update {
        if actual.picture.data().iter().all(|light| (0.0..=1.0).contains(light)) {
            update(folders, name, &actual)?;
            case.outcome = Outcome::Updated;
            forget(folders, name);
        } else {
            case.reasons.push("it cannot be kept as a golden: its picture leaves the range 0 to 1".to_owned());
        }
    } else {
        leave_evidence(folders, &case, expected_picture.as_ref(), &actual.picture)?;
    }
    Ok(case)
}

/// Adds to `case` what is wrong with the picture, and returns the golden one. Of random pictures only the size is asked
/// for; the rest is the record's.
fn compare_picture(folders: &Folders<'_>, actual: &GoldenOutput, case: &mut CaseResult) -> Option<Raster<f32>> {
    let path = file(folders.golden, &case.name, "png");
    if !path.exists() {
        case.reasons.push(format!("it has no golden picture {}", path.display()));
        return None;
    }
    let expected = match png::read(&path, None) {
        Ok((expected, _)) => expected,
        Err(problem) => {
            case.reasons.push(problem.to_string());
            return None;
        }
    };
    let tolerance = if actual.noise.is_some() { f64::INFINITY } else { PIXEL_TOLERANCE };
    match compare::compare(&expected, &actual.picture, tolerance) {
        Ok(difference) => {
            if let (false, Some([i, j])) = (difference.passes(), difference.worst_px) {
                case.reasons.push(format!(
                    "{} of {} pixels changed, most by {:.3e} of full scale at pixel ({i}, {j}); rms {:.3e}",
                    difference.over_threshold, difference.pixels, difference.max_abs, difference.rms
                ));
                if let Some(r) = difference.regions.first() {
                    let (count, [x, y], [right, below]) = (difference.regions.len(), r.first_px, r.last_px);
                    case.reasons.push(format!(
                        "in {count}{} regions, the largest of {} pixels from ({x}, {y}) to ({right}, {below})",
                        if count == 10 { " or more" } else { "" },
                        r.pixels
                    ));
                }
            }
            case.picture = Some(difference);
        }
        Err(problem) => case.reasons.push(problem.rule),
    }
    Some(expected)
}

/// Adds to `case` what is wrong with the record.
fn compare_record(
    folders: &Folders<'_>,
    output: &GoldenOutput,
    tolerance: &dyn Fn(&str) -> Tolerance,
    case: &mut CaseResult,
) {
    let path = file(folders.golden, &case.name, "json");
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) => {
            case.reasons.push(format!("its golden record {} cannot be read: {error}", path.display()));
            return;
        }
    };
    // Both go through the same text and parser, so that equal numbers stay equal.
    match (serde_json::from_str::<Value>(&text), serde_json::from_str(&output.record.to_string())) {
        (Ok(mut expected), Ok(actual)) => {
            if let Some(actual) = &output.noise {
                let kept = expected.as_object_mut().and_then(|o| o.shift_remove(NOISE)).unwrap_or_default();
                compare_noise(kept, actual, case);
            }
            let difference = record::compare(&expected, &actual, tolerance);
            case.reasons.extend(difference.mismatches.iter().take(TOLD).cloned());
            if difference.mismatches.len() > TOLD {
                case.reasons.push(format!("and {} more numbers changed", difference.mismatches.len() - TOLD));
            }
            if let (false, Some(shift)) = (difference.mismatches.is_empty(), &difference.largest_shift) {
                case.reasons.push(format!("largest corner shift: {:.3e} px at {}", shift.px, shift.path));
            }
            case.record = Some(difference);
        }
        (Err(error), _) | (_, Err(error)) => {
            case.reasons.push(format!("its golden record {} is no JSON: {error}", path.display()));
        }
    }
}

/// Adds to `case` what chance does not explain.
fn compare_noise(expected: Value, actual: &Regions, case: &mut CaseResult) {
    let found = match serde_json::from_value::<Regions>(expected) {
        Ok(expected) => expected.mismatches(actual),
        Err(error) => vec![format!("its golden record has no noise to compare with: {error}")],
    };
    case.reasons.extend(found.iter().take(TOLD).cloned());
    if found.len() > TOLD {
        case.reasons.push(format!("and {} more regions changed", found.len() - TOLD));
    }
}

/// Writes the golden of one case.
fn update(folders: &Folders<'_>, name: &str, actual: &GoldenOutput) -> Result<(), Problem> {
    make(folders.golden)?;
    let picture = file(folders.golden, name, "png");
    png::write_grey16(&picture, &actual.picture, Transfer::Linear, &Notes::default())?;
    let mut record = actual.record.clone();
    if let (Some(noise), Some(record)) = (&actual.noise, record.as_object_mut()) {
        record.insert(NOISE.to_owned(), json!(noise));
    }
    let text = format!("{record:#}\n");
    write_bytes(&file(folders.golden, name, "json"), text.as_bytes())
}

/// Leaves the strip, where there are two pictures, and a short text.
fn leave_evidence(
    folders: &Folders<'_>,
    case: &CaseResult,
    expected: Option<&Raster<f32>>,
    actual: &Raster<f32>,
) -> Result<(), Problem> {
    make(folders.failures)?;
    let mut text = format!("{}\n", case.name);
    for reason in &case.reasons {
        text.push_str(&format!("    {reason}\n"));
    }
    if let Some(expected) = expected {
        let strip = compare::strip(expected, actual);
        let notes = json!({"panels": "expected | difference | actual", "gain": strip.gain}).to_string();
        let path = file(folders.failures, &case.name, STRIP);
        png::write_rgb(&path, &strip.figure, &Notes { json: &notes, pitch_mm: None })?;
        text.push_str(&format!(
            "{}: expected | difference x {:.4e} | actual; red is brighter, blue is darker\n",
            path.display(),
            strip.gain
        ));
    }
    text.push_str("When the change is meant: UPDATE_GOLDEN=1, then look at the new golden.\n");
    write_bytes(&file(folders.failures, &case.name, TEXT), text.as_bytes())
}

const STRIP: &str = "strip.png";
const TEXT: &str = "diff.txt";

/// Takes the evidence of an earlier failure away. That it may not be there is no failure.
fn forget(folders: &Folders<'_>, name: &str) {
    for ending in [STRIP, TEXT] {
        let _ = fs::remove_file(file(folders.failures, name, ending));
    }
}

fn file(folder: &Path, name: &str, ending: &str) -> PathBuf {
    folder.join(format!("{name}.{ending}"))
}

fn make(folder: &Path) -> Result<(), Problem> {
    fs::create_dir_all(folder).map_err(|error| {
        let rule = format!("the folder cannot be made: {error}");
        Problem::new(folder.display(), rule, "name a folder that you may write to")
    })
}

/// The names, without the ending, of the files in a folder that have this ending.
fn stems(folder: &Path, ending: &str) -> Result<BTreeSet<String>, Problem> {
    let unreadable = |error: std::io::Error| {
        let rule = format!("the folder cannot be read: {error}");
        Problem::new(folder.display(), rule, "name a folder that exists")
    };
    let mut names = BTreeSet::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let wanted = path.extension().is_some_and(|found| found == ending);
        if let (true, Some(name)) = (wanted, path.file_stem()) {
            names.insert(name.to_string_lossy().into_owned());
        }
    }
    Ok(names)
}

#[cfg(test)]
mod tests;
