//! Pictures to PNG files. The bytes depend on the arguments only (and on the compressor's version): no time, no path.

use super::levels::{PIECE, levels16};
use crate::error::Error;
use crate::io::atomic::write_atomically;
use crate::io::metadata::{KEY, Notes, checked_size};
use crate::raster::Raster;
use crate::raster::transfer::Transfer;
use ::png::{
    BitDepth, ColorType, Compression, Encoder, Filter, PixelDimensions, ScaledFloat, SrgbRenderingIntent, Unit,
};
use rayon::prelude::*;
use std::borrow::Borrow;
use std::io::{self, Write};
use std::iter::once;
use std::path::Path;

/// How samples are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleCoding {
    /// How light becomes levels.
    pub transfer: Transfer,
    /// How levels are packed, which changes none of them.
    pub packing: SamplePacking,
}

impl From<Transfer> for SampleCoding {
    fn from(transfer: Transfer) -> Self {
        Self { transfer, packing: SamplePacking::Small }
    }
}

/// What is spared of a file that is packed without loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SamplePacking {
    /// Bytes.
    #[default]
    Small,
    /// Time, for more bytes.
    Fast,
}

/// The compressed picture is cut into chunks of this many bytes.
const CHUNK_BYTES: usize = 1 << 16;

/// Writes linear light in [0, 1] as 16-bit grey and returns how many pixels lay outside and were clamped.
///
/// The encoding is stated twice: by a chunk (gAMA 1.0, or sRGB) and in words under the key `Transfer`. A value that is
/// not a number is written as 0 and counted too. Rounding is to the nearest of the 65536 levels.
///
/// # Errors
/// A picture without pixels or too large, a pitch that PNG cannot state, and those of [`write_atomically`].
pub fn write_grey16(path: &Path, picture: &Raster<f32>, transfer: Transfer, notes: &Notes<'_>) -> Result<usize, Error> {
    write_grey16_strips(path, (picture.width(), picture.height()), once(picture), transfer, notes)
}

/// The same of a picture of the given columns and rows that comes in strips, one below the other; it is never held as a
/// whole.
///
/// # Errors
/// Those of [`write_grey16`], and strips that are not the whole picture.
pub fn write_grey16_strips(
    path: &Path,
    size: (usize, usize),
    strips: impl Iterator<Item: Borrow<Raster<f32>>>,
    coding: impl Into<SampleCoding>,
    notes: &Notes<'_>,
) -> Result<usize, Error> {
    let SampleCoding { transfer, packing } = coding.into();
    let mut clamped = 0;
    let form = SampleForm { color: ColorType::Grayscale, depth: BitDepth::Sixteen, transfer, packing };
    let strips = strips.map(|strip| {
        let data = strip.borrow().data();
        clamped += data.iter().filter(|light| !(0.0..=1.0).contains(*light)).count();
        levels(data, transfer)
    });
    write(path, size, form, strips, notes)?;
    Ok(clamped)
}

/// Writes linear red, green and blue light in [0, 1] as 16-bit numbers and returns how many pixels had a channel outside
/// and were clamped; the rest as [`write_grey16_strips`].
///
/// # Errors
/// Those of [`write_grey16_strips`].
pub fn write_rgb16_strips(
    path: &Path,
    size: (usize, usize),
    strips: impl Iterator<Item: Borrow<Raster<[f32; 3]>>>,
    coding: impl Into<SampleCoding>,
    notes: &Notes<'_>,
) -> Result<usize, Error> {
    let SampleCoding { transfer, packing } = coding.into();
    let mut clamped = 0;
    let form = SampleForm { color: ColorType::Rgb, depth: BitDepth::Sixteen, transfer, packing };
    let outside = |light: &f32| !(0.0..=1.0).contains(light);
    let strips = strips.map(|strip| {
        let data = strip.borrow().data();
        clamped += data.iter().filter(|pixel| pixel.iter().any(outside)).count();
        levels(data.as_flattened(), transfer)
    });
    write(path, size, form, strips, notes)?;
    Ok(clamped)
}

/// Writes a figure of 8-bit sRGB red, green and blue.
///
/// # Errors
/// Those of [`write_grey16`].
pub fn write_rgb(path: &Path, figure: &Raster<[u8; 3]>, notes: &Notes<'_>) -> Result<(), Error> {
    let form = SampleForm {
        color: ColorType::Rgb,
        depth: BitDepth::Eight,
        transfer: Transfer::Srgb,
        packing: SamplePacking::Small,
    };
    write(path, (figure.width(), figure.height()), form, once(figure.data().as_flattened()), notes)
}

/// Writes a figure of 8-bit sRGB red, green, blue and opacity; the colours are not multiplied by the opacity.
///
/// # Errors
/// Those of [`write_grey16`].
pub fn write_rgba(path: &Path, figure: &Raster<[u8; 4]>, notes: &Notes<'_>) -> Result<(), Error> {
    let form = SampleForm {
        color: ColorType::Rgba,
        depth: BitDepth::Eight,
        transfer: Transfer::Srgb,
        packing: SamplePacking::Small,
    };
    write(path, (figure.width(), figure.height()), form, once(figure.data().as_flattened()), notes)
}

/// The bytes of the nearest 16-bit levels.
fn levels(light: &[f32], transfer: Transfer) -> Vec<u8> {
    let pieces: Vec<Vec<u8>> = light.par_chunks(PIECE).map(|piece| levels16(piece, transfer, light.len())).collect();
    pieces.concat()
}

/// The bytes of the nearest 16-bit levels of sRGB, the larger byte first.
pub(in crate::io) fn srgb_levels16(light: &[f32]) -> Vec<u8> {
    levels(light, Transfer::Srgb)
}

/// What the samples of a file mean.
#[derive(Clone, Copy)]
struct SampleForm {
    color: ColorType,
    depth: BitDepth,
    transfer: Transfer,
    packing: SamplePacking,
}

fn write(
    path: &Path,
    (width, height): (usize, usize),
    form: SampleForm,
    strips: impl Iterator<Item: AsRef<[u8]>>,
    notes: &Notes<'_>,
) -> Result<(), Error> {
    checked_size(path, width, height)?;
    let density = notes.pitch_mm.map(|pitch| density(path, pitch)).transpose()?;
    write_atomically(path, |out| encode(out, (width as u32, height as u32), form, density, notes.json, strips))
}

fn encode(
    out: impl Write,
    (width, height): (u32, u32),
    form: SampleForm,
    density: Option<PixelDimensions>,
    json: &str,
    mut strips: impl Iterator<Item: AsRef<[u8]>>,
) -> io::Result<()> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(form.color);
    encoder.set_depth(form.depth);
    encoder.set_compression(match form.packing {
        SamplePacking::Small => Compression::Balanced,
        SamplePacking::Fast => Compression::Fastest,
    });
    if form.depth == BitDepth::Eight {
        // Figures are of a few colours in runs, which differences between pixels would break.
        encoder.set_filter(Filter::NoFilter);
    }
    match form.transfer {
        Transfer::Linear => encoder.set_source_gamma(ScaledFloat::from_scaled(100_000)),
        Transfer::Srgb => encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric),
    }
    encoder.set_pixel_dims(density);
    encoder.add_text_chunk("Software".to_owned(), KEY.to_owned())?;
    let words = match form.transfer {
        Transfer::Linear => "linear: level = light (gAMA 1.0)",
        Transfer::Srgb => "sRGB: the piecewise curve of IEC 61966-2-1",
    };
    encoder.add_text_chunk("Transfer".to_owned(), words.to_owned())?;
    if !json.is_empty() {
        encoder.add_itxt_chunk(KEY.to_owned(), json.to_owned())?;
    }
    let mut writer = encoder.write_header()?;
    let mut rows = writer.stream_writer_with_size(CHUNK_BYTES)?;
    strips.try_for_each(|strip| rows.write_all(strip.as_ref()))?;
    rows.finish()?;
    writer.finish()?;
    Ok(())
}

/// The pHYs chunk of square pixels: whole pixels in a metre, so the pitch is kept to half a pixel a metre (3e-6 of a
/// pitch of 5.5 um).
fn density(path: &Path, pitch_mm: f64) -> Result<PixelDimensions, Error> {
    let per_metre = (1000.0 / pitch_mm).round();
    // PNG's four-byte numbers end at 2^31 - 1.
    if !(1.0..=f64::from(i32::MAX)).contains(&per_metre) {
        let rule = format!("the pixel pitch is {pitch_mm} mm, and a PNG can state 1 to 2147483647 pixels in a metre");
        return Err(Error::new(path.display(), rule, "check the pixel pitch of the scene"));
    }
    Ok(PixelDimensions { xppu: per_metre as u32, yppu: per_metre as u32, unit: Unit::Meter })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::png::levels::level16;

    #[test]
    fn the_same_bytes_on_every_run() {
        let directory = tempfile::tempdir().unwrap();
        let picture = Raster::from_data(64, 64, (0..4096).map(|k| k as f32 / 4095.0).collect());
        let notes = Notes { json: "{\"a\":\"µ\"}", pitch_mm: Some(0.0055) };
        let bytes = |name: &str| {
            let path = directory.path().join(name);
            write_grey16(&path, &picture, Transfer::Srgb, &notes).unwrap();
            std::fs::read(path).unwrap()
        };
        assert_eq!(bytes("1.png"), bytes("2.png"));
    }

    /// Strips of any height give the bytes of the whole; too few or too many rows are an error.
    #[test]
    fn strips_make_the_picture() {
        let directory = tempfile::tempdir().unwrap();
        let picture = Raster::from_data(64, 64, (0..4096).map(|k| k as f32 / 4095.0).collect());
        let whole = directory.path().join("whole.png");
        write_grey16(&whole, &picture, Transfer::Linear, &Notes::default()).unwrap();
        let by_rows = |name: &str, heights: &[usize]| {
            let path = directory.path().join(name);
            let mut data = picture.data().iter().copied().chain([0.5].into_iter().cycle());
            let strips = heights.iter().map(|&h| Raster::from_data(64, h, data.by_ref().take(64 * h).collect()));
            write_grey16_strips(&path, (64, 64), strips, Transfer::Linear, &Notes::default())?;
            Ok::<_, Error>(std::fs::read(path).unwrap())
        };
        assert_eq!(by_rows("rows.png", &[1, 30, 33]).unwrap(), std::fs::read(whole).unwrap());
        for heights in [&[63][..], &[64, 1], &[]] {
            by_rows("wrong.png", heights).unwrap_err();
        }
        assert!(!directory.path().join("wrong.png").exists());
    }

    /// Packed fast, it is the same picture.
    #[test]
    fn packing_changes_no_sample() {
        let directory = tempfile::tempdir().unwrap();
        let picture = Raster::from_data(64, 64, (0..4096).map(|k| (k * k % 4099) as f32 / 4098.0).collect());
        let samples = |packing: SamplePacking| {
            let path = directory.path().join("a.png");
            let coding = SampleCoding { transfer: Transfer::Srgb, packing };
            write_grey16_strips(&path, (64, 64), once(&picture), coding, &Notes::default()).unwrap();
            let decoder = ::png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
            let mut reader = decoder.read_info().unwrap();
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut bytes).unwrap();
            bytes
        };
        let small = samples(SamplePacking::Small);
        assert_eq!(samples(SamplePacking::Fast), small);
        let expected: Vec<u8> =
            picture.data().iter().flat_map(|light| level16(*light, Transfer::Srgb).to_be_bytes()).collect();
        assert_eq!(small, expected);
    }

    #[test]
    fn values_outside_are_clamped_and_counted() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.png");
        let values = vec![-0.0, 0.0, 1.0, 0.5, -1e-9, 1.000_001, f32::NAN, f32::INFINITY];
        let picture = Raster::from_data(8, 1, values);
        assert_eq!(write_grey16(&path, &picture, Transfer::Linear, &Notes::default()).unwrap(), 4);
        let levels = [0, 0, 65535, 32768, 0, 65535, 0, 65535];
        for (&light, level) in picture.data().iter().zip(levels) {
            assert_eq!(level16(light, Transfer::Linear), level);
        }
    }

    #[test]
    fn colours_keep_their_channels() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.png");
        let pixels = vec![[0.0, 0.25, 1.0], [1.5, 0.5, -1.0], [0.75, 0.75, 0.75]];
        let picture = Raster::from_data(3, 1, pixels);
        assert_eq!(write_rgb16_strips(&path, (3, 1), once(picture), Transfer::Linear, &Notes::default()).unwrap(), 1);
        let decoder = ::png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        let levels: Vec<u16> = bytes.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect();
        assert_eq!(levels, [0, 16384, 65535, 65535, 32768, 0, 49151, 49151, 49151]);
    }

    #[test]
    fn a_size_or_pitch_that_png_cannot_hold_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.png");
        let write = |width, pitch_mm| {
            let picture = Raster::filled(width, 1, 0.0f32);
            write_grey16(&path, &picture, Transfer::Linear, &Notes { json: "", pitch_mm }).map_err(|p| p.rule)
        };
        assert!(write(0, None).unwrap_err().contains("0 x 1"));
        assert!(write(crate::raster::MAX_SIDE_PX + 1, None).unwrap_err().contains("65536 x 1"));
        for pitch in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 1e6] {
            assert!(write(1, Some(pitch)).unwrap_err().contains("pitch"), "{pitch}");
        }
        assert!(!path.exists());
    }
}
