//! Corner files of any format.

use super::rules::{MOST_BYTES, check};
use super::view::CornerView;
use super::{csv, json, opencv};
use crate::error::Error;
use crate::io::inputs::read_text;
use std::borrow::Cow;
use std::path::Path;

/// A format of corner files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CornerFormat {
    /// Comma-separated values.
    Csv,
    /// JSON.
    Json,
    /// YAML of OpenCV's `FileStorage`.
    OpenCv,
}

impl CornerFormat {
    /// The format by the ending of a file's name.
    ///
    /// # Errors
    /// Any other ending.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match ending.as_str() {
            "csv" => Ok(Self::Csv),
            "json" => Ok(Self::Json),
            "yml" | "yaml" => Ok(Self::OpenCv),
            _ => Err(Error::new(
                path.display(),
                format!("the ending is {ending:?}, and must be csv, json, yml or yaml"),
                "name the file after the format it shall have",
            )),
        }
    }
}

/// The text of a corner file. CSV and OpenCV hold a view's qualities only where every corner has one.
pub fn to_text(views: &[CornerView], format: CornerFormat) -> String {
    match format {
        CornerFormat::Csv => csv::to_text(views),
        CornerFormat::Json => json::to_text(views),
        CornerFormat::OpenCv => opencv::to_text(views),
    }
}

/// The corners of a text; `place` is the file's name in messages.
///
/// # Errors
/// What is not of the format, a convention that is missing or unknown, a value that is not finite, a covariance that is
/// none, an index given twice in a view, and more than [`MOST_CORNERS`](super::MOST_CORNERS).
pub fn parse(text: &str, format: CornerFormat, place: &str) -> Result<Vec<CornerView>, Error> {
    // Spreadsheets begin a file with a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // Some end lines with a carriage return alone; places in the text stay what they are.
    let alone = !text.contains('\n') && text.contains('\r');
    let text = &if alone { Cow::Owned(text.replace('\r', "\n")) } else { Cow::Borrowed(text) };
    let views = match format {
        CornerFormat::Csv => csv::parse(text, place),
        CornerFormat::Json => json::parse(text, place),
        CornerFormat::OpenCv => opencv::parse(text, place),
    }?;
    check(&views, place)?;
    Ok(views)
}

/// Reads a corner file; its name's ending tells the format.
///
/// # Errors
/// A file that cannot be read, is larger than [`MOST_BYTES`] or is no UTF-8, and those of [`parse`].
pub fn read(path: &Path) -> Result<Vec<CornerView>, Error> {
    let format = CornerFormat::of(path)?;
    let text = read_text(path, MOST_BYTES, "corners", "give the file that `biprism corners` wrote")?;
    parse(&text, format, &path.display().to_string())
}
