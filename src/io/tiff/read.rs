//! TIFF files to linear light.

use super::directory::TiffFile;
use super::layout::{TiffLayout, only_one};
use crate::error::Error;
use crate::io::curve_source::CurveSource;
use crate::io::inputs::unreadable;
use crate::io::memory::{check_length, check_memory, length};
use crate::io::metadata::Metadata;
use crate::raster::Raster;
use crate::raster::transfer::luminance;
use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::path::Path;

/// The picture as linear light. A TIFF names no curve in a way that all programs keep, so the caller must. A pixel that is not
/// opaque has no light of its own.
pub(in crate::io) fn read_from(
    path: &Path,
    mut source: impl Read + Seek,
    curve: CurveSource,
) -> Result<(Raster<f32>, Metadata), Error> {
    let (transfer, transfer_source) = curve.of_silent(path, "TIFF")?;
    // Read the header, and check memory and length.
    let bytes = length(&mut source).map_err(|error| unreadable(path, &error))?;
    let (mut file, first) = TiffFile::open(path, source, bytes)?;
    let directory = file.directory(first)?;
    let layout = TiffLayout::of(&mut file, &directory)?;
    only_one(&mut file, &directory)?;
    let size = (layout.width, layout.height);
    check_memory(path, size, held_bytes(&layout))?;
    let plain = (layout.width * layout.height) as u64 * (layout.samples * layout.sample_bytes) as u64;
    check_length(path, size, bytes, plain.div_ceil(layout.packing.most_expansion()))?;

    // Take the light of each strip or tile by a table of all values.
    let top = if layout.sample_bytes == 1 { 255 } else { 65_535 };
    let table: Vec<f64> = (0..=top).map(|v| transfer.decode(f64::from(v) / f64::from(top))).collect();
    let mut picture = Raster::filled(layout.width, layout.height, 0.0f32);
    let chunks = layout.places.len() / layout.planes();
    for chunk in 0..chunks {
        let planes = (0..layout.planes()).map(|plane| chunk_samples(&mut file, &layout, plane * chunks + chunk));
        place(path, &layout, chunk, &planes.collect::<Result<Vec<_>, _>>()?, (&table, &mut picture))?;
    }
    let colour = layout.samples >= 3;
    let metadata = Metadata {
        format: "TIFF",
        samples: format!("{} bit {}", 8 * layout.sample_bytes, if colour { "RGB" } else { "grey" }),
        transfer: transfer.name().to_owned(),
        transfer_source: transfer_source.to_owned(),
        from_colour: colour,
        pitch_mm: None,
        texts: BTreeMap::new(),
    };
    Ok((picture, metadata))
}

/// Bytes that are held at a time besides the light: of a strip or tile the packed bytes, the unpacked ones, and its samples,
/// of all planes; and the places of all.
fn held_bytes(layout: &TiffLayout) -> u64 {
    let samples = layout.chunk[0] as u64 * layout.chunk[1] as u64 * layout.samples as u64;
    let unpacked = samples.saturating_mul(layout.sample_bytes as u64);
    let packed = layout.packing.most_packed(usize::try_from(unpacked).unwrap_or(usize::MAX)) as u64;
    packed.saturating_add(unpacked).saturating_add(2 * samples + 16 * layout.places.len() as u64)
}

/// The samples of one strip or tile of one plane.
fn chunk_samples<S: Read + Seek>(
    file: &mut TiffFile<'_, S>,
    layout: &TiffLayout,
    at: usize,
) -> Result<Vec<u16>, Error> {
    let (offset, length) = layout.places[at];
    let chunk_row = at % (layout.places.len() / layout.planes()) / layout.across();
    let below = layout.height - chunk_row * layout.chunk[1];
    let rows = if layout.tiled { layout.chunk[1] } else { layout.chunk[1].min(below) };
    let unpacked = rows * layout.row_bytes();
    let most = layout.packing.most_packed(unpacked);
    let packed = file.at(offset, usize::try_from(length).unwrap_or(usize::MAX).min(most))?;
    let bytes = layout.packing.unpack(packed, unpacked).map_err(|rule| file.damaged(rule))?;
    Ok(samples(layout, &bytes, file.big_endian))
}

/// The samples of unpacked bytes; `big_endian` is the order of the file.
fn samples(layout: &TiffLayout, bytes: &[u8], big_endian: bool) -> Vec<u16> {
    let mut samples: Vec<u16> = match layout.sample_bytes {
        1 => bytes.iter().map(|&byte| u16::from(byte)).collect(),
        _ => {
            let of = if big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
            bytes.as_chunks::<2>().0.iter().map(|&pair| of(pair)).collect()
        }
    };
    if layout.differences {
        let together = layout.together();
        let mask = if layout.sample_bytes == 1 { 0xff } else { 0xffff };
        for row in samples.chunks_mut(layout.chunk[0] * together) {
            for k in together..row.len() {
                row[k] = row[k].wrapping_add(row[k - together]) & mask;
            }
        }
    }
    samples
}

/// Puts the light of a strip or tile into the picture, by the table of the curve.
fn place(
    path: &Path,
    layout: &TiffLayout,
    chunk: usize,
    planes: &[Vec<u16>],
    (light, picture): (&[f64], &mut Raster<f32>),
) -> Result<(), Error> {
    let [columns, rows] = layout.chunk;
    let [left, above] = [chunk % layout.across() * columns, chunk / layout.across() * rows];
    let together = layout.together();
    let top = light.len() - 1;
    let colours = layout.samples - usize::from(layout.has_opacity);
    for j in above..layout.height.min(above + rows) {
        for i in left..layout.width.min(left + columns) {
            let pixel = (j - above) * columns + i - left;
            let sample =
                |k: usize| usize::from(if layout.planar { planes[k][pixel] } else { planes[0][pixel * together + k] });
            if layout.has_opacity && sample(colours) != top {
                let rule = format!("pixel ({i}, {j}) is transparent, so its light is not known");
                return Err(Error::new(path.display(), rule, "flatten the picture onto its background first"));
            }
            let value = |k: usize| light[if layout.white_is_zero { top - sample(k) } else { sample(k) }];
            let grey = if colours == 1 { value(0) } else { luminance(value(0), value(1), value(2)) };
            picture.data_mut()[j * layout.width + i] = grey as f32;
        }
    }
    Ok(())
}
