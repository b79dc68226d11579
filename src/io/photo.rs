//! What other programs and cameras write: JPEG and BMP through the `image` library, to linear light.

use super::curve_source::CurveSource;
use super::inputs::unreadable;
use super::jpeg::{self, JpegOutline};
use super::jpeg_scan::{self, Coded};
use super::memory::{PICTURE_BYTES, check_length, check_memory, length};
use super::metadata::{Metadata, checked_size};
use crate::error::Error;
use crate::raster::Raster;
use crate::raster::transfer::luminance;
use image::{ColorType, ImageDecoder, ImageFormat, ImageReader};
use std::collections::BTreeMap;
use std::io::{self, BufRead, Cursor, Read, Seek};
use std::path::Path;

/// The format that a file's first bytes announce, if it is one of these.
pub(super) fn format(start: &[u8]) -> Option<ImageFormat> {
    let format = image::guess_format(start).ok()?;
    matches!(format, ImageFormat::Jpeg | ImageFormat::Bmp).then_some(format)
}

fn name(format: ImageFormat) -> &'static str {
    if format == ImageFormat::Jpeg { "JPEG" } else { "BMP" }
}

/// The picture as linear light. None of these formats states its curve in a way that all programs keep, so the caller
/// must: sRGB for nearly every photograph.
pub(super) fn read_from(
    path: &Path,
    mut source: impl BufRead + Seek,
    format: ImageFormat,
    curve: CurveSource,
) -> Result<(Raster<f32>, Metadata), Error> {
    let help = "check that the file is whole, or convert it to PNG";
    let damaged = |error: image::ImageError| {
        Error::new(path.display(), format!("the {} cannot be read: {error}", name(format)), help)
    };
    let (transfer, transfer_source) = curve.of_silent(path, name(format))?;
    // Look at the file before the library takes memory for it.
    let needs = PhotoNeeds::of(path, &mut source, format)?;
    let whole = if format == ImageFormat::Jpeg { Some(WholeJpeg::read(path, &mut source)?) } else { None };

    // Check size, colours, memory and length.
    let decoder = ImageReader::with_format(&mut source, format).into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let (width, height) = checked_size(path, width as usize, height as usize)?;
    let colour = decoder.color_type();
    if colour.has_alpha() {
        let rule = "the picture has an opacity, which has no meaning for light";
        return Err(Error::new(path.display(), rule, "save it without opacity"));
    }
    needs.check(path, (width, height), decoder.total_bytes())?;

    // Decode, and take the light by a table of all values.
    let mut samples = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut samples).map_err(damaged)?;
    if let Some(whole) = whole.filter(|_| needs.progressive) {
        whole.check_last_scan(path, &samples)?;
    }
    let table: Vec<f64> = (0..=255u8).map(|v| transfer.decode(f64::from(f32::from(v) / 255.0))).collect();
    let light = |v: u8| table[usize::from(v)];
    let data = match colour {
        ColorType::L8 => samples.iter().map(|&v| light(v) as f32).collect(),
        _ => {
            let mean = |p: &[u8; 3]| luminance(light(p[0]), light(p[1]), light(p[2])) as f32;
            samples.as_chunks::<3>().0.iter().map(mean).collect()
        }
    };
    let metadata = Metadata {
        format: name(format),
        samples: format!("8 bit {}", if colour.has_color() { "RGB" } else { "grey" }),
        transfer: transfer.name().to_owned(),
        transfer_source: transfer_source.to_owned(),
        from_colour: colour.has_color(),
        pitch_mm: None,
        texts: BTreeMap::new(),
    };
    Ok((Raster::from_data(width, height, data), metadata))
}

/// A JPEG file whose codes reach to the end of its picture.
struct WholeJpeg {
    bytes: Vec<u8>,
    /// Where its end is marked.
    end: Option<usize>,
}

impl WholeJpeg {
    /// Reads the file from its start, and goes back there. One that was cut off and then ended is refused.
    fn read(path: &Path, source: &mut (impl BufRead + Seek)) -> Result<Self, Error> {
        let mut bytes = Vec::new();
        source.read_to_end(&mut bytes).and_then(|_| source.rewind()).map_err(|error| unreadable(path, &error))?;
        match jpeg_scan::coded(&bytes) {
            Coded::Cut => Err(Self::cut(path)),
            Coded::Whole(end) => Ok(Self { bytes, end: Some(end) }),
            Coded::Unknown => Ok(Self { bytes, end: None }),
        }
    }

    /// Refuses a progressive file whose last scan ends early: there other bytes behind it make another picture.
    fn check_last_scan(mut self, path: &Path, samples: &[u8]) -> Result<(), Error> {
        let Some(end) = self.end else { return Ok(()) };
        self.bytes.truncate(end - 2);
        self.bytes.extend([0x5a; 64].into_iter().chain([0xff, 0xd9]));
        let mut reader = ImageReader::with_format(Cursor::new(&self.bytes), ImageFormat::Jpeg);
        reader.no_limits();
        match reader.decode() {
            Ok(other) if other.as_bytes() != samples => Err(Self::cut(path)),
            _ => Ok(()),
        }
    }

    fn cut(path: &Path) -> Error {
        let rule = "the JPEG is damaged: its coded data end before its picture does, as in a file that was cut short and then ended";
        Error::new(path.display(), rule, "copy the file again, or export it anew")
    }
}

/// What a file asks for, as far as it tells before it is decoded.
struct PhotoNeeds {
    file_bytes: u64,
    /// Bytes that are held besides the decoded samples, for each pixel and at all.
    held: [u64; 2],
    /// Bytes that the file must have, and pixels that each of them may stand for.
    least: u64,
    pixels_a_byte: u64,
    /// Whether it is a progressive JPEG, which is decoded twice.
    progressive: bool,
}

impl PhotoNeeds {
    /// Goes through the file and back to its start. A JPEG that is cut off is refused here, since the library would fill it
    /// up with grey.
    fn of(path: &Path, source: &mut (impl BufRead + Seek), format: ImageFormat) -> Result<Self, Error> {
        let failed = |error: io::Error| unreadable(path, &error);
        let file_bytes = length(source).map_err(failed)?;
        let needs = if format == ImageFormat::Jpeg {
            let JpegOutline { progressive, whole } = jpeg::outline(source).map_err(failed)?;
            if !whole {
                let rule = "the JPEG is damaged: the marker of its end is missing, as in a file that is cut short";
                return Err(Error::new(path.display(), rule, "copy the file again, or export it anew"));
            }
            if file_bytes > PICTURE_BYTES {
                let rule = format!("the file has {file_bytes} bytes, and a JPEG may have {PICTURE_BYTES}");
                return Err(Error::new(path.display(), rule, "use a smaller picture"));
            }
            // The file itself, and where it is progressive the coefficients of three components in two bytes each.
            // The file is held twice, and where it is progressive its samples are.
            let held = [if progressive { 9 } else { 0 }, 2 * file_bytes];
            Self { file_bytes, held, least: 0, pixels_a_byte: jpeg::PIXELS_A_BYTE, progressive }
        } else {
            let least = bmp_bytes(source).map_err(failed)?.unwrap_or(0);
            Self { file_bytes, held: [0; 2], least, pixels_a_byte: u64::MAX, progressive: false }
        };
        source.rewind().map_err(failed)?;
        Ok(needs)
    }

    /// Refuses a picture whose samples take `decoded` bytes and with all else more than a picture may, and a file too short
    /// for it.
    fn check(&self, path: &Path, size: (usize, usize), decoded: u64) -> Result<(), Error> {
        let pixels = size.0 as u64 * size.1 as u64;
        check_memory(path, size, decoded.saturating_add(self.held[0] * pixels + self.held[1]))?;
        check_length(path, size, self.file_bytes, self.least.max(pixels.div_ceil(self.pixels_a_byte)))
    }
}

/// Bytes that the pixels of a BMP need at the least, with all that stands before them; `None` where its header is none that
/// the library reads.
fn bmp_bytes(source: &mut impl Read) -> io::Result<Option<u64>> {
    let mut head = Vec::new();
    source.take(34).read_to_end(&mut head)?;
    let u16_at = |at: usize| Some(u64::from(u16::from_le_bytes(*head.get(at..)?.first_chunk()?)));
    let u32_at = |at: usize| Some(u32::from_le_bytes(*head.get(at..)?.first_chunk()?));
    let needed = || {
        let start = u64::from(u32_at(10)?);
        let core = u32_at(14)? == 12;
        let (width, height, bits, packing) = if core {
            (u16_at(18)?, u16_at(20)?, u16_at(24)?, 0)
        } else {
            let side = |at| Some(u64::from(u32_at(at)?.cast_signed().unsigned_abs()));
            (side(18)?, side(22)?, u16_at(28)?, u32_at(30)?)
        };
        let pixels = match packing {
            // Run lengths: two bytes for at most 255 pixels, and no run goes on in the next row.
            1 | 2 => height.saturating_mul(2 * width.div_ceil(255)),
            // Rows end at four bytes, the last one perhaps at its own end.
            _ => height.saturating_mul((width * bits).div_ceil(32) * 4).saturating_sub(3),
        };
        Some(start.saturating_add(pixels))
    };
    Ok(needed())
}
