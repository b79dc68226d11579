//! Netpbm's pictures (PBM, PGM, PPM as text or binary, PAM) to linear light, row by row.

use super::curve_source::CurveSource;
use super::inputs::unreadable;
use super::memory::{check_length, check_memory, length};
use super::metadata::{Metadata, checked_size};
use crate::error::Error;
use crate::raster::Raster;
use crate::raster::transfer::luminance;
use std::collections::BTreeMap;
use std::io::{self, BufRead, ErrorKind, Seek};
use std::path::Path;

/// Bytes of a header with its comments, at most.
const HEADER_BYTES: usize = 1 << 16;
/// The largest value that a file may name as its brightest.
const MAX_MAXVAL: usize = 65_535;

/// Whether a file that begins so is one of Netpbm's.
pub(super) fn is_pnm(start: &[u8]) -> bool {
    matches!(start, [b'P', b'1'..=b'7', ..])
}

/// How the samples of a file are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PnmEncoding {
    /// Decimal numbers between blanks.
    Text,
    /// Digits 0 and 1, with or without blanks between them; 1 is dark.
    TextBits,
    /// Eight pixels a byte, each row from a byte of its own; 1 is dark.
    Bits,
    /// One byte a sample, or two with the higher first where the brightest needs them.
    Binary,
}

/// What the header says.
#[derive(Debug, Clone, Copy)]
struct PnmHeader {
    width: usize,
    height: usize,
    /// Samples of a pixel: 1 or 3.
    channels: usize,
    /// The sample that stands for full light.
    maxval: usize,
    encoding: PnmEncoding,
}

impl PnmHeader {
    /// Bytes of a row of a binary file.
    fn row_bytes(&self) -> usize {
        match self.encoding {
            PnmEncoding::Bits => self.width.div_ceil(8),
            _ => self.width * self.channels * if self.maxval > 255 { 2 } else { 1 },
        }
    }

    /// Bytes that the pixels need at the least. As text every sample has a digit and, but for the last, a blank.
    fn least_bytes(&self) -> u64 {
        let samples = (self.width * self.height * self.channels) as u64;
        match self.encoding {
            PnmEncoding::Text => 2 * samples - 1,
            PnmEncoding::TextBits => samples,
            PnmEncoding::Bits | PnmEncoding::Binary => self.row_bytes() as u64 * self.height as u64,
        }
    }
}

/// The picture as linear light; the curve must be stated, since the formats name none.
pub(super) fn read_from(
    path: &Path,
    mut source: impl BufRead + Seek,
    curve: CurveSource,
) -> Result<(Raster<f32>, Metadata), Error> {
    let failed = |error: io::Error| unreadable(path, &error);
    let (transfer, transfer_source) = curve.of_silent(path, "PNM")?;
    // Read and check the header.
    let file_bytes = length(&mut source).map_err(failed)?;
    let header = header(&mut source).map_err(|rule| damaged(path, rule))?;
    let PnmHeader { width, height, channels, maxval, encoding } = header;
    checked_size(path, width, height)?;
    let row_samples = width * channels;
    check_memory(path, (width, height), (header.row_bytes() + 2 * row_samples) as u64)?;
    let read = source.stream_position().map_err(failed)?;
    check_length(path, (width, height), file_bytes - read, header.least_bytes())?;

    // Take the light of each row by a table of all values.
    let table: Vec<f64> = (0..=maxval).map(|v| transfer.decode(f64::from(v as f32 / maxval as f32))).collect();
    let mut data = Vec::with_capacity(width * height);
    let (mut bytes, mut samples) = (vec![0; header.row_bytes()], vec![0u16; row_samples]);
    for j in 0..height {
        row(&mut source, &header, &mut bytes, &mut samples).map_err(|rule| damaged(path, rule))?;
        if let Some(k) = samples.iter().position(|&v| usize::from(v) > maxval) {
            let rule = format!(
                "a sample of pixel ({}, {j}) is {}, and the brightest that the file's header allows is {maxval}",
                k / channels,
                samples[k]
            );
            return Err(damaged(path, rule));
        }
        let value = |v: u16| table[usize::from(v)];
        data.extend(samples.chunks_exact(channels).map(|pixel| match *pixel {
            [r, g, b] => luminance(value(r), value(g), value(b)) as f32,
            _ => value(pixel[0]) as f32,
        }));
    }
    let bits = if maxval > 255 && encoding != PnmEncoding::Bits { 16 } else { 8 };
    let metadata = Metadata {
        format: "PNM",
        samples: format!("{bits} bit {}", if channels == 3 { "RGB" } else { "grey" }),
        transfer: transfer.name().to_owned(),
        transfer_source: transfer_source.to_owned(),
        from_colour: channels == 3,
        pitch_mm: None,
        texts: BTreeMap::new(),
    };
    Ok((Raster::from_data(width, height, data), metadata))
}

fn damaged(path: &Path, rule: String) -> Error {
    Error::new(path.display(), rule, "check that the file is whole, or convert it to PNG")
}

/// The next byte, `None` at the end.
fn byte(source: &mut impl BufRead) -> Result<Option<u8>, String> {
    loop {
        match source.fill_buf() {
            Ok(buffer) => {
                let first = buffer.first().copied();
                source.consume(usize::from(first.is_some()));
                return Ok(first);
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(format!("the PNM cannot be read: {error}")),
        }
    }
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t'..=b'\r')
}

/// The next word of a header and the blank behind it, past comments; `left` bytes may still be read.
fn word(source: &mut impl BufRead, left: &mut usize) -> Result<String, String> {
    let mut word = String::new();
    let mut in_comment = false;
    loop {
        *left = left.checked_sub(1).ok_or_else(|| format!("the PNM's header has more than {HEADER_BYTES} bytes"))?;
        match byte(source)? {
            None => return Err("the PNM ends within its header".to_owned()),
            Some(b'\n' | b'\r') if in_comment => in_comment = false,
            Some(_) if in_comment => {}
            Some(b'#') if word.is_empty() => in_comment = true,
            Some(blank) if is_blank(blank) => {
                if !word.is_empty() {
                    return Ok(word);
                }
            }
            Some(other) if other.is_ascii_graphic() => word.push(char::from(other)),
            Some(other) => return Err(format!("the PNM's header holds the byte 0x{other:02x}")),
        }
    }
}

fn number(word: &str, what: &str) -> Result<usize, String> {
    let digits = word.bytes().all(|b| b.is_ascii_digit());
    let value = if digits { word.parse::<u32>().ok() } else { None };
    value.map(|v| v as usize).ok_or_else(|| format!("the PNM's {what} is {word:?}, and must be a whole number"))
}

/// The header; the source then stands at the first sample.
fn header(source: &mut impl BufRead) -> Result<PnmHeader, String> {
    let mut left = HEADER_BYTES;
    let mut magic = [0; 2];
    io::Read::read_exact(source, &mut magic).map_err(|_| "the PNM ends within its header".to_owned())?;
    if magic[1] == b'7' {
        return pam_header(source, &mut left);
    }
    let encoding = match magic[1] {
        b'1' => PnmEncoding::TextBits,
        b'2' | b'3' => PnmEncoding::Text,
        b'4' => PnmEncoding::Bits,
        _ => PnmEncoding::Binary,
    };
    let channels = if matches!(magic[1], b'3' | b'6') { 3 } else { 1 };
    let mut next = |what: &str| number(&word(source, &mut left)?, what);
    let (width, height) = (next("width")?, next("height")?);
    let maxval = if matches!(magic[1], b'1' | b'4') { 1 } else { checked_maxval(next("brightest value")?)? };
    Ok(PnmHeader { width, height, channels, maxval, encoding })
}

fn checked_maxval(maxval: usize) -> Result<usize, String> {
    if (1..=MAX_MAXVAL).contains(&maxval) {
        return Ok(maxval);
    }
    Err(format!("the PNM's brightest value is {maxval}, and must be within 1 .. {MAX_MAXVAL}"))
}

/// The header of a PAM: a line of key and value each, up to ENDHDR.
fn pam_header(source: &mut impl BufRead, left: &mut usize) -> Result<PnmHeader, String> {
    let [mut width, mut height, mut depth, mut maxval] = [None; 4];
    loop {
        let key = word(source, left)?;
        let place = match key.as_str() {
            "ENDHDR" => break,
            "WIDTH" => &mut width,
            "HEIGHT" => &mut height,
            "DEPTH" => &mut depth,
            "MAXVAL" => &mut maxval,
            "TUPLTYPE" => {
                let kind = word(source, left)?;
                if kind.ends_with("_ALPHA") {
                    return Err("the picture has an opacity, which has no meaning for light".to_owned());
                }
                continue;
            }
            _ => return Err(format!("the PAM's header has the line {key:?}, which is not known")),
        };
        if place.replace(number(&word(source, left)?, &key)?).is_some() {
            return Err(format!("the PAM's header gives {key} twice"));
        }
    }
    let (Some(width), Some(height), Some(depth), Some(maxval)) = (width, height, depth, maxval) else {
        return Err("the PAM's header must give WIDTH, HEIGHT, DEPTH and MAXVAL".to_owned());
    };
    if ![1, 3].contains(&depth) {
        return Err(format!("the PAM has {depth} samples a pixel, and must have 1 (grey) or 3 (red, green, blue)"));
    }
    let maxval = checked_maxval(maxval)?;
    Ok(PnmHeader { width, height, channels: depth, maxval, encoding: PnmEncoding::Binary })
}

/// Reads the samples of a row.
fn row(source: &mut impl BufRead, header: &PnmHeader, bytes: &mut [u8], samples: &mut [u16]) -> Result<(), String> {
    match header.encoding {
        PnmEncoding::Text => {
            for sample in samples {
                *sample = text_sample(source)?;
            }
            return Ok(());
        }
        PnmEncoding::TextBits => {
            for sample in samples {
                *sample = text_bit(source)?;
            }
            return Ok(());
        }
        PnmEncoding::Bits | PnmEncoding::Binary => {}
    }
    io::Read::read_exact(source, bytes).map_err(|error| format!("the PNM cannot be read: {error}"))?;
    if header.encoding == PnmEncoding::Bits {
        for (i, sample) in samples.iter_mut().enumerate() {
            *sample = u16::from(bytes[i / 8] >> (7 - i % 8) & 1 == 0);
        }
    } else if header.maxval > 255 {
        for (sample, pair) in samples.iter_mut().zip(bytes.as_chunks::<2>().0) {
            *sample = u16::from_be_bytes(*pair);
        }
    } else {
        for (sample, byte) in samples.iter_mut().zip(bytes) {
            *sample = u16::from(*byte);
        }
    }
    Ok(())
}

const TOO_FEW: &str = "the PNM ends before its last pixel";

/// The next decimal number of a text.
fn text_sample(source: &mut impl BufRead) -> Result<u16, String> {
    let mut value: Option<u32> = None;
    loop {
        match (byte(source)?, value) {
            (Some(digit @ b'0'..=b'9'), before) => {
                let next = 10 * before.unwrap_or(0) + u32::from(digit - b'0');
                if next > MAX_MAXVAL as u32 {
                    return Err(format!("a sample of the PNM is {next} or more, and must be within 0 .. {MAX_MAXVAL}"));
                }
                value = Some(next);
            }
            (Some(blank), None) if is_blank(blank) => {}
            (Some(blank), Some(value)) if is_blank(blank) => return Ok(value as u16),
            (Some(other), _) => return Err(format!("the PNM holds the byte 0x{other:02x} among its numbers")),
            (None, Some(value)) => return Ok(value as u16),
            (None, None) => return Err(TOO_FEW.to_owned()),
        }
    }
}

/// The next bit of a text, as a sample that is 1 where it is bright.
fn text_bit(source: &mut impl BufRead) -> Result<u16, String> {
    loop {
        match byte(source)? {
            Some(b'0') => return Ok(1),
            Some(b'1') => return Ok(0),
            Some(blank) if is_blank(blank) => {}
            Some(other) => return Err(format!("the PNM holds the byte 0x{other:02x} among its bits")),
            None => return Err(TOO_FEW.to_owned()),
        }
    }
}
