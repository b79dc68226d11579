//! `biprism merge` of the parts of a batch: one file of all lines, and charts of a sweep.

use super::job_file::{LineBytes, copy, each_line};
use crate::cli::outcome::Outcome;
use crate::cli::tolerance_args::MergeArgs;
use crate::cli::{files, output};
use crate::error::Error;
use crate::io::atomic::write_atomically;
use crate::io::inputs;
use crate::report::batch::job_line::{BATCH_SCHEMA, JobHead, JobLine};
use crate::report::batch::sweep_chart::{SweepInput, SweepPoint, draw};
use serde_json::json;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// The file of all lines.
const WHOLE: &str = "batch.jsonl";
/// Bytes that tell what a file holds.
const BEGINNING: u64 = 256;
/// The most jobs of a chart.
const MOST_POINTS: usize = 100_000;

/// Whether the file at `path` is one of a batch.
///
/// # Errors
/// When it cannot be read.
pub(crate) fn is_batch(path: &Path) -> Result<bool, Error> {
    let mut bytes = Vec::new();
    let read = inputs::open(path).and_then(|file| file.take(BEGINNING).read_to_end(&mut bytes));
    read.map_err(|error| unreadable(path, &error))?;
    Ok(bytes.starts_with(format!("{{\"schema\":\"{BATCH_SCHEMA}\"").as_bytes()))
}

fn unreadable(path: &Path, error: &io::Error) -> Error {
    Error::new(path.display(), format!("the file cannot be read: {error}"), "check its name and rights")
}

/// The lines of all parts of one run.
struct WholeRun {
    head: JobHead,
    files: Vec<(PathBuf, File)>,
    /// Of each job the file, by its number, and the place of its line there.
    places: Vec<(usize, LineBytes)>,
    errors: u32,
    /// Lines that were there more than once.
    again: u32,
}

/// Makes one file of the parts of a batch, and draws the figures that are asked for.
pub(crate) fn join(args: &MergeArgs) -> Result<Outcome, Error> {
    if let Some(budget) = args.budget.first() {
        let rule = format!("a batch has no {}", budget.criterion.key());
        return Err(Error::new("--budget", rule, "leave it out: it is for the trials of `analyse tolerance`"));
    }
    let run = read(&args.files)?;
    let name = |figure: &String| format!("sweep_{}", figure.replace(|c: char| !c.is_ascii_alphanumeric(), "_"));
    let charts: Vec<String> = args.figure.iter().map(name).collect();
    let ends = charts.iter().flat_map(|name| ["png", "svg"].map(|end| format!("{name}.{end}")));
    let names: Vec<String> = std::iter::once(WHOLE.to_owned()).chain(ends).collect();
    let paths = files::outputs(&args.out, &names.iter().map(String::as_str).collect::<Vec<_>>())?;
    let drawings = args.figure.iter().map(|figure| chart(&run, figure, &args.over)).collect::<Result<Vec<_>, _>>()?;

    write_atomically(&paths[0], |out| {
        run.places.iter().try_for_each(|(file, place)| copy(&run.files[*file].1, *place, out))
    })?;
    for (name, (title, drawing)) in charts.iter().zip(&drawings) {
        files::figure(&args.out, name, drawing, title)?;
    }
    let JobHead { verb, jobs, run: word, .. } = &run.head;
    let told = json!({
        "run": word, "verb": verb, "jobs": jobs, "errors": run.errors, "again": run.again, "charts": charts,
    });
    let words =
        format!("{jobs} jobs of `{verb}`; {} ended in an error, {} were there more than once\n", run.errors, run.again);
    output::stdout(&if args.json { format!("{told:#}\n") } else { words })?;
    paths.iter().for_each(|path| output::stderr(&format!("wrote {}", path.display())));
    Ok(Outcome::Done)
}

/// The lines of the files at `paths`: of one run, each job there, and where one is there again, with the same words but for the time.
fn read(paths: &[PathBuf]) -> Result<WholeRun, Error> {
    let mut head: Option<JobHead> = None;
    let mut places: Vec<Option<(usize, LineBytes)>> = Vec::new();
    let (mut files, mut errors, mut again) = (Vec::<(PathBuf, File)>::new(), 0, 0);
    for (k, path) in paths.iter().enumerate() {
        let file = inputs::open(path).map_err(|error| unreadable(path, &error))?;
        let parts = "give the parts of one run";
        let (_, torn) = each_line(path, &file, |line, place, text| {
            let own = head.get_or_insert_with(|| line.head.clone());
            if let Some(key) = own.difference(&line.head) {
                return Err((
                    format!("the job is of another run than those before: its `{key}` is another one"),
                    parts,
                ));
            }
            places.resize(own.jobs as usize, None);
            let Some(known) = places.get_mut(line.head.job as usize) else {
                return Err((format!("the job {} is none of a run of {}", line.head.job, own.jobs), parts));
            };
            match known {
                None => {
                    errors += u32::from(line.is_error);
                    *known = Some((k, place));
                }
                Some((first, there)) => {
                    let earlier = if *first == k { &file } else { &files[*first].1 };
                    if !same(earlier, *there, text) {
                        let name = paths[*first].display();
                        let rule = format!("the job {} is in {name} as well, and says something else", line.head.job);
                        return Err((rule, "find out which of the two is wrong, and leave it out"));
                    }
                    again += 1;
                }
            }
            Ok(())
        })?;
        if torn {
            let rule = "its last line is cut off";
            return Err(Error::new(path.display(), rule, "run its part again, which goes on where it was"));
        }
        files.push((path.clone(), file));
    }
    let head = head.ok_or_else(|| Error::new("merge", "the files have no job", "name the parts of a run"))?;
    let missing = places.iter().filter(|place| place.is_none()).count();
    if let Some(first) = places.iter().position(Option::is_none) {
        let rule = format!("of {} jobs {missing} are in no file, the first of them {first}", head.jobs);
        let help = "run the parts that lack them again, which go on where they were, and give all parts";
        return Err(Error::new("merge", rule, help));
    }
    Ok(WholeRun { head, files, places: places.into_iter().flatten().collect(), errors, again })
}

/// Whether the line at `place` of `file` says the same as `text`.
fn same(file: &File, place: LineBytes, text: &[u8]) -> bool {
    // The file is read on where it was.
    let mut handle = file;
    let Ok(at) = handle.stream_position() else { return false };
    let mut bytes = Vec::new();
    let copied = copy(file, place, &mut bytes).and_then(|()| handle.seek(SeekFrom::Start(at)));
    let line = |bytes: &[u8]| serde_json::from_slice::<JobLine>(bytes).ok();
    copied.is_ok() && line(&bytes).is_some_and(|earlier| line(text).is_some_and(|line| line.says_the_same(&earlier)))
}

/// The chart of a figure, with its title.
fn chart(run: &WholeRun, figure: &str, over: &[String]) -> Result<(String, crate::plot::drawing::Drawing), Error> {
    if run.places.len() > MOST_POINTS {
        let rule = format!("the run has {} jobs, and a chart at most {MOST_POINTS}", run.places.len());
        return Err(Error::new("--figure", rule, "leave it out, or draw a smaller sweep"));
    }
    let (mut points, mut known, mut scene) = (Vec::new(), false, None);
    for (file, place) in &run.places {
        let (path, mut handle) = (&run.files[*file].0, &run.files[*file].1);
        let mut text = Vec::new();
        let read = handle.seek(SeekFrom::Start(place.from));
        let read = read.and_then(|_| BufReader::new(handle.take(place.bytes)).read_until(b'\n', &mut text));
        read.map_err(|error| unreadable(path, &error))?;
        let line: JobLine = serde_json::from_slice(&text).map_err(|error| {
            Error::new(path.display(), format!("a line is none of a batch: {error}"), "give the file as it was written")
        })?;
        let value = line.figures.as_ref().and_then(|figures| figures.get(figure));
        known |= value.is_some();
        scene = scene.or(line.scene);
        points.push(SweepPoint { set: line.set, figure: value.and_then(serde_json::Value::as_f64) });
    }
    if !known {
        let rule = format!("no job has a figure `{figure}`");
        return Err(Error::new(
            "--figure",
            rule,
            "take a path of `figures` in a line, as in flat/stereo/depth_law_rms_px",
        ));
    }
    let title = format!("{}: {} jobs of {}", scene.unwrap_or_default(), points.len(), run.head.verb);
    draw(&SweepInput { title: &title, figure, over, points: &points }).map(|drawing| (title, drawing))
}
