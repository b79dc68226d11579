//! How the samples of a TIFF picture lie in its file, with every limit checked.

use super::directory::{Directory, MOST_SAMPLES, TiffFile};
use super::tags::{self, Tag};
use super::unpack::Packing;
use crate::error::Error;
use crate::io::metadata::checked_size;
use std::io::{Read, Seek};

/// Strips or tiles of a picture, at most: a picture of 16384 x 16384 px in tiles of 16 x 16.
const MOST_CHUNKS: u64 = 1 << 20;

/// Directories that are looked into, at most: the picture and smaller copies of it.
const MOST_DIRECTORIES: usize = 16;

/// The layout of one picture.
pub(super) struct TiffLayout {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Samples of a pixel, with its opacity.
    pub(super) samples: usize,
    pub(super) has_opacity: bool,
    /// Bytes of a sample, 1 or 2.
    pub(super) sample_bytes: usize,
    /// Whether 0 is the brightest.
    pub(super) white_is_zero: bool,
    /// Whether the file has a picture of each sample instead of all samples of a pixel together.
    pub(super) planar: bool,
    pub(super) packing: Packing,
    /// Whether a sample is written as its difference from that of the pixel before.
    pub(super) differences: bool,
    /// Whether it lies in tiles, all of one size, and not in strips, of which the last ends with the picture.
    pub(super) tiled: bool,
    /// Columns and rows of a strip or tile.
    pub(super) chunk: [usize; 2],
    /// Place and length of each strip or tile in the file, row by row, plane after plane.
    pub(super) places: Vec<(u64, u64)>,
}

impl TiffLayout {
    /// Strips or tiles side by side.
    pub(super) fn across(&self) -> usize {
        self.width.div_ceil(self.chunk[0])
    }

    /// Samples of a pixel that stand together.
    pub(super) fn together(&self) -> usize {
        if self.planar { 1 } else { self.samples }
    }

    /// Pictures of one sample each, or one of all.
    pub(super) fn planes(&self) -> usize {
        if self.planar { self.samples } else { 1 }
    }

    /// Bytes of a row of a strip or tile.
    pub(super) fn row_bytes(&self) -> usize {
        self.chunk[0] * self.together() * self.sample_bytes
    }

    /// Reads the layout of the picture in `directory`.
    ///
    /// # Errors
    /// What is no picture of 8 or 16 bits in grey or RGB, sizes outside the limits, and tags that contradict one another.
    pub(super) fn of<S: Read + Seek>(file: &mut TiffFile<'_, S>, directory: &Directory) -> Result<Self, Error> {
        // Take the size and the kind of the samples.
        let mut size = [0; 2];
        for (size, tag) in size.iter_mut().zip([tags::WIDTH, tags::HEIGHT]) {
            let Some(numbers) = file.numbers(directory, tag, 1)? else { return Err(missing(file, tag)) };
            *size = usize::try_from(numbers[0]).unwrap_or(usize::MAX);
        }
        let (width, height) = checked_size(file.path, size[0], size[1])?;
        let (samples, has_opacity, white_is_zero) = colours(file, directory)?;
        let sample_bytes = sample_bytes(file, directory)?;

        // Take how they are packed.
        let packing = packing(file, directory)?;
        let differences = choice(file, directory, tags::PREDICTOR, [1, 2])? == 2;
        let planar = choice(file, directory, tags::PLANAR, [1, 2])? == 2 && samples > 1;
        choice(file, directory, tags::FILL_ORDER, [1, 1])?;
        if file.one(directory, tags::ORIENTATION, 1)? != 1 {
            let rule = "the file says that the picture is to be turned or mirrored when it is shown".to_owned();
            return Err(file.refused(rule, "export it upright, with Orientation 1"));
        }

        // Find the strips or tiles.
        let (chunk, offsets, lengths) = chunks(file, directory)?;
        let mut layout = Self {
            width,
            height,
            samples,
            has_opacity,
            sample_bytes,
            white_is_zero,
            planar,
            packing,
            differences,
            tiled: chunk.is_some(),
            chunk: chunk.unwrap_or([width, 0]),
            places: Vec::new(),
        };
        if chunk.is_none() {
            let rows = file.one(directory, tags::STRIP_ROWS, u64::from(u32::MAX))?;
            layout.chunk[1] = usize::try_from(rows).unwrap_or(usize::MAX).min(height);
        }
        if layout.chunk.contains(&0) {
            return Err(file.damaged("its strips or tiles have no pixel".to_owned()));
        }
        let count = layout.across() as u64 * height.div_ceil(layout.chunk[1]) as u64 * layout.planes() as u64;
        if count > MOST_CHUNKS {
            let rule = format!("the picture is cut into {count} strips or tiles, and may be into {MOST_CHUNKS}");
            return Err(file.refused(rule, "export it in larger tiles"));
        }
        let mut list = |tag: Tag| match file.numbers(directory, tag, count as usize)? {
            Some(numbers) if numbers.len() as u64 == count => Ok(numbers),
            Some(numbers) => Err(file.damaged(format!("{tag} has {} numbers, and must have {count}", numbers.len()))),
            None => Err(missing(file, tag)),
        };
        layout.places = list(offsets)?.into_iter().zip(list(lengths)?).collect();
        Ok(layout)
    }
}

fn missing<S: Read + Seek>(file: &TiffFile<'_, S>, tag: Tag) -> Error {
    file.damaged(format!("it has no {tag}"))
}

/// Bytes of a sample, which is a whole number.
fn sample_bytes<S: Read + Seek>(file: &mut TiffFile<'_, S>, directory: &Directory) -> Result<usize, Error> {
    let bits = file.each(directory, tags::BITS, 1)?;
    let format = file.each(directory, tags::SAMPLE_FORMAT, 1)?;
    if format != 1 || ![8, 16].contains(&bits) {
        let kind = match format {
            1 => "whole numbers",
            2 => "signed numbers",
            3 => "floating-point numbers",
            _ => "of no known kind",
        };
        let rule = format!("the samples are {kind} of {bits} bits, and must be whole numbers of 8 or 16 bits");
        return Err(file.refused(rule, "export it with 16 bits, or as OpenEXR"));
    }
    Ok(bits as usize / 8)
}

/// Samples of a pixel, whether one is an opacity, and whether 0 is the brightest.
fn colours<S: Read + Seek>(file: &mut TiffFile<'_, S>, directory: &Directory) -> Result<(usize, bool, bool), Error> {
    let samples = file.one(directory, tags::SAMPLES, 1)?;
    let Some(meaning) = file.numbers(directory, tags::PHOTOMETRIC, 1)? else {
        return Err(missing(file, tags::PHOTOMETRIC));
    };
    let colours = match meaning[0] {
        0 | 1 => 1,
        2 => 3,
        other => {
            let name = match other {
                3 => "colours of a palette",
                4 => "a mask",
                5 => "inks (CMYK)",
                6 => "YCbCr",
                8..=10 => "L*a*b*",
                _ => "of no known meaning",
            };
            let rule = format!("the samples are {name} (PhotometricInterpretation {other}), and must be grey or RGB");
            return Err(file.refused(rule, "export it as grey or RGB with 16 bits"));
        }
    };
    if samples != colours && samples != colours + 1 {
        let rule =
            format!("a pixel has {samples} samples, and must have {colours}, or {} with an opacity", colours + 1);
        return Err(file.refused(rule, "export it as grey or RGB, without other channels"));
    }
    debug_assert!(samples as usize <= MOST_SAMPLES);
    Ok((samples as usize, samples > colours, meaning[0] == 0))
}

fn packing<S: Read + Seek>(file: &mut TiffFile<'_, S>, directory: &Directory) -> Result<Packing, Error> {
    match file.one(directory, tags::COMPRESSION, 1)? {
        1 => Ok(Packing::None),
        5 => Ok(Packing::Lzw),
        8 | 32946 => Ok(Packing::Deflate),
        32773 => Ok(Packing::PackBits),
        other => {
            let rule = format!("the picture is packed by method {other}, and must be plain, LZW, Deflate or PackBits");
            Err(file.refused(rule, "export it with one of these"))
        }
    }
}

/// The number of a tag that must be one of two, of which the first stands for a missing one.
fn choice<S: Read + Seek>(
    file: &mut TiffFile<'_, S>,
    directory: &Directory,
    tag: Tag,
    known: [u64; 2],
) -> Result<u64, Error> {
    let found = file.one(directory, tag, known[0])?;
    if known.contains(&found) {
        return Ok(found);
    }
    let rule = format!("{tag} is {found}, which is not read here");
    Err(file.refused(rule, "export it without compression"))
}

/// Columns and rows of a tile, `None` of strips, and the tags of their places and lengths.
fn chunks<S: Read + Seek>(
    file: &mut TiffFile<'_, S>,
    directory: &Directory,
) -> Result<(Option<[usize; 2]>, Tag, Tag), Error> {
    if !directory.has(tags::TILE_WIDTH) {
        return Ok((None, tags::STRIP_OFFSETS, tags::STRIP_BYTES));
    }
    let mut side = |tag: Tag| Ok::<_, Error>(usize::try_from(file.one(directory, tag, 0)?).unwrap_or(usize::MAX));
    let tile = [side(tags::TILE_WIDTH)?, side(tags::TILE_HEIGHT)?];
    // A tile may be larger than the picture, to the next multiple of 16.
    let most = crate::raster::MAX_SIDE_PX.next_multiple_of(16);
    if tile.iter().any(|side| *side > most) {
        let rule = format!("its tiles are {} x {}, and may be {most} each way", tile[0], tile[1]);
        return Err(file.refused(rule, "export it in smaller tiles"));
    }
    Ok((Some(tile), tags::TILE_OFFSETS, tags::TILE_BYTES))
}

/// Refuses a file with a second picture that is no smaller copy or mask of the first.
///
/// # Errors
/// Such a file, and one that begins with a copy.
pub(super) fn only_one<S: Read + Seek>(file: &mut TiffFile<'_, S>, first: &Directory) -> Result<(), Error> {
    let help = "export the picture that is meant into a file of its own";
    // Bits of NewSubfileType: 1 a smaller copy, 4 a mask.
    let is_aside = |kind: u64| kind & 5 != 0;
    if is_aside(file.one(first, tags::SUBFILE_TYPE, 0)?) {
        return Err(file.refused("the file begins with a smaller copy or a mask of its picture".to_owned(), help));
    }
    let mut next = first.next;
    for _ in 1..MOST_DIRECTORIES {
        if next == 0 {
            return Ok(());
        }
        let directory = file.directory(next)?;
        if !is_aside(file.one(&directory, tags::SUBFILE_TYPE, 0)?) {
            return Err(file.refused("the file holds more than one picture".to_owned(), help));
        }
        next = directory.next;
    }
    Err(file.refused(format!("the file holds more than {MOST_DIRECTORIES} pictures"), help))
}
