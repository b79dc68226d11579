//! Files of trials: appended to while they are made, read again to go on, and put together.

use crate::cli::appended::{self, unwritable};
use crate::cli::files;
use crate::error::Error;
use crate::io::inputs;
use crate::report::study::trial_lines::{TrialLine, TrialRun, line};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Longest line, in bytes: an instrument has some hundred, a trial fewer.
const MAX_LINE: u64 = 1 << 16;
/// Most lines of all files that are put together: eight prisms of a million trials.
const MAX_LINES: usize = 8_000_000;

/// A file of trials that is open to be appended to. Nobody else writes to it meanwhile.
pub(super) struct TrialFile {
    /// Its path.
    pub(super) path: PathBuf,
    /// Its trials, by prism and number.
    pub(super) lines: Vec<TrialLine>,
    file: File,
}

impl TrialFile {
    /// The file `name` in `folder`, new or with some trials of the same `run`; a line that was cut off is made anew.
    ///
    /// # Errors
    /// When it belongs to another run, another program writes to it, or it cannot be written.
    pub(super) fn open(folder: &Path, name: &str, run: &TrialRun) -> Result<Self, Error> {
        files::folder(folder)?;
        let path = folder.join(name);
        let mut file = appended::open(&path, "trials")?;
        let trouble = |error: std::io::Error| unwritable(&path, &error);
        let read = read_lines(&path, &file)?;
        let mut lines = Vec::new();
        match read.run {
            None => {
                file.set_len(0).and_then(|()| file.seek(SeekFrom::Start(0))).map_err(trouble)?;
                file.write_all(line(run).as_bytes()).map_err(trouble)?;
            }
            Some(found) => {
                if let Some(key) = run.difference(&found) {
                    let rule = format!("the file has trials of another run: its `{key}` is another one");
                    return Err(Error::new(path.display(), rule, "give another folder with --out, or remove the file"));
                }
                lines = read.lines;
                file.set_len(read.whole_bytes).map_err(trouble)?;
                file.seek(SeekFrom::End(0)).map_err(trouble)?;
            }
        }
        lines.sort_by_key(|line| (line.prism, line.trial));
        Ok(Self { path, lines, file })
    }

    /// The trials of the prism of number `prism` that are not there yet.
    pub(super) fn missing(&self, run: &TrialRun, prism: usize) -> Vec<u32> {
        let there: BTreeSet<u32> =
            self.lines.iter().filter(|line| line.prism == prism).map(|line| line.trial).collect();
        run.numbers().filter(|number| !there.contains(number)).collect()
    }

    /// Adds trials.
    ///
    /// # Errors
    /// When they cannot be written.
    pub(super) fn append(&mut self, new: impl Iterator<Item = TrialLine>) -> Result<(), Error> {
        let from = self.lines.len();
        self.lines.extend(new);
        let text: String = self.lines[from..].iter().map(line).collect();
        self.file.write_all(text.as_bytes()).map_err(|error| unwritable(&self.path, &error))
    }
}

/// What a file of trials has.
struct ReadTrials {
    /// Its first line; `None` of an empty file, and of one whose first line was cut off.
    run: Option<TrialRun>,
    lines: Vec<TrialLine>,
    /// Bytes up to the end of the last whole line.
    whole_bytes: u64,
}

fn read_lines(path: &Path, file: &File) -> Result<ReadTrials, Error> {
    let mut input = BufReader::new(file);
    let mut read = ReadTrials { run: None, lines: Vec::new(), whole_bytes: 0 };
    let mut seen = BTreeSet::new();
    let mut buffer = Vec::new();
    for number in 1usize.. {
        buffer.clear();
        let problem = |rule: String| {
            let help = "give a file that `biprism analyse tolerance --trials` wrote, as it was written";
            Error::new(format!("{}:{number}", path.display()), rule, help)
        };
        let size = (&mut input).take(MAX_LINE).read_until(b'\n', &mut buffer);
        let size = size.map_err(|error| problem(format!("the line cannot be read: {error}")))? as u64;
        if buffer.last() != Some(&b'\n') {
            if size == MAX_LINE {
                return Err(problem(format!("the line has {MAX_LINE} bytes or more, and must have fewer")));
            }
            break;
        }
        match &read.run {
            None => {
                let run: TrialRun =
                    serde_json::from_slice(&buffer).map_err(|e| problem(format!("no run of trials: {e}")))?;
                if !run.is_known() {
                    return Err(problem("the run is of another version, or its shard is no part of it".to_owned()));
                }
                read.run = Some(run);
            }
            Some(run) => {
                let found: TrialLine =
                    serde_json::from_slice(&buffer).map_err(|e| problem(format!("no trial: {e}")))?;
                if !run.fits(&found) {
                    return Err(problem(format!("the trial {} is none of the run in line 1", found.trial)));
                }
                if !seen.insert((found.prism, found.trial)) {
                    return Err(problem(format!("the trial {} is there twice", found.trial)));
                }
                if read.lines.len() == MAX_LINES {
                    return Err(problem(format!("the file has more than {MAX_LINES} trials")));
                }
                read.lines.push(found);
            }
        }
        read.whole_bytes += size;
    }
    Ok(read)
}

/// The run and all its trials, from the files of its parts.
///
/// # Errors
/// When files are of different runs, or a trial is there twice or not at all.
pub(super) fn read_whole(paths: &[PathBuf]) -> Result<(TrialRun, Vec<TrialLine>), Error> {
    let mut whole: Option<TrialRun> = None;
    let mut lines: Vec<(TrialLine, usize)> = Vec::new();
    for (k, path) in paths.iter().enumerate() {
        let place = || path.display();
        let file = inputs::open(path).map_err(|error| {
            Error::new(place(), format!("the file cannot be read: {error}"), "check its name and rights")
        })?;
        let read = read_lines(path, &file)?;
        let run =
            read.run.ok_or_else(|| Error::new(place(), "the file has no trials", "run its part, or leave it out"))?;
        let run = TrialRun { shard: None, ..run };
        match &whole {
            None => whole = Some(run),
            Some(first) => {
                if let Some(key) = first.difference(&run) {
                    let rule =
                        format!("the file is of another run than {}: its `{key}` is another one", paths[0].display());
                    return Err(Error::new(place(), rule, "give the parts of one run"));
                }
            }
        }
        if lines.len() + read.lines.len() > MAX_LINES {
            return Err(Error::new(
                place(),
                format!("there are more than {MAX_LINES} trials"),
                "give the parts of one run",
            ));
        }
        lines.extend(read.lines.into_iter().map(|line| (line, k)));
    }
    let run = whole.ok_or_else(|| Error::new("merge", "there is no file", "name the parts of a run"))?;

    // Every trial must be there once.
    lines.sort_by_key(|(line, k)| (line.prism, line.trial, *k));
    let twice = lines.windows(2).find(|pair| (pair[0].0.prism, pair[0].0.trial) == (pair[1].0.prism, pair[1].0.trial));
    if let Some([(line, a), (_, b)]) = twice {
        let rule = format!(
            "the trial {} of prism {} is in {} as well",
            line.trial,
            run.prisms[line.prism].name,
            paths[*a].display()
        );
        return Err(Error::new(paths[*b].display(), rule, "give each part once"));
    }
    let mut have = lines.iter().map(|(line, _)| (line.prism, line.trial));
    for prism in 0..run.prisms.len() {
        for trial in 0..run.trials {
            if have.next() != Some((prism, trial)) {
                let rule = format!("the trial {trial} of prism {} is in no file", run.prisms[prism].name);
                let help = "run the part that lacks it again, which goes on where it was, and give all parts";
                return Err(Error::new("merge", rule, help));
            }
        }
    }
    Ok((run, lines.into_iter().map(|(line, _)| line).collect()))
}
