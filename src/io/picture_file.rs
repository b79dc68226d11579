//! A picture from a file of any format that is known by its first bytes.

use super::curve_source::CurveSource;
use super::metadata::Metadata;
use super::open::{open, unreadable};
use super::{exr, photo, png, pnm, tiff};
use crate::error::Error;
use crate::raster::Raster;
use crate::raster::transfer::decoded;
use std::io::{Read, Seek};
use std::path::Path;

/// Reads a PNG, an EXR or a photograph (TIFF, JPEG, BMP, PNM), known by its first bytes and not by its name, as linear light.
///
/// `curve` says where its transfer curve comes from: a stated one is needed where the file does not say, and where both speak
/// they must agree, unless it is forced; [`Metadata::transfer_source`] keeps which was used. An EXR is linear by definition. What a file of this program says in
/// its notes of a sensor's gamma is undone, unless a curve is stated; of colours, after they were reduced to luminance.
///
/// # Errors
/// A file that is missing, of another format, damaged, too short for its pixels, outside the limits of
/// [`crate::raster::MAX_SIDE_PX`], [`crate::raster::MAX_PIXELS`] and [`super::memory::PICTURE_BYTES`] (all of which its header
/// is asked for before memory is taken), not opaque, not finite, that leaves the transfer curve to be guessed, or
/// that states another curve than the caller.
pub fn read(path: &Path, curve: impl Into<CurveSource>) -> Result<(Raster<f32>, Metadata), Error> {
    let curve = curve.into();
    let (picture, metadata) = without_notes(path, curve)?;
    match metadata.gamma().filter(|_| curve.stated().is_none()) {
        Some(gamma) => {
            let (transfer, transfer_source) = (format!("power {gamma}"), "the file's notes".to_owned());
            Ok((decoded(&picture, gamma), Metadata { transfer, transfer_source, ..metadata }))
        }
        None => Ok((picture, metadata)),
    }
}

/// [`read`] without a look at the notes.
fn without_notes(path: &Path, curve: CurveSource) -> Result<(Raster<f32>, Metadata), Error> {
    let mut file = open(path)?;
    let mut start = Vec::new();
    (&mut file)
        .take(8)
        .read_to_end(&mut start)
        .and_then(|_| file.rewind())
        .map_err(|error| unreadable(path, &error))?;
    if start == png::SIGNATURE {
        png::read_from(path, file, curve)
    } else if start.starts_with(&exr::SIGNATURE) {
        exr::read_from(path, file, curve)
    } else if pnm::is_pnm(&start) {
        pnm::read_from(path, file, curve)
    } else if tiff::is_tiff(&start) {
        tiff::read_from(path, file, curve)
    } else if let Some(format) = photo::format(&start) {
        photo::read_from(path, file, format, curve)
    } else {
        let found =
            if start.is_empty() { "is empty".to_owned() } else { format!("begins with the bytes {start:02x?}") };
        let rule = format!("the file {found}, and must be a PNG, OpenEXR, TIFF, JPEG, BMP or PNM picture");
        Err(Error::new(path.display(), rule, "convert it to PNG (16 bit, grey) or to OpenEXR"))
    }
}
