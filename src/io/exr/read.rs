//! EXR files to linear light, and to the channels that they hold.

use super::channel::{Channel, ChannelSamples};
use crate::error::Error;
use crate::io::curve_source::CurveSource;
use crate::io::inputs::unreadable;
use crate::io::memory::{MOST_EXPANSION, check_length, check_memory, length};
use crate::io::metadata::{Metadata, checked_size};
use crate::io::open::open;
use crate::raster::transfer::{Transfer, luminance};
use crate::raster::{MAX_PIXELS, Raster};
use ::exr::block::UncompressedBlock;
use ::exr::block::lines::LineRef;
use ::exr::block::reader::{ChunksReader, Reader};
use ::exr::error::Error as ExrError;
use ::exr::meta::header::Header;
use ::exr::prelude::{AttributeValue, Compression, IntegerBounds, SampleType, Vec2, f16};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek};
use std::path::Path;

/// Reads an EXR as linear light: the channel Y, or else the luminance of R, G and B. Whatever the file's primaries,
/// the weights are those of Rec. 709, which EXR supposes where nothing is said; grey is grey under any weights.
///
/// # Errors
/// Those of [`crate::io::picture_file::read`], and channels of other names only, which are then named.
pub fn read(path: &Path) -> Result<(Raster<f32>, Metadata), Error> {
    read_from(path, open(path)?, CurveSource::File)
}

/// Reads the channels of the given names, in that order, from the first part that has them all. f16 values become
/// f32.
///
/// # Errors
/// Those of [`read`], except that any value is allowed.
pub fn read_channels(path: &Path, names: &[&str]) -> Result<Vec<Channel>, Error> {
    let reader = checked(path, open(path)?)?;
    match part_with(reader.headers(), names) {
        Some(part) => planes(path, reader, part, names),
        None => Err(missing(path, reader.headers(), &names.join(", "))),
    }
}

/// The same as [`read`] from an open file; `path` only names it.
pub(in crate::io) fn read_from(
    path: &Path,
    source: impl Read + Seek,
    curve: CurveSource,
) -> Result<(Raster<f32>, Metadata), Error> {
    if curve.stated() == Some(Transfer::Srgb) {
        let rule = "the transfer curve is stated as sRGB, and OpenEXR holds linear light";
        return Err(Error::new(path.display(), rule, "leave the transfer curve out, or state linear"));
    }
    let reader = checked(path, source)?;
    let headers = reader.headers();
    let choice = [&["Y"][..], &["R", "G", "B"]].into_iter().find_map(|names| Some((part_with(headers, names)?, names)));
    let Some((part, names)) = choice else { return Err(missing(path, headers, "Y, or R, G and B")) };
    let metadata = describe(&headers[part], names);
    let channels = planes(path, reader, part, names)?;
    let values: Vec<Raster<f32>> =
        channels.into_iter().map(|channel| finite(path, channel)).collect::<Result<_, _>>()?;
    let picture = match <[Raster<f32>; 3]>::try_from(values) {
        Ok([red, green, blue]) => grey(&red, &green, &blue),
        Err(mut single) => single.remove(0),
    };
    Ok((picture, metadata))
}

fn grey(red: &Raster<f32>, green: &Raster<f32>, blue: &Raster<f32>) -> Raster<f32> {
    let colours = red.data().iter().zip(green.data()).zip(blue.data());
    let data = colours.map(|((&r, &g), &b)| luminance(r.into(), g.into(), b.into()) as f32).collect();
    Raster::from_data(red.width(), red.height(), data)
}

/// The values as f32, each of which must be a number.
fn finite(path: &Path, channel: Channel) -> Result<Raster<f32>, Error> {
    let values = match channel.samples {
        ChannelSamples::F32(values) => values,
        ChannelSamples::U32(values) => values.map(|value| value as f32),
    };
    match values.data().iter().position(|value| !value.is_finite()) {
        None => Ok(values),
        Some(index) => {
            let (i, j) = (index % values.width(), index / values.width());
            let rule =
                format!("channel {} is {} at pixel ({i}, {j}), and must be finite", channel.name, values.get(i, j));
            Err(Error::new(path.display(), rule, "export the picture without infinite or missing values"))
        }
    }
}

fn describe(header: &Header, names: &[&str]) -> Metadata {
    let kind = |name: &&str| header.channels.list.iter().find(|channel| channel.name == **name).map(|c| c.sample_type);
    let kinds: Vec<_> = names.iter().filter_map(kind).map(kind_name).collect();
    let attributes = &header.own_attributes;
    let mut texts: BTreeMap<String, String> = attributes
        .other
        .iter()
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => Some((name.to_string(), text.to_string())),
            _ => None,
        })
        .collect();
    let typed = [("Software", &attributes.software_name), ("Comment", &attributes.comments)];
    texts.extend(typed.into_iter().filter_map(|(name, text)| Some((name.to_owned(), text.as_ref()?.to_string()))));
    let same = kinds.windows(2).all(|pair| pair[0] == pair[1]);
    Metadata {
        format: "EXR",
        samples: format!("{} {}", if same { kinds[0].to_owned() } else { kinds.join(", ") }, names.join(", ")),
        transfer: Transfer::Linear.name().to_owned(),
        transfer_source: "OpenEXR is linear".to_owned(),
        from_colour: names.len() > 1,
        pitch_mm: attributes
            .horizontal_density
            .filter(|density| *density > 0.0)
            .map(|density| 25.4 / f64::from(density)),
        texts,
    }
}

fn kind_name(kind: SampleType) -> &'static str {
    match kind {
        SampleType::F16 => "f16",
        SampleType::F32 => "f32",
        SampleType::U32 => "u32",
    }
}

/// The first part that holds all the named channels.
fn part_with(headers: &[Header], names: &[&str]) -> Option<usize> {
    headers.iter().position(|header| names.iter().all(|name| header.channels.list.iter().any(|c| c.name == **name)))
}

fn missing(path: &Path, headers: &[Header], wanted: &str) -> Error {
    let found: Vec<String> =
        headers.iter().flat_map(|header| header.channels.list.iter().map(|channel| channel.name.to_string())).collect();
    let rule = format!("no part of the file has the channels {wanted}; it has {}", found.join(", "));
    Error::new(path.display(), rule, "export the picture with a channel Y, or with R, G and B")
}

fn damaged(path: &Path, error: &ExrError) -> Error {
    match error {
        ExrError::NotSupported(what) => Error::new(
            path.display(),
            format!("the EXR uses what is not supported here: {what}"),
            "export it as flat scan lines with ZIP compression",
        ),
        other => {
            Error::new(path.display(), format!("the EXR is damaged: {other}"), "copy the file again, or export it anew")
        }
    }
}

/// The file with its header read and every size in it checked, before memory is taken for any.
fn checked<R: Read + Seek>(path: &Path, mut source: R) -> Result<Reader<R>, Error> {
    let bytes = length(&mut source).map_err(|error| unreadable(path, &error))?;
    let reader = Reader::read_from_buffered(source, false).map_err(|error| damaged(path, &error))?;
    let refuse = |rule: String| {
        Err(Error::new(path.display(), rule, "export it as flat scan lines with ZIP compression, one picture a file"))
    };
    let mut chunks: u64 = 0;
    for header in reader.headers() {
        checked_size(path, header.layer_size.width(), header.layer_size.height())?;
        // Each chunk has an offset of eight bytes in the file.
        chunks = chunks.saturating_add(header.chunk_count as u64);
        if chunks.saturating_mul(8) > bytes {
            return refuse(format!("the EXR is damaged: its header tells of {chunks} blocks in {bytes} bytes"));
        }
        let Vec2(width, height) = header.max_block_pixel_size();
        let values = width.saturating_mul(height).saturating_mul(header.channels.list.len());
        if values > MAX_PIXELS {
            return refuse(format!("a block of the EXR holds {values} values, and may hold {MAX_PIXELS}"));
        }
        if header.channels.list.iter().all(|channel| channel.sampling == Vec2(1, 1)) && !header.deep {
            let size = header.layer_size;
            let pixel: u64 = header.channels.list.iter().map(|channel| sample_bytes(channel.sample_type)).sum();
            let packed = size.area() as u64 * pixel;
            // PXR24 takes three bytes for four before it deflates them.
            let least = match header.compression {
                Compression::Uncompressed => packed,
                _ => packed / (2 * MOST_EXPANSION),
            };
            check_length(path, (size.width(), size.height()), bytes, least)?;
        }
    }
    Ok(reader)
}

fn sample_bytes(kind: SampleType) -> u64 {
    if kind == SampleType::F16 { 2 } else { 4 }
}

/// Refuses a part whose named channels, the light made of several, and a block packed, unpacked and set in order take more
/// memory than a picture may.
fn affordable(path: &Path, header: &Header, wanted: usize) -> Result<(), Error> {
    let size = header.layer_size;
    let others = if wanted > 1 { 4 * wanted as u64 * size.area() as u64 } else { 0 };
    let block: u64 = header.channels.list.iter().map(|channel| sample_bytes(channel.sample_type)).sum::<u64>()
        * header.max_block_pixel_size().area() as u64;
    check_memory(path, (size.width(), size.height()), others.saturating_add(3 * block))
}

/// Reads the named channels of one part.
fn planes(path: &Path, reader: Reader<impl Read + Seek>, part: usize, names: &[&str]) -> Result<Vec<Channel>, Error> {
    let header = reader.headers()[part].clone();
    suits(path, &header, names.len())?;
    affordable(path, &header, names.len())?;
    let Vec2(width, height) = header.layer_size;
    // The channel's index in the file, with its plane.
    let mut planes: Vec<(usize, Channel)> = names
        .iter()
        .filter_map(|name| {
            let index = header.channels.list.iter().position(|channel| channel.name == **name)?;
            let channel = match header.channels.list[index].sample_type {
                SampleType::U32 => Channel::u32(*name, Raster::filled(width, height, 0)),
                SampleType::F16 | SampleType::F32 => Channel::f32(*name, Raster::filled(width, height, 0.0)),
            };
            Some((index, channel))
        })
        .collect();
    let mut done = BTreeSet::new();
    let largest = Vec2(0, 0);
    reader
        .filter_chunks(true, |_, _, block| block.layer == part && block.level == largest)
        .and_then(|chunks| {
            chunks.decompress_sequential(false, |meta, block: UncompressedBlock| {
                let index = block.index;
                // Every block once and nothing else: then the picture is complete.
                if index.layer != part
                    || index.level != largest
                    || !done.insert((index.pixel_position.x(), index.pixel_position.y()))
                {
                    return Err(ExrError::Invalid("a block is missing, and another one is there twice".into()));
                }
                for line in block.lines(&meta.headers[part].channels) {
                    let kind = meta.headers[part].channels.list[line.location.channel].sample_type;
                    for (_, channel) in planes.iter_mut().filter(|(index, _)| *index == line.location.channel) {
                        copy(line, kind, channel)?;
                    }
                }
                Ok(())
            })
        })
        .map_err(|error| damaged(path, &error))?;
    Ok(planes.into_iter().map(|(_, channel)| channel).collect())
}

/// Whether a part's channels can be taken as pictures of the whole view.
fn suits(path: &Path, header: &Header, wanted: usize) -> Result<(), Error> {
    let refuse = |rule: String, help: &str| Err(Error::new(path.display(), rule, help));
    if let Some(channel) = header.channels.list.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
        let rule = format!("the channel {} has fewer values than the picture has pixels", channel.name);
        return refuse(rule, "export all channels at full resolution");
    }
    let (data, view) = (header.data_window(), header.shared_attributes.display_window);
    if data != view {
        let text = |window: IntegerBounds| {
            let (size, at) = (window.size, window.position);
            format!("{} x {} px at ({}, {})", size.x(), size.y(), at.x(), at.y())
        };
        let rule = format!("the file holds {} of a view of {}, so positions would shift", text(data), text(view));
        return refuse(rule, "export the whole view");
    }
    let values = header.layer_size.area().saturating_mul(wanted);
    if values > MAX_PIXELS {
        let rule = format!("the channels to read hold {values} values, and may hold {MAX_PIXELS}");
        return refuse(rule, "use a smaller picture");
    }
    Ok(())
}

/// One line of a block into its plane.
fn copy(line: LineRef<'_>, kind: SampleType, channel: &mut Channel) -> Result<(), ExrError> {
    let Vec2(first, row) = line.location.position;
    let place = |width: usize| row * width + first..row * width + first + line.location.sample_count;
    match &mut channel.samples {
        ChannelSamples::U32(plane) => {
            let place = place(plane.width());
            line.read_samples_into_slice(&mut plane.data_mut()[place])
        }
        ChannelSamples::F32(plane) => {
            let place = place(plane.width());
            let values = &mut plane.data_mut()[place];
            if kind == SampleType::F32 {
                return line.read_samples_into_slice(values);
            }
            for (value, half) in values.iter_mut().zip(line.read_samples::<f16>()) {
                *value = half?.to_f32();
            }
            Ok(())
        }
    }
}
