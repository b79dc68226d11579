//! Picture metadata: what a file says besides its pixels, and the sizes that it may have.

use super::curve_source::AS_STORED;
use crate::error::Error;
use crate::raster::{MAX_PIXELS, MAX_SIDE_PX};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

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
    /// `PNG`, `EXR`, `TIFF`, `JPEG`, `BMP` or `PNM`.
    pub format: &'static str,
    /// What a pixel is in the file: `16-bit grey`, `f16 R, G, B`.
    pub samples: String,
    /// The curve from stored value to light: `linear`, `sRGB` or `power 2.2`.
    pub transfer: String,
    /// Who says so: a chunk of the file, the caller, the format itself, or the program's own notes.
    pub transfer_source: String,
    /// Whether colour was reduced to luminance (see [`luminance`](crate::raster::transfer::luminance)).
    pub from_colour: bool,
    /// Side of a square pixel in mm, where the file states it.
    pub pitch_mm: Option<f64>,
    /// Texts of the file by keyword; the program's own JSON is under `biprism`.
    pub texts: BTreeMap<String, String>,
}

impl Metadata {
    /// Whether the values are as they are stored, since the file states no curve ([`super::CurveSource::FileOrStored`]).
    pub fn is_as_stored(&self) -> bool {
        self.transfer_source == AS_STORED
    }

    /// The gamma by which the program's own notes say that a sensor has coded the light.
    pub(super) fn gamma(&self) -> Option<f64> {
        let notes: serde_json::Value = serde_json::from_str(self.texts.get(KEY)?).ok()?;
        notes[GAMMA].as_f64().filter(|gamma| (0.1..=10.0).contains(gamma) && *gamma != 1.0)
    }
}

/// The key of a sensor's gamma in [`Notes::json`].
pub const GAMMA: &str = "gamma";

/// The key of [`Notes::json`] in a file, and the name of the program that wrote it.
pub(super) const KEY: &str = "biprism";

/// Width and height, when a picture may have them.
///
/// # Errors
/// A side of zero pixels, or more than [`MAX_SIDE_PX`] or [`MAX_PIXELS`].
pub(super) fn checked_size(path: &Path, width: usize, height: usize) -> Result<(usize, usize), Error> {
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
    Err(Error::new(path.display(), found, "use a picture of another size"))
}
