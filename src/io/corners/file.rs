//! Corner files of any format.

use super::rules::{MOST_BYTES, check};
use super::view::View;
use super::{csv, json, opencv};
use crate::error::Problem;
use std::io::Read;
use std::path::Path;

/// A format of corner files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Comma-separated values.
    Csv,
    /// JSON.
    Json,
    /// YAML of OpenCV's `FileStorage`.
    OpenCv,
}

impl Format {
    /// The format that the ending of a file's name asks for.
    ///
    /// # Errors
    /// Any other ending.
    pub fn of(path: &Path) -> Result<Self, Problem> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match ending.as_str() {
            "csv" => Ok(Self::Csv),
            "json" => Ok(Self::Json),
            "yml" | "yaml" => Ok(Self::OpenCv),
            _ => Err(Problem::new(
                path.display(),
                format!("the ending is {ending:?}, and must be csv, json, yml or yaml"),
                "name the file after the format it shall have",
            )),
        }
    }
}

/// The text of a corner file. CSV and OpenCV hold a view's qualities only where every corner has one.
pub fn to_text(views: &[View], format: Format) -> String {
    match format {
        Format::Csv => csv::to_text(views),
        Format::Json => json::to_text(views),
        Format::OpenCv => opencv::to_text(views),
    }
}

/// The corners of a text; `place` is the file's name in messages.
///
/// # Errors
/// What is not of the format, a convention that is missing or unknown, a value that is not finite, a covariance that is
/// none, an index given twice in a view, and more than [`MOST_CORNERS`].
pub fn parse(text: &str, format: Format, place: &str) -> Result<Vec<View>, Problem> {
    let views = match format {
        Format::Csv => csv::parse(text, place),
        Format::Json => json::parse(text, place),
        Format::OpenCv => opencv::parse(text, place),
    }?;
    check(&views, place)?;
    Ok(views)
}

/// Reads a corner file; its name's ending tells the format.
///
/// # Errors
/// A file that cannot be read, is larger than [`MOST_BYTES`] or is no UTF-8, and those of [`parse`].
pub fn read(path: &Path) -> Result<Vec<View>, Problem> {
    let format = Format::of(path)?;
    let place = path.display().to_string();
    let unreadable = |error: std::io::Error| {
        Problem::new(&place, format!("the file cannot be read: {error}"), "check the name and the rights of the file")
    };
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut text = String::new();
    // One byte more than allowed tells a file that is too large, whatever its size is said to be.
    let size = file.take(MOST_BYTES + 1).read_to_string(&mut text).map_err(unreadable)?;
    if size as u64 > MOST_BYTES {
        return Err(Problem::new(
            &place,
            format!("the file is larger than {MOST_BYTES} bytes, the most for corners"),
            "give the file that `biprism corners` wrote",
        ));
    }
    parse(&text, format, &place)
}
