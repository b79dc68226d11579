//! The file of a batch's lines: appended to, a line at a time and each on the disk before the next, and read again to go on.

use crate::cli::appended::{self, unwritable};
use crate::cli::files;
use crate::error::Error;
use crate::io::atomic::write_atomically;
use crate::report::batch::job_line::{BATCH_SCHEMA, JobHead, JobLine};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Longest line, in bytes.
const MAX_LINE: u64 = 1 << 24;

/// What is read of a line to go on.
pub(super) struct LineStart {
    /// Where it belongs.
    pub(super) head: JobHead,
    /// Whether it ended in an error.
    pub(super) is_error: bool,
    /// Whether it did not keep what was asked for.
    pub(super) is_unmet: bool,
}

/// The keys of a line that say whether it is an error, and whether something is not kept.
#[derive(Deserialize)]
struct OutcomeKeys {
    error: Option<IgnoredAny>,
    unmet: Option<IgnoredAny>,
}

impl LineStart {
    /// Of the bytes of a line; figures are passed over.
    fn of(line: &[u8]) -> serde_json::Result<Self> {
        let OutcomeKeys { error, unmet } = serde_json::from_slice(line)?;
        Ok(Self { head: serde_json::from_slice(line)?, is_error: error.is_some(), is_unmet: unmet.is_some() })
    }
}

/// A whole line in a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineBytes {
    pub(super) from: u64,
    pub(super) bytes: u64,
}

/// What breaks a rule, and the next step.
pub(super) type LineFault = (String, &'static str);

/// Reads the lines of `file`, and hands each with its place and its bytes to `take`. Returns the bytes up to the end of the last whole line, and
/// whether something stood behind it.
///
/// # Errors
/// A line that is none of a batch, or what `take` says.
pub(super) fn each_line(
    path: &Path,
    file: &File,
    mut take: impl FnMut(LineStart, LineBytes, &[u8]) -> Result<(), LineFault>,
) -> Result<(u64, bool), Error> {
    let mut input = BufReader::new(file);
    let (mut buffer, mut from) = (Vec::new(), 0);
    for number in 1usize.. {
        buffer.clear();
        let place = || format!("{}:{number}", path.display());
        let problem = |rule: String| {
            Error::new(place(), rule, "give a file that `biprism batch` wrote, as it was written, or another one")
        };
        let size = (&mut input).take(MAX_LINE).read_until(b'\n', &mut buffer);
        let bytes = size.map_err(|error| problem(format!("the line cannot be read: {error}")))? as u64;
        if buffer.last() != Some(&b'\n') {
            if bytes == MAX_LINE {
                return Err(problem(format!("the line has {MAX_LINE} bytes or more, and must have fewer")));
            }
            return Ok((from, bytes > 0));
        }
        let start = LineStart::of(&buffer).map_err(|error| problem(format!("it is no job of a batch: {error}")))?;
        if start.head.schema != BATCH_SCHEMA {
            return Err(problem(format!("its `schema` is {}, and must be {BATCH_SCHEMA}", start.head.schema)));
        }
        take(start, LineBytes { from, bytes }, &buffer).map_err(|(rule, help)| Error::new(place(), rule, help))?;
        from += bytes;
    }
    Ok((from, false))
}

/// A file of lines that is open to be appended to. Nobody else writes to it meanwhile.
pub(super) struct JobFile {
    pub(super) path: PathBuf,
    /// Where the line of each job is, by the job's number.
    pub(super) places: Vec<Option<LineBytes>>,
    /// Lines that ended in an error.
    pub(super) errors: u32,
    /// Lines of jobs that did not keep what was asked for.
    pub(super) unmet: u32,
    /// Whether the last line was cut off, and is gone.
    pub(super) was_torn: bool,
    file: File,
    end: u64,
    /// Whether its lines are in the order of their numbers.
    in_order: bool,
    last: Option<u32>,
}

impl JobFile {
    /// The file at `path`, new or with some jobs of the same run; a line that was cut off is taken out. `job` gives the job of a number.
    ///
    /// # Errors
    /// When it belongs to another run, another program writes to it, or it cannot be written.
    pub(super) fn open(path: &Path, count: u32, job: impl Fn(u32) -> JobHead) -> Result<Self, Error> {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        files::outputs(path.parent().unwrap_or(Path::new("")), &[&name])?;
        let file = appended::open(path, "jobs")?;
        let mut read = Self {
            path: path.to_owned(),
            places: vec![None; count as usize],
            errors: 0,
            unmet: 0,
            was_torn: false,
            file: file.try_clone().map_err(|error| unwritable(path, &error))?,
            end: 0,
            in_order: true,
            last: None,
        };
        let own = job(0);
        let other = "give another file with --out, or remove this one";
        let (end, torn) = each_line(path, &file, |line, place, _| {
            if let Some(key) = own.difference(&line.head) {
                let rule = match key {
                    "run" => "a scene, a file that it names, a key or the choice of figures".to_owned(),
                    key => format!("its `{key}`"),
                };
                return Err((format!("the file has jobs of another run: {rule} is another one"), other));
            }
            if line.head.job >= count || job(line.head.job).id != line.head.id {
                return Err((format!("the job {} has another id in this run", line.head.job), other));
            }
            if read.places[line.head.job as usize].is_some() {
                return Err((format!("the job {} is there twice", line.head.job), other));
            }
            read.note(line.head.job, place, [line.is_error, line.is_unmet]);
            Ok(())
        })?;
        read.was_torn = torn;
        read.end = end;
        let trouble = |error: io::Error| unwritable(path, &error);
        read.file.set_len(end).and_then(|()| read.file.seek(SeekFrom::End(0))).map_err(trouble)?;
        Ok(read)
    }

    fn note(&mut self, job: u32, place: LineBytes, [is_error, is_unmet]: [bool; 2]) {
        self.places[job as usize] = Some(place);
        self.in_order &= self.last.is_none_or(|last| last < job);
        self.last = Some(job);
        self.errors += u32::from(is_error);
        self.unmet += u32::from(is_unmet);
    }

    /// Adds a line, whole, and waits until the disk has it.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(super) fn append(&mut self, line: &JobLine) -> Result<(), Error> {
        let text = line.text()?;
        let written = self.file.write_all(text.as_bytes()).and_then(|()| self.file.sync_data());
        written.map_err(|error| unwritable(&self.path, &error))?;
        let place = LineBytes { from: self.end, bytes: text.len() as u64 };
        self.end += place.bytes;
        self.note(line.head.job, place, [line.error.is_some(), !line.unmet.is_empty()]);
        Ok(())
    }

    /// Puts the lines in the order of their numbers, whatever order they were made in.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(super) fn put_in_order(&mut self) -> Result<(), Error> {
        if self.in_order {
            return Ok(());
        }
        write_atomically(&self.path, |out| {
            self.places.iter().flatten().try_for_each(|place| copy(&self.file, *place, out))
        })?;
        self.in_order = true;
        Ok(())
    }
}

/// Copies the line at `place` of `file`.
pub(super) fn copy(mut file: &File, place: LineBytes, out: &mut impl Write) -> io::Result<()> {
    file.seek(SeekFrom::Start(place.from))?;
    match io::copy(&mut file.take(place.bytes), out)? {
        bytes if bytes == place.bytes => Ok(()),
        _ => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "it became shorter while it was read")),
    }
}
