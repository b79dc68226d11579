//! Planes to an EXR file: one part, so that every viewer shows all channels; scan lines in order, ZIP16, no loss.

use super::channel::{Channel, ChannelSamples};
use super::zip::{SampleRow, pack};
use crate::error::Error;
use crate::io::atomic::write_atomically;
use crate::io::metadata::{KEY, Notes, checked_size};
use ::exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use ::exr::block::writer::{ChunkWriter, ChunksWriter, write_chunks_with};
use ::exr::error::Error as ExrError;
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::{ChannelDescription, LineOrder, SampleType};
use ::exr::meta::header::{Header, LayerAttributes};
use ::exr::prelude::{AttributeValue, Compression, Text, Vec2};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io;
use std::iter::once;
use std::path::Path;

/// Rows of a block of ZIP16.
pub const BLOCK_ROWS: usize = 16;

/// Longer names need a flag of the format that old readers refuse.
const MAX_NAME_BYTES: usize = 31;

/// Writes the channels, in alphabetical order as the format demands, byte for byte the same on every run.
///
/// # Errors
/// No channel, a name that is empty, too long, not ASCII or given twice, channels of different sizes, a size outside
/// the limits, and those of [`write_atomically`].
pub fn write(path: &Path, channels: Vec<Channel>, notes: &Notes<'_>) -> Result<(), Error> {
    let height = channels.first().map_or(0, |channel| channel.samples.size().1);
    write_strips(path, height, once(channels), notes)
}

/// The same of a picture of `height` rows that comes in strips, one below the other, each of the same channels; it is
/// never held as a whole. All strips but the last have a multiple of [`BLOCK_ROWS`] rows.
///
/// # Errors
/// Those of [`write()`], and strips that are not the whole picture, or of other channels than the first.
pub fn write_strips(
    path: &Path,
    height: usize,
    mut strips: impl Iterator<Item = Vec<Channel>>,
    notes: &Notes<'_>,
) -> Result<(), Error> {
    let first = sorted(strips.next().unwrap_or_default());
    let (width, _) = check(path, &first)?;
    let size = checked_size(path, width, height)?;
    let kinds = first.iter().map(|c| ChannelDescription::named(c.name.as_str(), kind(&c.samples))).collect();
    let header = Header::new(Text::default(), size, kinds)
        .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(attributes(notes));
    write_atomically(path, |out| {
        let strips = once(first).chain(strips.map(sorted));
        write_chunks_with(out, once(header).collect(), true, |meta, chunks| blocks(&meta.headers, chunks, strips))
            .map_err(|error| match error {
                ExrError::Io(error) => error,
                other => io::Error::other(other.to_string()),
            })
    })
}

/// Packs the strips in blocks of the format, by several threads, and writes these in order.
fn blocks<W: io::Write + io::Seek>(
    headers: &[Header],
    chunks: &mut ChunkWriter<W>,
    strips: impl Iterator<Item = Vec<Channel>>,
) -> Result<(), ExrError> {
    let header = &headers[0];
    let Vec2(width, height) = header.layer_size;
    let mut row = 0;
    for strip in strips {
        let rows = strip.first().map_or(0, |channel| channel.samples.size().1);
        let same = header.channels.list.len() == strip.len()
            && header.channels.list.iter().zip(&strip).all(|(known, channel)| {
                known.name == *channel.name.as_str()
                    && known.sample_type == kind(&channel.samples)
                    && channel.samples.size() == (width, rows)
            });
        let fits = row % BLOCK_ROWS == 0 && row + rows <= height;
        if !(same && fits) {
            return Err(ExrError::Invalid("a strip does not fit into the picture".into()));
        }
        let block = |first: usize| {
            let rows = first..rows.min(first + BLOCK_ROWS);
            let lines = rows.flat_map(|row| strip.iter().map(move |channel| row_of(&channel.samples, row)));
            pack(&lines.collect::<Vec<_>>())
        };
        let packed: Vec<_> = (0..rows).into_par_iter().step_by(BLOCK_ROWS).map(block).collect();
        for (k, packed) in packed.into_iter().enumerate() {
            let number = row / BLOCK_ROWS + k;
            let lines = CompressedScanLineBlock {
                y_coordinate: (number * BLOCK_ROWS) as i32,
                compressed_pixels_le: packed.map_err(ExrError::Io)?,
            };
            chunks.write_chunk(number, Chunk { layer_index: 0, compressed_block: CompressedBlock::ScanLine(lines) })?;
        }
        row += rows;
    }
    if row < height {
        return Err(ExrError::Invalid("the strips end before the picture".into()));
    }
    Ok(())
}

fn sorted(mut channels: Vec<Channel>) -> Vec<Channel> {
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    channels
}

/// A row of a channel.
fn row_of(samples: &ChannelSamples, row: usize) -> SampleRow<'_> {
    match samples {
        ChannelSamples::F32(plane) => SampleRow::F32(plane.row(row)),
        ChannelSamples::U32(plane) => SampleRow::U32(plane.row(row)),
    }
}

fn kind(samples: &ChannelSamples) -> SampleType {
    match samples {
        ChannelSamples::F32(_) => SampleType::F32,
        ChannelSamples::U32(_) => SampleType::U32,
    }
}

fn check(path: &Path, channels: &[Channel]) -> Result<(usize, usize), Error> {
    let refuse = |rule: String, help: &str| Err(Error::new(path.display(), rule, help));
    let Some(first) = channels.first() else {
        return refuse("there is no channel to write".to_owned(), "give at least the channel Y");
    };
    let size = first.samples.size();
    let mut names = BTreeSet::new();
    for Channel { name, samples } in channels {
        if name.is_empty() || name.len() > MAX_NAME_BYTES || !name.bytes().all(|byte| byte.is_ascii_graphic()) {
            let rule = format!("the channel name {name:?} must be 1 to {MAX_NAME_BYTES} visible ASCII characters");
            return refuse(rule, "choose another name");
        }
        if !names.insert(name) {
            return refuse(format!("the channel {name} is given twice"), "give each channel a name of its own");
        }
        if samples.size() != size {
            let rule = format!("the channel {name} is {:?} px, and the first is {size:?} px", samples.size());
            return refuse(rule, "give all channels one size");
        }
    }
    Ok(size)
}

/// The typed attributes come in a fixed order; the custom ones sit in a hash map, so there is at most one of them.
fn attributes(notes: &Notes<'_>) -> LayerAttributes {
    let mut attributes = LayerAttributes {
        software_name: Some(Text::from(KEY)),
        horizontal_density: notes.pitch_mm.map(|pitch| (25.4 / pitch) as f32),
        ..LayerAttributes::default()
    };
    if !notes.json.is_empty() {
        let text = Text::from(ascii_json(notes.json).as_str());
        attributes.other.insert(Text::from(KEY), AttributeValue::Text(text));
    }
    attributes
}

/// The same JSON in ASCII, which is all that EXR's text may hold.
fn ascii_json(json: &str) -> String {
    let mut ascii = String::with_capacity(json.len());
    for character in json.chars() {
        if character.is_ascii() {
            ascii.push(character);
        } else {
            for unit in character.encode_utf16(&mut [0; 2]) {
                write!(ascii, "\\u{unit:04x}").expect("a String takes any text");
            }
        }
    }
    ascii
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Raster;

    /// Large enough for many blocks, which are packed by several threads.
    fn channels() -> Vec<Channel> {
        let (width, height) = (300, 200);
        let values = Raster::from_data(width, height, (0..60_000u32).map(|k| (k * k) as f32 / 7.0).collect());
        vec![
            Channel::f32("Y", values.clone()),
            Channel::u32("class", values.map(|value| value as u32 % 5)),
            Channel::f32("board.U", values),
        ]
    }

    #[test]
    fn the_same_bytes_on_every_run_and_for_any_order_of_channels() {
        let directory = tempfile::tempdir().unwrap();
        let notes = Notes { json: "{\"a\":\"µ\"}", pitch_mm: Some(0.0055) };
        let bytes = |name: &str, channels| {
            let path = directory.path().join(name);
            write(&path, channels, &notes).unwrap();
            std::fs::read(path).unwrap()
        };
        let first = bytes("1.exr", channels());
        for _ in 0..20 {
            assert_eq!(first, bytes("2.exr", channels()));
        }
        assert_eq!(first, bytes("2.exr", channels().into_iter().rev().collect()));
    }

    /// Strips of whole blocks give the bytes of the whole; others are refused.
    #[test]
    fn strips_make_the_picture() {
        let directory = tempfile::tempdir().unwrap();
        let notes = Notes::default();
        let whole = directory.path().join("whole.exr");
        write(&whole, channels(), &notes).unwrap();
        let part = |first: usize, last: usize| {
            channels().into_iter().map(move |channel| {
                let cut = |width: usize| first * width..last * width;
                let (width, _) = channel.samples.size();
                match channel.samples {
                    ChannelSamples::F32(p) => {
                        let data = p.data()[cut(width)].to_vec();
                        Channel::f32(channel.name, Raster::from_data(width, last - first, data))
                    }
                    ChannelSamples::U32(p) => {
                        let data = p.data()[cut(width)].to_vec();
                        Channel::u32(channel.name, Raster::from_data(width, last - first, data))
                    }
                }
            })
        };
        let by = |name: &str, cuts: &[usize]| {
            let path = directory.path().join(name);
            let strips = cuts.windows(2).map(|pair| part(pair[0], pair[1]).collect());
            write_strips(&path, 200, strips, &notes)?;
            Ok::<_, Error>(std::fs::read(path).unwrap())
        };
        assert_eq!(by("strips.exr", &[0, 16, 64, 160, 200]).unwrap(), std::fs::read(whole).unwrap());
        for cuts in [&[0, 160][..], &[0, 24, 200], &[0, 160, 200, 200], &[0]] {
            by("wrong.exr", cuts).unwrap_err();
        }
        let other = |k: usize| part(0, 96 + k).filter(move |c| k == 0 || c.name != "Y").collect();
        write_strips(&directory.path().join("wrong.exr"), 200, [0, 8].map(other).into_iter(), &notes).unwrap_err();
        assert!(!directory.path().join("wrong.exr").exists());
    }

    /// Another program's reader finds every bit: of blocks that packing makes smaller, and of noise, which it does not.
    #[test]
    fn a_reader_that_shares_no_code_finds_every_bit() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.exr");
        let mut state = 1u32;
        let mut noise = || {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            state
        };
        // 37 rows: two blocks and a part of one.
        let random = Raster::from_data(30, 37, (0..30 * 37).map(|_| noise()).collect());
        let smooth = Raster::from_data(30, 37, (0..30 * 37).map(|k| k as f32 * 0.25).collect());
        for channels in
            [vec![Channel::u32("N", random.clone())], vec![Channel::f32("S", smooth), Channel::u32("N", random)]]
        {
            write(&path, channels.clone(), &Notes::default()).unwrap();
            let image = ::exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
            for Channel { name, samples } in &channels {
                let list = &image.layer_data.channel_data.list;
                let found = list.iter().find(|found| found.name == *name.as_str()).unwrap();
                match (samples, &found.sample_data) {
                    (ChannelSamples::F32(wanted), ::exr::prelude::FlatSamples::F32(found)) => {
                        assert_eq!(wanted.data(), found);
                    }
                    (ChannelSamples::U32(wanted), ::exr::prelude::FlatSamples::U32(found)) => {
                        assert_eq!(wanted.data(), found);
                    }
                    (_, other) => panic!("{name}: {other:?}"),
                }
            }
        }
    }

    #[test]
    fn what_the_format_cannot_hold_is_refused() {
        let plane = || Raster::filled(2, 2, 0.0f32);
        let refuse = |channels: Vec<Channel>| {
            let directory = tempfile::tempdir().unwrap();
            write(&directory.path().join("a.exr"), channels, &Notes::default()).unwrap_err().rule
        };
        assert!(refuse(vec![]).contains("no channel"));
        for name in ["", "a b", "µ", &"x".repeat(32)] {
            assert!(refuse(vec![Channel::f32(name, plane())]).contains("channel name"));
        }
        assert!(refuse(vec![Channel::f32("Y", plane()), Channel::f32("Y", plane())]).contains("twice"));
        let other = Channel::u32("class", Raster::filled(2, 3, 0));
        assert!(refuse(vec![Channel::f32("Y", plane()), other]).contains("(2, 3)"));
        assert!(refuse(vec![Channel::f32("Y", Raster::filled(0, 3, 0.0))]).contains("0 x 3"));
    }

    #[test]
    fn json_is_kept_in_ascii() {
        let ascii = ascii_json("{\"µ\":\"𝛼\"}");
        assert!(ascii.is_ascii());
        let value: serde_json::Value = serde_json::from_str(&ascii).unwrap();
        assert_eq!(value["µ"], "𝛼");
    }
}
