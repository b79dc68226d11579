//! Planes to an EXR file: one part, so that every viewer shows all channels; scan lines in order, ZIP16, no loss.

use super::{Channel, Samples};
use crate::problem::Problem;
use crate::raster::safe::write_atomically;
use crate::raster::{KEY, Notes, checked_size};
use ::exr::meta::header::LayerAttributes;
use ::exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    SmallVec, Text, WritableImage,
};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io;
use std::path::Path;

/// Longer names ask for a flag of the format that old readers refuse.
const MAX_NAME_BYTES: usize = 31;

/// Writes the channels, in alphabetical order as the format asks, byte for byte the same on every run.
///
/// # Errors
/// No channel, a name that is empty, too long, not ASCII or given twice, channels of different sizes, a size outside
/// the limits, and those of [`write_atomically`].
pub fn write(path: &Path, channels: Vec<Channel>, notes: &Notes<'_>) -> Result<(), Problem> {
    let size = check(path, &channels)?;
    let planes: SmallVec<_> = channels.into_iter().map(plane).collect();
    let bounds = IntegerBounds::from_dimensions(size);
    let layer = Layer::new(size, attributes(notes), Encoding::SMALL_LOSSLESS, AnyChannels::sort(planes));
    let image = Image::new(ImageAttributes::new(bounds), layer);
    write_atomically(path, |out| {
        image.write().to_buffered(out).map_err(|error| match error {
            ::exr::error::Error::Io(error) => error,
            other => io::Error::other(other.to_string()),
        })
    })
}

fn check(path: &Path, channels: &[Channel]) -> Result<(usize, usize), Problem> {
    let refuse = |rule: String, help: &str| Err(Problem::new(path.display(), rule, help));
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
    checked_size(path, size.0, size.1)
}

fn plane(channel: Channel) -> AnyChannel<FlatSamples> {
    let samples = match channel.samples {
        Samples::F32(plane) => FlatSamples::F32(plane.into_data()),
        Samples::U32(plane) => FlatSamples::U32(plane.into_data()),
    };
    AnyChannel::new(channel.name.as_str(), samples)
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
