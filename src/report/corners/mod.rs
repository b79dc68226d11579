//! Corners to files and back: CSV for a table, JSON for a program, and the YAML of OpenCV's `FileStorage`.
//!
//! | file | a position is | ending |
//! |---|---|---|
//! | CSV, JSON | in px of the whole picture, pixel (i, j) centred at (i + 0.5, j + 0.5) | `.csv`, `.json` |
//! | OpenCV | in px of the whole picture, pixel (i, j) centred at (i, j) | `.yml`, `.yaml` |
//!
//! Every file names its convention, and a file that names none is refused: half a pixel is a hundred times the error of
//! a corner. The one function that goes between the two is [`move_centre`]. Numbers read back to the last bit (OpenCV
//! positions to half a unit in the last place, because of the shift).

mod csv;
mod json;
mod opencv;
#[cfg(test)]
mod tests;

use crate::problem::Problem;
use crate::vision::{Corner, Detection, Polarity};
use glam::{DMat2, DVec2};
use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;

/// Corners in a file at most.
pub const MOST_CORNERS: usize = 1_000_000;
/// Columns and rows are within this of 0.
pub const MOST_INDEX: i32 = 1_000_000;
/// Bytes in a file at most.
pub const MOST_BYTES: u64 = 1 << 28;
/// How a file of ours says where a pixel's centre lies.
const CENTRE: &str = "(i + 0.5, j + 0.5)";
/// How a file of OpenCV's convention says it.
const OPENCV_CENTRE: &str = "(i, j)";

/// Where the centre of pixel (i, j) lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelCentre {
    /// At (i + 0.5, j + 0.5): ours.
    Half,
    /// At (i, j): OpenCV's.
    Whole,
}

/// A position in px given in one convention, in another.
pub fn move_centre(position_px: DVec2, from: PixelCentre, to: PixelCentre) -> DVec2 {
    match (from, to) {
        (PixelCentre::Half, PixelCentre::Whole) => position_px - 0.5,
        (PixelCentre::Whole, PixelCentre::Half) => position_px + 0.5,
        _ => position_px,
    }
}

/// How well a corner was measured; a file of another program may not say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Covariance of the position, in px^2.
    pub covariance_px2: DMat2,
    /// Bright minus dark, in the unit of the picture.
    pub contrast: f64,
    /// Root mean square difference between picture and model, in the unit of the picture.
    pub residual: f64,
    /// Which diagonal is bright.
    pub polarity: Polarity,
}

/// A corner in a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Listed {
    /// Column and row.
    pub index: [i32; 2],
    /// Position in the whole picture, in px, in our own convention ([`PixelCentre::Half`]).
    pub position_px: DVec2,
    /// How well it was measured, where that is known.
    pub quality: Option<Quality>,
}

/// One view of the board: a half of the picture, or the whole of it.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// `left`, `right` or `whole`: lower-case letters.
    pub name: String,
    /// Its corners.
    pub corners: Vec<Listed>,
    /// How many candidates were turned down for each reason; kept in JSON only.
    pub rejected: Vec<(String, usize)>,
    /// The blur across both families of lines, in px; kept in JSON only.
    pub blur_px: Option<[f64; 2]>,
}

impl View {
    /// What was detected in the columns of a picture from `first_column` on.
    pub fn new(name: &str, first_column: usize, detection: &Detection) -> Self {
        let listed = |c: &Corner| Listed {
            index: c.index,
            position_px: c.position_px + DVec2::new(first_column as f64, 0.0),
            quality: Some(Quality {
                covariance_px2: c.covariance_px2,
                contrast: c.contrast,
                residual: c.residual,
                polarity: c.polarity,
            }),
        };
        Self {
            name: name.to_owned(),
            corners: detection.corners.iter().map(listed).collect(),
            rejected: detection.counts().into_iter().map(|(reason, n)| (reason.name().to_owned(), n)).collect(),
            blur_px: detection.sigma_px,
        }
    }
}

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

/// The rules that hold in every format.
fn check(views: &[View], place: &str) -> Result<(), Problem> {
    let mut names = BTreeSet::new();
    for view in views {
        let name = &view.name;
        if name.is_empty() || !name.bytes().all(|b| b.is_ascii_lowercase()) {
            return Err(broken(place, format!("a view is named {name:?}, and must be named in letters a to z")));
        }
        if !names.insert(name) {
            return Err(broken(place, format!("the view {name:?} is there twice, and must be there once")));
        }
        let mut indices = BTreeSet::new();
        for corner in &view.corners {
            let [i, j] = corner.index;
            let at = format!("corner ({i}, {j}) of the view {name:?}");
            if !indices.insert(corner.index) {
                return Err(broken(place, format!("{at} is there twice, and must be there once")));
            }
            if corner.index.iter().any(|i| i.unsigned_abs() > MOST_INDEX.unsigned_abs()) {
                return Err(broken(place, format!("{at} must have a column and a row within {MOST_INDEX} of 0")));
            }
            if !corner.position_px.is_finite() {
                return Err(broken(place, format!("{at} lies at {}, and must lie at finite px", corner.position_px)));
            }
            let Some(quality) = &corner.quality else { continue };
            let v = quality.covariance_px2;
            let variances = v.x_axis.x >= 0.0 && v.y_axis.y >= 0.0;
            // A determinant of 0 may come out slightly below it.
            let positive = variances && v.determinant() >= -1e-12 * v.x_axis.x * v.y_axis.y;
            if !(v.is_finite() && positive && v.x_axis.y == v.y_axis.x) {
                return Err(broken(
                    place,
                    format!("{at} has the covariance {v}, and must have a symmetric, positive one"),
                ));
            }
            if !(quality.contrast.is_finite() && quality.contrast >= 0.0) {
                return Err(broken(
                    place,
                    format!("{at} has the contrast {}, and must have one of 0 or more", quality.contrast),
                ));
            }
            if !(quality.residual.is_finite() && quality.residual >= 0.0) {
                return Err(broken(
                    place,
                    format!("{at} has the residual {}, and must have one of 0 or more", quality.residual),
                ));
            }
        }
    }
    Ok(())
}

/// A file that says how many corners it has must have them: one that was cut between two lines has fewer.
fn same_count(stated: Option<usize>, views: &[View], place: &str) -> Result<(), Problem> {
    let found: usize = views.iter().map(|v| v.corners.len()).sum();
    match stated.filter(|&count| count != found) {
        None => Ok(()),
        Some(count) => Err(broken(place, format!("it holds {found} corners, and says that it has {count}"))),
    }
}

fn broken(place: &str, rule: String) -> Problem {
    Problem::new(place, rule, "mend the file, or write it again with `biprism corners`")
}

fn too_many(place: &str) -> Problem {
    Problem::new(
        place,
        format!("the file holds more than {MOST_CORNERS} corners, the most that are taken"),
        "give the corners of one picture",
    )
}

fn polarity_name(polarity: Polarity) -> &'static str {
    match polarity {
        Polarity::Main => "main",
        Polarity::Anti => "anti",
    }
}

fn polarity_of(name: &str) -> Option<Polarity> {
    [Polarity::Main, Polarity::Anti].into_iter().find(|&p| polarity_name(p) == name)
}
