//! Which files a run of the command has read, so that none of them is written over: what a user gave is never lost.
//!
//! Every file is opened for reading by [`open`] and written by [`super::atomic`], which asks here. A program that uses the
//! library may read and rewrite as it likes: nothing is noted before [`watch`].

use crate::error::Error;
use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What was read since [`watch`]; `None` before.
static READ: Mutex<Option<Vec<FileIdentity>>> = Mutex::new(None);

/// What tells a file from others, whatever it is called: device and inode, or else its full path without links.
#[derive(Debug, Clone, PartialEq, Eq)]
struct FileIdentity {
    #[cfg(unix)]
    inode: [u64; 2],
    #[cfg(not(unix))]
    path: PathBuf,
}

impl FileIdentity {
    #[cfg(unix)]
    fn of(_: &Path, metadata: &Metadata) -> Option<Self> {
        use std::os::unix::fs::MetadataExt;
        Some(Self { inode: [metadata.dev(), metadata.ino()] })
    }

    #[cfg(not(unix))]
    fn of(path: &Path, _: &Metadata) -> Option<Self> {
        Some(Self { path: std::fs::canonicalize(path).ok()? })
    }
}

fn read() -> MutexGuard<'static, Option<Vec<FileIdentity>>> {
    // A list of whole entries stays right whoever panicked.
    READ.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on, what is read is not written over.
pub fn watch() {
    read().get_or_insert_default();
}

/// Opens a file for reading.
///
/// # Errors
/// Those of [`File::open`].
pub fn open(path: &Path) -> io::Result<File> {
    let file = File::open(path)?;
    note(path, &file)?;
    Ok(file)
}

/// The text of the file at `path`, of at most `most` bytes. `what` says what such a file is for, and `help` what to give instead
/// of a larger one.
///
/// # Errors
/// A file that cannot be read, is larger, or is no UTF-8.
pub(super) fn read_text(path: &Path, most: u64, what: &str, help: &str) -> Result<String, Error> {
    let place = path.display().to_string();
    let unreadable = |error: io::Error| {
        Error::new(&place, format!("the file cannot be read: {error}"), "check the name and the rights of the file")
    };
    let file = open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    // One byte more than allowed tells a file that is too large, whatever its size is said to be.
    let size = file.take(most + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if size as u64 > most {
        return Err(Error::new(&place, format!("the file is larger than {most} bytes, the most for {what}"), help));
    }
    String::from_utf8(bytes).map_err(|wrong| not_utf8(&place, wrong.as_bytes()))
}

/// What the user is told of a text at `place` that begins with these bytes.
pub fn not_utf8(place: impl std::fmt::Display, bytes: &[u8]) -> Error {
    let utf16 = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) || bytes.contains(&0);
    let rule = format!("the text is not UTF-8{}", if utf16 { ", but UTF-16 as it seems" } else { "" });
    Error::new(place, rule, "save it as UTF-8 (in a spreadsheet \"CSV UTF-8\"); check the format and the extension")
}

/// What the user is told of a file that cannot be read.
pub(super) fn unreadable(path: &Path, error: &io::Error) -> Error {
    Error::new(path.display(), format!("the file cannot be read: {error}"), "check the name and the right to read it")
}

/// Notes that `file`, called `path`, is read.
///
/// # Errors
/// Those of [`File::metadata`].
pub fn note(path: &Path, file: &File) -> io::Result<()> {
    let metadata = file.metadata()?;
    if let (Some(list), true, Some(identity)) = (read().as_mut(), metadata.is_file(), FileIdentity::of(path, &metadata))
        && !list.contains(&identity)
    {
        list.push(identity);
    }
    Ok(())
}

/// Whether `path`, also through links, is a file that was read.
pub(crate) fn was_read(path: &Path) -> bool {
    let identity = std::fs::metadata(path).ok().and_then(|metadata| FileIdentity::of(path, &metadata));
    identity.is_some_and(|identity| read().as_ref().is_some_and(|list| list.contains(&identity)))
}

/// What was read of `path` was its old content, which is to be replaced: a golden.
pub fn release(path: &Path) {
    let identity = std::fs::metadata(path).ok().and_then(|metadata| FileIdentity::of(path, &metadata));
    if let Some(list) = read().as_mut() {
        list.retain(|known| Some(known) != identity.as_ref());
    }
}

/// Refuses outputs that would replace a file that was read, or one another. Asked before any work, so that none is in vain.
///
/// # Errors
/// The first such output.
pub(crate) fn check_outputs(paths: &[PathBuf]) -> Result<(), Error> {
    for (k, path) in paths.iter().enumerate() {
        check_output(path)?;
        let target = final_target(path);
        if paths[..k].iter().any(|earlier| final_target(earlier) == target) {
            let rule = "the file is to be written twice in one run";
            return Err(Error::new(path.display(), rule, "give each output a name of its own"));
        }
    }
    Ok(())
}

/// Refuses one output that would replace a file that was read.
///
/// # Errors
/// Such an output.
pub(super) fn check_output(path: &Path) -> Result<(), Error> {
    if was_read(path) {
        let rule = "the file was read in this run, and would be written over";
        return Err(Error::new(path.display(), rule, "name another file to be written"));
    }
    Ok(())
}

/// Links of one path that are followed, at most, as the system does.
const MOST_LINKS: usize = 40;

/// Where a file of this name is written in the end: past symbolic links, also one that names no file yet; its folder by its
/// full path where it is there.
pub(super) fn final_target(path: &Path) -> PathBuf {
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(named) = std::fs::read_link(&target) else { break };
        target = match target.parent() {
            Some(folder) => folder.join(named),
            None => named,
        };
    }
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    match (std::fs::canonicalize(folder), target.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => target,
    }
}
