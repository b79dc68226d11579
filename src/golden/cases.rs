//! Every case held against its golden.

use super::noise::Regions;
use super::record::{self, Tolerance};
use super::report::{CaseResult, Folders, GoldenOutcome, GoldenOutput, Mode, Tolerances};
use crate::error::Error;
use crate::io::atomic::write_bytes;
use crate::io::inputs;
use crate::io::{Notes, png};
use crate::raster::transfer::Transfer;
use crate::raster::{Raster, compare};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

/// A pixel may be this far, in linear light, from its golden: half a 16-bit level, by which the golden itself was
/// rounded, and a hundredth for the rounding of f32. A pixel that changes by 1.02 levels (1.6e-5) always fails.
pub const PIXEL_TOLERANCE: f64 = 0.51 / 65535.0;

/// At most this many mismatches of a record are told.
pub(super) const TOLD: usize = 10;

/// Bytes of a golden record, at most.
const RECORD_BYTES: u64 = 1 << 26;

/// The text of a golden record.
fn read_text(path: &Path) -> std::io::Result<String> {
    let mut text = String::new();
    let read = inputs::open(path)?.take(RECORD_BYTES + 1).read_to_string(&mut text)?;
    if read as u64 > RECORD_BYTES {
        return Err(std::io::Error::other(format!("it has more than {RECORD_BYTES} bytes")));
    }
    Ok(text)
}

/// The key under which a golden record keeps the noise.
pub(super) const NOISE: &str = "noise";

/// Renders the case `name` and holds it against its golden.
///
/// # Errors
/// Files that cannot be written. What is wrong with the case is in the result.
pub fn run_case(
    folders: &Folders<'_>,
    mode: Mode,
    tolerances: &Tolerances<'_>,
    render: &dyn Fn(&Path) -> Result<GoldenOutput, Error>,
    name: &str,
) -> Result<CaseResult, Error> {
    judge(folders, mode, tolerances, name, render(&file(folders.cases, name, "toml")))
}

/// The names of the cases, at least one.
///
/// # Errors
/// A folder that cannot be read or holds no case.
pub fn case_names(folders: &Folders<'_>) -> Result<BTreeSet<String>, Error> {
    let names = stems(folders.cases, "toml")?;
    if names.is_empty() {
        let place = folders.cases.display();
        return Err(Error::new(place, "the folder has no case (*.toml)", "add a small scene to it"));
    }
    Ok(names)
}

/// The golden files without a case: the records, then the pictures.
///
/// # Errors
/// A folder that cannot be read or holds no case.
pub fn orphans(folders: &Folders<'_>) -> Result<Vec<String>, Error> {
    let names = case_names(folders)?;
    let left_over = |ending: &'static str| {
        let found = if folders.golden.exists() { stems(folders.golden, ending)? } else { BTreeSet::new() };
        Ok(found.into_iter().filter(|name| !names.contains(name)).map(move |name| format!("{name}.{ending}")))
    };
    Ok(left_over("json")?.chain(left_over("png")?).collect())
}

/// Holds one case against its golden; on failure leaves the evidence or writes the golden anew.
pub(super) fn judge(
    folders: &Folders<'_>,
    mode: Mode,
    tolerances: &Tolerances<'_>,
    name: &str,
    rendered: Result<GoldenOutput, Error>,
) -> Result<CaseResult, Error> {
    let mut case = CaseResult {
        name: name.to_owned(),
        outcome: GoldenOutcome::Failed,
        reasons: vec![],
        picture: None,
        record: None,
    };
    let actual = match rendered {
        Ok(output) => output,
        Err(problem) => {
            case.reasons.push(format!("it cannot be rendered: {problem}"));
            return Ok(case);
        }
    };
    let mut expected_picture = None;
    if ["png", "json"].iter().any(|ending| file(folders.golden, name, ending).exists()) {
        expected_picture = compare_picture(folders, &actual, tolerances.grey, &mut case);
        compare_record(folders, &actual, tolerances.record, &mut case);
    } else {
        let kept = format!("it has no golden yet: look at its picture, then keep it with --bless {name}");
        case.reasons.push(kept);
    }

    if case.reasons.is_empty() {
        case.outcome = GoldenOutcome::Passed;
        forget(folders, name);
    } else if mode == Mode::Update {
        if actual.picture.data().iter().all(|light| (0.0..=1.0).contains(light)) {
            update(folders, name, &actual)?;
            case.outcome = GoldenOutcome::Updated;
            forget(folders, name);
        } else {
            case.reasons.push("it cannot be kept as a golden: its picture leaves the range 0 to 1".to_owned());
        }
    } else {
        leave_evidence(folders, &case, expected_picture.as_ref(), &actual.picture)?;
    }
    Ok(case)
}

/// Adds to `case` what is wrong with the picture, whose pixels may be `grey` from those of the golden one, and returns that. Of
/// random pictures only the size is asked for; the rest is the record's.
pub(super) fn compare_picture(
    folders: &Folders<'_>,
    actual: &GoldenOutput,
    grey: f64,
    case: &mut CaseResult,
) -> Option<Raster<f32>> {
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
    let tolerance = if actual.noise.is_some() { f64::INFINITY } else { grey };
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
pub(super) fn compare_record(
    folders: &Folders<'_>,
    output: &GoldenOutput,
    tolerance: &dyn Fn(&str) -> Tolerance,
    case: &mut CaseResult,
) {
    let path = file(folders.golden, &case.name, "json");
    let text = match read_text(&path) {
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
pub(super) fn compare_noise(expected: Value, actual: &Regions, case: &mut CaseResult) {
    let found = match serde_json::from_value::<Regions>(expected) {
        Ok(expected) => expected.mismatches(actual),
        Err(error) => vec![format!("its golden record has no noise to compare with: {error}")],
    };
    case.reasons.extend(found.iter().take(TOLD).cloned());
    if found.len() > TOLD {
        case.reasons.push(format!("and {} more figures changed", found.len() - TOLD));
    }
}

/// Writes the golden of one case.
pub(super) fn update(folders: &Folders<'_>, name: &str, actual: &GoldenOutput) -> Result<(), Error> {
    make(folders.golden)?;
    let [picture, numbers] = ["png", "json"].map(|ending| file(folders.golden, name, ending));
    inputs::release(&picture);
    inputs::release(&numbers);
    png::write_grey16(&picture, &actual.picture, Transfer::Linear, &Notes::default())?;
    let mut record = actual.record.clone();
    if let (Some(noise), Some(record)) = (&actual.noise, record.as_object_mut()) {
        record.insert(NOISE.to_owned(), json!(noise));
    }
    let text = format!("{record:#}\n");
    write_bytes(&numbers, text.as_bytes())
}

/// Leaves the strip, where there are two pictures, else the one, and a short text.
pub(super) fn leave_evidence(
    folders: &Folders<'_>,
    case: &CaseResult,
    expected: Option<&Raster<f32>>,
    actual: &Raster<f32>,
) -> Result<(), Error> {
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
    } else {
        let path = file(folders.failures, &case.name, ACTUAL);
        png::write_grey16(&path, actual, Transfer::Linear, &Notes::default())?;
        text.push_str(&format!("{}: the picture\n", path.display()));
    }
    text.push_str(&format!("When it is meant: --bless {}, then look at the new golden.\n", case.name));
    write_bytes(&file(folders.failures, &case.name, TEXT), text.as_bytes())
}

pub(super) const STRIP: &str = "strip.png";
pub(super) const TEXT: &str = "diff.txt";
/// The picture itself, where there is no golden one.
pub(super) const ACTUAL: &str = "actual.png";

/// Takes the evidence of an earlier failure away. That it may not be there is no failure.
pub(super) fn forget(folders: &Folders<'_>, name: &str) {
    for ending in [STRIP, TEXT, ACTUAL] {
        let path = file(folders.failures, name, ending);
        if !inputs::was_read(&path) {
            let _ = fs::remove_file(path);
        }
    }
}

pub(super) fn file(folder: &Path, name: &str, ending: &str) -> PathBuf {
    folder.join(format!("{name}.{ending}"))
}

pub(super) fn make(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder).map_err(|error| {
        let rule = format!("the folder cannot be made: {error}");
        Error::new(folder.display(), rule, "name a folder that you may write to")
    })
}

/// The names, without the ending, of the files in a folder that have this ending.
pub(super) fn stems(folder: &Path, ending: &str) -> Result<BTreeSet<String>, Error> {
    let unreadable = |error: std::io::Error| {
        let rule = format!("the folder cannot be read: {error}");
        Error::new(folder.display(), rule, "name a folder that exists")
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
