//! Files that are appended to while a run goes on, and read again by the next one.

use crate::error::Error;
use std::fs::{File, OpenOptions, TryLockError};
use std::path::Path;

/// The file at `path`, new or as it is, to which nobody else adds `what` meanwhile.
///
/// # Errors
/// When another program has it open so, or it cannot be written.
pub(super) fn open(path: &Path, what: &str) -> Result<File, Error> {
    let trouble = |error: std::io::Error| unwritable(path, &error);
    let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(trouble)?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            let rule = format!("another program adds {what} to the file");
            Err(Error::new(path.display(), rule, "wait until it is done, or give another folder with --out"))
        }
        // Some file systems know no locks.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}

/// What the user is told of such a file that cannot be written.
pub(super) fn unwritable(path: &Path, error: &std::io::Error) -> Error {
    Error::new(
        path.display(),
        format!("the file cannot be written: {error}"),
        "name a folder that you may write to, with --out",
    )
}
