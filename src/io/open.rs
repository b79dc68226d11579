//! Opening a file of a picture.

use super::inputs;
use crate::error::Error;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

/// Opens a regular file for reading.
pub(super) fn open(path: &Path) -> Result<BufReader<File>, Error> {
    let file = inputs::open(path).map_err(|error| unreadable(path, &error))?;
    if file.metadata().is_ok_and(|found| found.is_dir()) {
        return Err(Error::new(path.display(), "this is a directory", "name a PNG or EXR file"));
    }
    Ok(BufReader::new(file))
}

pub(super) fn unreadable(path: &Path, error: &io::Error) -> Error {
    Error::new(path.display(), format!("the file cannot be read: {error}"), "check the name and the right to read it")
}
