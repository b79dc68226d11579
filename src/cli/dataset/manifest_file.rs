//! The manifest's file: a line is there once all files of its picture are, and lines are in the order of their numbers.

use crate::analysis::dataset::{BoardPlaces, DatasetPlan};
use crate::cli::appended::{self, unwritable};
use crate::cli::files;
use crate::error::Error;
use crate::report::dataset::{ManifestHead, PoseLine, SetTally, line};
use serde_json::json;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Its name.
pub(super) const MANIFEST: &str = "manifest.jsonl";
/// Longest first line, in bytes: it holds the text of a scene, whose every byte may take six.
const MAX_HEAD: u64 = 26 << 20;
/// Longest other line, in bytes: it has some hundred.
const MAX_LINE: u64 = 1 << 16;

/// The manifest of a set, open to be appended to. Nobody else writes to it meanwhile.
pub(super) struct ManifestFile {
    /// Its path.
    pub(super) path: PathBuf,
    /// What its lines come to.
    pub(super) tally: SetTally,
    /// Numbers in it whose files are not all there.
    pub(super) incomplete: Vec<u32>,
    file: File,
    /// The number of the next line.
    next: u32,
    /// Pictures that are done before one of a smaller number.
    early: BTreeMap<u32, PoseLine>,
}

impl ManifestFile {
    /// The manifest of the set `head` in `folder`, new or with some of its pictures; a line that was cut off is made anew.
    ///
    /// # Errors
    /// When it belongs to another set, another program writes to it, or it cannot be read or written.
    pub(super) fn open(folder: &Path, head: &ManifestHead, plan: &DatasetPlan) -> Result<Self, Error> {
        let path = files::outputs(folder, &[MANIFEST])?.swap_remove(0);
        let file = appended::open(&path, "pictures")?;
        let mut manifest =
            Self { path, tally: SetTally::default(), incomplete: Vec::new(), file, next: 0, early: BTreeMap::new() };
        let whole_bytes = manifest.read(folder, head, plan)?;
        let Self { path, file, .. } = &mut manifest;
        let trouble = |error: std::io::Error| unwritable(path, &error);
        file.set_len(whole_bytes).and_then(|()| file.seek(SeekFrom::End(0))).map_err(trouble)?;
        if whole_bytes == 0 {
            file.write_all(line(head).as_bytes()).map_err(trouble)?;
        }
        Ok(manifest)
    }

    /// How many pictures it has, from 0 on.
    pub(super) fn count(&self) -> u32 {
        self.next
    }

    /// Reads what is there. Returns the bytes up to the end of the last whole line.
    fn read(&mut self, folder: &Path, head: &ManifestHead, plan: &DatasetPlan) -> Result<u64, Error> {
        let mut input = BufReader::new(&self.file);
        let (mut buffer, mut whole_bytes) = (Vec::new(), 0);
        for number in 1usize.. {
            buffer.clear();
            let problem = |rule: String| {
                let help = "give another folder with --out, or remove the file, after which all pictures are made anew";
                Error::new(format!("{}:{number}", self.path.display()), rule, help)
            };
            let most = if number == 1 { MAX_HEAD } else { MAX_LINE };
            let read = (&mut input).take(most).read_until(b'\n', &mut buffer);
            let size = read.map_err(|error| problem(format!("the line cannot be read: {error}")))? as u64;
            if buffer.last() != Some(&b'\n') {
                if size == most {
                    return Err(problem(format!("the line has {most} bytes or more, and must have fewer")));
                }
                break;
            }
            if number == 1 {
                let found: ManifestHead = serde_json::from_slice(&buffer)
                    .map_err(|error| problem(format!("no set of this version: {error}")))?;
                if let Some(key) = head.difference(&found) {
                    return Err(problem(format!("the folder has another set: its `{key}` is another one")));
                }
            } else {
                let found: PoseLine =
                    serde_json::from_slice(&buffer).map_err(|error| problem(format!("no picture: {error}")))?;
                if found.pose != self.next {
                    return Err(problem(format!("the picture is {}, and must be {}", found.pose, self.next)));
                }
                if !is_listed(&found, plan) {
                    return Err(problem("the board is not where the file of places has it".to_owned()));
                }
                if !head.files.all(found.pose).iter().all(|name| folder.join(name).is_file()) {
                    self.incomplete.push(found.pose);
                }
                self.tally.add(&found);
                self.next += 1;
            }
            whole_bytes += size;
        }
        Ok(whole_bytes)
    }

    /// Notes that a picture is done: its line is written when those before it are.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(super) fn done(&mut self, done: PoseLine) -> Result<(), Error> {
        if done.pose < self.next {
            return Ok(());
        }
        self.early.insert(done.pose, done);
        while let Some(next) = self.early.remove(&self.next) {
            self.file.write_all(line(&next).as_bytes()).map_err(|error| unwritable(&self.path, &error))?;
            self.tally.add(&next);
            self.next += 1;
        }
        Ok(())
    }
}

/// Whether a picture has its board where the file of places, where there is one that reaches so far, puts it.
fn is_listed(found: &PoseLine, plan: &DatasetPlan) -> bool {
    let BoardPlaces::Listed(places) = &plan.places else { return true };
    let Some(place) = places.get(found.pose as usize) else { return true };
    let same = |key: &str, values: [f64; 3]| found.values.get(key) == Some(&json!(values));
    same("board.position_mm", place.position_mm.to_array()) && same("board.tilt_deg", place.tilt_deg.to_array())
}
