//! PNG files of any depth and colour type to linear light.

use crate::error::Error;
use crate::io::curve_source::{AS_STORED, CurveSource, SAY};
use crate::io::inputs::unreadable;
use crate::io::memory::{MOST_EXPANSION, check_length, check_memory, length};
use crate::io::metadata::{Metadata, checked_size};
use crate::io::open::open;
use crate::raster::Raster;
use crate::raster::transfer::{Transfer, luminance};
use ::png::{BitDepth, ColorType, Decoder, DecodingError, Info, Reader, Transformations, Unit};
use std::collections::BTreeMap;
use std::io::{BufRead, Seek};
use std::path::Path;

/// Bytes of one compressed text when it is unpacked, at most.
const ONE_TEXT_BYTES: usize = 2 << 20;
/// Bytes of all texts together, at most.
const TEXT_BYTES: usize = 16 << 20;

/// What to do where the caller and the file disagree.
const AGAINST: &str = "leave --transfer out, or, if the chunk is wrong, say --force-transfer besides";
/// The exponent of a gAMA curve must lie between this and its inverse; real ones are near 2.2.
const MAX_EXPONENT: f64 = 10.0;

/// Reads a PNG as linear light; see [`crate::io::picture_file::read`].
///
/// # Errors
/// Those of [`crate::io::picture_file::read`].
pub fn read(path: &Path, curve: impl Into<CurveSource>) -> Result<(Raster<f32>, Metadata), Error> {
    read_from(path, open(path)?, curve.into())
}

/// The same from an open file; `path` only names it.
pub(in crate::io) fn read_from(
    path: &Path,
    mut source: impl BufRead + Seek,
    curve: CurveSource,
) -> Result<(Raster<f32>, Metadata), Error> {
    let damaged = |error: DecodingError| damaged(path, &error);
    let file_bytes = length(&mut source).map_err(|error| unreadable(path, &error))?;
    let mut decoder = Decoder::new(source);
    // Palettes to colours, 1, 2 and 4 bits to 8, a transparent colour to opacity.
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(damaged)?;
    let (width, height) = checked_size(path, header.width as usize, header.height as usize)?;
    let samples = describe(header);

    let mut reader = decoder.read_info().map_err(damaged)?;
    if reader.info().animation_control.is_some() {
        let rule = "the file is an animation, and must hold one picture";
        return Err(Error::new(path.display(), rule, "export the picture that is meant"));
    }
    // The decoder would take colours that are not there.
    if let Some(palette) = &reader.info().palette
        && (!palette.len().is_multiple_of(3) || palette.len() > 768)
    {
        let rule = format!("the PNG's palette has {} bytes, and a colour has 3, of at most 256 colours", palette.len());
        return Err(Error::new(path.display(), rule, "export the picture anew"));
    }
    let curve = TransferCurve::choose(path, reader.info(), curve)?;
    let (color, _) = reader.output_color_type();
    let data = light(path, &mut reader, (width, height), &curve, file_bytes)?;
    // Reads on to the end, so that a file that breaks off is noticed.
    reader.finish().map_err(damaged)?;
    let texts = texts(path, reader.info())?;
    let metadata = Metadata {
        format: "PNG",
        samples,
        transfer: curve.name,
        transfer_source: curve.source,
        from_colour: matches!(color, ColorType::Rgb | ColorType::Rgba),
        pitch_mm: pitch_mm(reader.info()),
        texts,
    };
    Ok((Raster::from_data(width, height, data), metadata))
}

fn damaged(path: &Path, error: &DecodingError) -> Error {
    match error {
        DecodingError::LimitsExceeded => Error::new(
            path.display(),
            "the file's texts and profiles take more than 64 MiB",
            "export the picture without them",
        ),
        _ => {
            Error::new(path.display(), format!("the PNG is damaged: {error}"), "copy the file again, or export it anew")
        }
    }
}

fn describe(header: &Info<'_>) -> String {
    let colour = match header.color_type {
        ColorType::Grayscale => "grey",
        ColorType::Rgb => "RGB",
        ColorType::Indexed => "palette",
        ColorType::GrayscaleAlpha => "grey with opacity",
        ColorType::Rgba => "RGB with opacity",
    };
    format!("{}-bit {colour}", header.bit_depth as u8)
}

/// The light of all pixels, row by row; of an interlaced picture the samples are held as a whole before.
fn light(
    path: &Path,
    reader: &mut Reader<impl BufRead + Seek>,
    (width, height): (usize, usize),
    curve: &TransferCurve,
    file_bytes: u64,
) -> Result<Vec<f32>, Error> {
    let damaged = |error: DecodingError| damaged(path, &error);
    let too_long = || damaged(DecodingError::LimitsExceeded);
    let (color, depth) = reader.output_color_type();
    let row_bytes = reader.output_line_size(width as u32).ok_or_else(too_long)?;
    let rows = if reader.info().interlaced { height } else { 1 };
    check_memory(path, (width, height), row_bytes as u64 * rows as u64)?;
    let packed = reader.info().raw_row_length() as u64 * height as u64;
    check_length(path, (width, height), file_bytes, packed.div_ceil(MOST_EXPANSION))?;

    let table = curve.table(depth);
    let mut data = Vec::with_capacity(width * height);
    if reader.info().interlaced {
        let mut samples = vec![0; reader.output_buffer_size().ok_or_else(too_long)?];
        reader.next_frame(&mut samples).map_err(damaged)?;
        to_light(path, &samples, (color, depth), &table, width, &mut data)?;
    } else {
        while let Some(row) = reader.next_row().map_err(damaged)? {
            to_light(path, row.data(), (color, depth), &table, width, &mut data)?;
        }
    }
    Ok(data)
}

/// Appends the light of decoded samples, by the table of the curve. A pixel that is not opaque has no light of its own:
/// what lies behind it is unknown.
fn to_light(
    path: &Path,
    samples: &[u8],
    (color, depth): (ColorType, BitDepth),
    light: &[f64],
    width: usize,
    data: &mut Vec<f32>,
) -> Result<(), Error> {
    // Grey without opacity, as most pictures of one channel are.
    match (color, depth) {
        (ColorType::Grayscale, BitDepth::Eight) => {
            data.extend(samples.iter().map(|&sample| light[usize::from(sample)] as f32));
            return Ok(());
        }
        (ColorType::Grayscale, BitDepth::Sixteen) => {
            let samples = samples.as_chunks::<2>().0.iter();
            data.extend(samples.map(|&sample| light[usize::from(u16::from_be_bytes(sample))] as f32));
            return Ok(());
        }
        _ => {}
    }

    let wide = depth == BitDepth::Sixteen;
    let step = if wide { 2 } else { 1 };
    let sample = |pixel: &[u8], k: usize| {
        if wide { usize::from(u16::from_be_bytes([pixel[2 * k], pixel[2 * k + 1]])) } else { usize::from(pixel[k]) }
    };
    let (colours, opacity) = match color {
        ColorType::Grayscale => (1, None),
        ColorType::GrayscaleAlpha => (1, Some(1)),
        ColorType::Rgb => (3, None),
        ColorType::Rgba => (3, Some(3)),
        ColorType::Indexed => unreachable!("palettes are expanded to colours"),
    };
    let pixel_bytes = step * (colours + usize::from(opacity.is_some()));
    let opaque = light.len() - 1;
    for pixel in samples.chunks_exact(pixel_bytes) {
        if opacity.is_some_and(|k| sample(pixel, k) != opaque) {
            let index = data.len();
            let (i, j) = (index % width, index / width);
            let rule = format!("pixel ({i}, {j}) is transparent, so its light is not known");
            return Err(Error::new(path.display(), rule, "flatten the picture onto its background first"));
        }
        let value = |k| light[sample(pixel, k)];
        data.push(if colours == 1 { value(0) } else { luminance(value(0), value(1), value(2)) } as f32);
    }
    Ok(())
}

/// The curve of a file: its exponent or piecewise form, its name, and who says so.
struct TransferCurve {
    form: CurveForm,
    name: String,
    source: String,
}

#[derive(Clone, Copy)]
enum CurveForm {
    Known(Transfer),
    /// Light = value^exponent.
    Power(f64),
}

impl TransferCurve {
    /// The curve that the caller states, or else the one that the file states, in the order of precedence of the PNG
    /// specification (third edition, 4.3): cICP, iCCP, sRGB, gAMA.
    fn choose(path: &Path, info: &Info<'_>, curve: CurveSource) -> Result<Self, Error> {
        let from_file = Self::of_file(info);
        let known = |transfer: Transfer, source: String| {
            Ok(Self { form: CurveForm::Known(transfer), name: transfer.name().to_owned(), source })
        };
        if let Some(transfer) = curve.stated() {
            return match &from_file {
                Ok(Some(file)) if !file.agrees(transfer) => {
                    let Self { name, source, .. } = file;
                    if curve == CurveSource::Stated(transfer) {
                        let rule =
                            format!("the curve is stated as {}, and the file's {source} says {name}", transfer.name());
                        return Err(Error::new(path.display(), rule, AGAINST));
                    }
                    known(transfer, format!("stated by the caller, against the {source}: {name}"))
                }
                _ => known(transfer, "stated by the caller".to_owned()),
            };
        }
        let silent = info.coding_independent_code_points.is_none() && info.icc_profile.is_some();
        if curve == CurveSource::FileOrStored && (silent || matches!(from_file, Ok(None))) {
            return known(Transfer::Linear, AS_STORED.to_owned());
        }
        let rule = match from_file {
            Ok(Some(curve)) => return Ok(curve),
            Ok(None) => "the file does not say how its values stand for light (no sRGB, gAMA or cICP chunk)".to_owned(),
            Err(rule) => rule,
        };
        Err(Error::new(path.display(), rule, SAY))
    }

    /// Whether it is a stated one, as nearly as a gAMA chunk tells sRGB: by 0.45455 (PNG, third edition, 11.3.2.5).
    fn agrees(&self, stated: Transfer) -> bool {
        match self.form {
            CurveForm::Known(transfer) => transfer == stated,
            CurveForm::Power(exponent) => stated == Transfer::Srgb && (exponent - 2.2).abs() < 0.005,
        }
    }

    /// What the file says; nothing, or the rule that keeps it from being understood.
    fn of_file(info: &Info<'_>) -> Result<Option<Self>, String> {
        let known = |transfer: Transfer, source: &str| {
            let name = transfer.name().to_owned();
            Ok(Some(Self { form: CurveForm::Known(transfer), name, source: source.to_owned() }))
        };
        if let Some(cicp) = info.coding_independent_code_points {
            // Rec. ITU-T H.273, table 3.
            return match (cicp.transfer_function, cicp.is_video_full_range_image) {
                (8, true) => known(Transfer::Linear, "cICP chunk"),
                (13, true) => known(Transfer::Srgb, "cICP chunk"),
                (code, true) => Err(format!("its cICP chunk asks for transfer curve {code}, which is not known here")),
                (_, false) => Err("its cICP chunk says that values are of narrow range".to_owned()),
            };
        }
        if info.icc_profile.is_some() {
            return Err("its curve is in an ICC profile, which is not interpreted here".to_owned());
        }
        if info.srgb.is_some() {
            return known(Transfer::Srgb, "sRGB chunk");
        }
        let Some(gamma) = info.gama_chunk else { return Ok(None) };
        if gamma.into_scaled() == 100_000 {
            return known(Transfer::Linear, "gAMA chunk");
        }
        let exponent = 100_000.0 / f64::from(gamma.into_scaled());
        if !(1.0 / MAX_EXPONENT..=MAX_EXPONENT).contains(&exponent) {
            return Err(format!("its gAMA chunk is {}, and must be 0.1 to 10", f64::from(gamma.into_scaled()) / 1e5));
        }
        let name = format!("power {exponent:.4}");
        Ok(Some(Self { form: CurveForm::Power(exponent), name, source: "gAMA chunk".to_owned() }))
    }

    /// The light of every value of `depth`.
    fn table(&self, depth: BitDepth) -> Vec<f64> {
        let top = if depth == BitDepth::Sixteen { 65535 } else { 255 };
        let light = |k| {
            let value = f64::from(k) / f64::from(top);
            match self.form {
                CurveForm::Known(transfer) => transfer.decode(value),
                CurveForm::Power(exponent) => libm::pow(value, exponent),
            }
        };
        (0..=top).map(light).collect()
    }
}

fn pitch_mm(info: &Info<'_>) -> Option<f64> {
    let density = info.pixel_dims?;
    let square = density.unit == Unit::Meter && density.xppu == density.yppu && density.xppu > 0;
    square.then(|| 1000.0 / f64::from(density.xppu))
}

/// The texts, unpacked; one that is damaged or longer than [`ONE_TEXT_BYTES`] is left out.
fn texts(path: &Path, info: &Info<'_>) -> Result<BTreeMap<String, String>, Error> {
    let mut texts = BTreeMap::new();
    let mut left = TEXT_BYTES;
    let mut keep = |keyword: &str, text: Option<String>| {
        // What cannot be unpacked was work all the same.
        let bytes = text.as_ref().map_or(ONE_TEXT_BYTES, String::len);
        left = left.checked_sub(bytes).ok_or_else(|| {
            let rule = format!("the texts of the file have more than {} MiB", TEXT_BYTES >> 20);
            Error::new(path.display(), rule, "export the picture without them")
        })?;
        texts.extend(text.map(|text| (keyword.to_owned(), text)));
        Ok::<(), Error>(())
    };
    for chunk in &info.uncompressed_latin1_text {
        keep(&chunk.keyword, Some(chunk.text.clone()))?;
    }
    for chunk in &info.compressed_latin1_text {
        let mut chunk = chunk.clone();
        let text = chunk.decompress_text_with_limit(ONE_TEXT_BYTES).and_then(|()| chunk.get_text());
        keep(&chunk.keyword, text.ok())?;
    }
    for chunk in &info.utf8_text {
        let mut chunk = chunk.clone();
        let text = chunk.decompress_text_with_limit(ONE_TEXT_BYTES).and_then(|()| chunk.get_text());
        keep(&chunk.keyword, text.ok())?;
    }
    Ok(texts)
}
