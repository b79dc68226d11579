//! Pictures as data, and the files that hold them.

pub mod safe;
pub mod transfer;
pub mod png;
pub mod exr;
mod photo;
pub mod compare;

use crate::problem::Problem;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::Path;
use transfer::Transfer;

/// What a picture file says besides its pixels.
#[derive(Debug, Clone, Copy, Default)]
pub struct Notes<'a> {
    /// JSON text about the picture, kept under the key `biprism`; none when empty.
    pub json: &'a str,
    /// Side of a square pixel on the sensor, in mm.
    pub pitch_mm: Option<f64>,
}

/// What is known of a picture that was read: how its file stores it, and how that became linear light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Metadata {
    /// `PNG`, `EXR`, `JPEG`, `BMP` or `PNM`.
    pub format: &'static str,
    /// What a pixel is in the file: `16-bit grey`, `f16 R, G, B`.
    pub samples: String,
    /// The curve from stored value to light: `linear`, `sRGB` or `power 2.2`.
    pub transfer: String,
    /// Who says so: a chunk of the file, the caller, or the format itself.
    pub transfer_source: String,
    /// Whether colour was reduced to luminance (see [`transfer::luminance`]).
    pub from_colour: bool,
    /// Side of a square pixel in mm, where the file states it.
    pub pitch_mm: Option<f64>,
    /// Texts of the file by keyword; the program's own JSON is under `biprism`.
    pub texts: BTreeMap<String, String>,
}

/// Reads a PNG, an EXR or a photograph (JPEG, BMP, PNM), known by its first bytes and not by its name, as linear light.
///
/// `stated` says which curve a PNG has. It is needed where the file does not say, and beats the file where both speak;
/// [`Metadata::transfer_source`] keeps which was used. An EXR is linear by definition.
///
/// # Errors
/// A file that is missing, of another format, damaged, outside the limits of [`MAX_SIDE_PX`] and [`MAX_PIXELS`], not
/// opaque, not finite, or that leaves the transfer curve to be guessed.
pub fn read(path: &Path, stated: Option<Transfer>) -> Result<(Raster<f32>, Metadata), Problem> {
    let mut file = open(path)?;
    let mut start = Vec::new();
    (&mut file)
        .take(8)
        .read_to_end(&mut start)
        .and_then(|_| file.rewind())
        .map_err(|error| unreadable(path, &error))?;
    if start == png::SIGNATURE {
        png::read_from(path, file, stated)
    } else if start.starts_with(&exr::SIGNATURE) {
        exr::read_from(path, file, stated)
    } else if let Some(format) = photo::format(&start) {
        photo::read_from(path, file, format, stated)
    } else {
        let found =
            if start.is_empty() { "is empty".to_owned() } else { format!("begins with the bytes {start:02x?}") };
        let rule = format!("the file {found}, and must be a PNG, OpenEXR, JPEG, BMP or PNM picture");
        Err(Problem::new(path.display(), rule, "convert it to PNG (16 bit, grey) or to OpenEXR"))
    }
}

/// Opens a regular file for reading.
fn open(path: &Path) -> Result<BufReader<File>, Problem> {
    let file = File::open(path).map_err(|error| unreadable(path, &error))?;
    if file.metadata().is_ok_and(|found| found.is_dir()) {
        return Err(Problem::new(path.display(), "this is a directory", "name a PNG or EXR file"));
    }
    Ok(BufReader::new(file))
}

fn unreadable(path: &Path, error: &io::Error) -> Problem {
    Problem::new(path.display(), format!("the file cannot be read: {error}"), "check the name and the right to read it")
}

/// The key of [`Notes::json`] in a file, and the name of the program that wrote it.
const KEY: &str = "biprism";

/// Pictures have at most this many columns and this many rows.
pub const MAX_SIDE_PX: usize = 65_535;

/// Pictures have at most this many pixels: 1 GiB of f32.
pub const MAX_PIXELS: usize = 1 << 28;

/// Width and height, when a picture may have them.
///
/// # Errors
/// A side of zero pixels, or more than [`MAX_SIDE_PX`] or [`MAX_PIXELS`].
fn checked_size(path: &Path, width: usize, height: usize) -> Result<(usize, usize), Problem> {
    let rule = if width == 0 || height == 0 {
        "at least one pixel each way".to_owned()
    } else if width > MAX_SIDE_PX || height > MAX_SIDE_PX {
        format!("at most {MAX_SIDE_PX} pixels each way")
    } else if width * height > MAX_PIXELS {
        format!("at most {MAX_PIXELS} pixels")
    } else {
        return Ok((width, height));
    };
    let found = format!("the picture is {width} x {height}, and must have {rule}");
    Err(Problem::new(path.display(), found, "use a picture of another size"))
}

/// A picture of `width` x `height` values, row by row from the top left.
///
/// Pixel (i, j) covers `[i, i+1) x [j, j+1)`; its centre is at (i + 0.5, j + 0.5).
#[derive(Debug, Clone, PartialEq)]
pub struct Raster<T> {
    width: usize,
    height: usize,
    data: Vec<T>,
}

impl<T: Copy> Raster<T> {
    /// A picture of one value.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self { width, height, data: vec![value; width * height] }
    }

    /// A picture of the given values, row by row.
    ///
    /// # Panics
    /// When `data` does not hold `width * height` values.
    pub fn from_data(width: usize, height: usize, data: Vec<T>) -> Self {
        assert_eq!(data.len(), width * height, "a raster needs width x height values");
        Self { width, height, data }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All values, row by row.
    pub fn data(&self) -> &[T] {
        &self.data
    }

    /// All values, row by row, to be changed.
    pub fn data_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// Row `j`.
    pub fn row(&self, j: usize) -> &[T] {
        &self.data[j * self.width..(j + 1) * self.width]
    }

    /// The value of pixel (i, j).
    #[inline(always)]
    pub fn get(&self, i: usize, j: usize) -> T {
        self.data[j * self.width + i]
    }

    /// The columns `[first, last)` as a picture of their own.
    #[must_use]
    pub fn columns(&self, first: usize, last: usize) -> Self {
        let data = (0..self.height).flat_map(|j| self.row(j)[first..last].iter().copied()).collect();
        Self::from_data(last - first, self.height, data)
    }

    /// Each value changed by `f`.
    #[must_use]
    pub fn map<U: Copy>(&self, f: impl Fn(T) -> U) -> Raster<U> {
        Raster::from_data(self.width, self.height, self.data.iter().map(|&v| f(v)).collect())
    }
}
