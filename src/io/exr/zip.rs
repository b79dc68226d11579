//! ZIP of the EXR format: the bytes of a block, even ones before odd ones, each less the one before, deflated.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::{self, Write};

/// How hard deflate tries, of nine levels: files are an eighth larger than at the second, and packed in half the time.
const EFFORT: u32 = 1;

/// Numbers of a row.
#[derive(Debug, Clone, Copy)]
pub(super) enum SampleRow<'a> {
    /// Floats of 32 bits.
    F32(&'a [f32]),
    /// Unsigned numbers of 32 bits.
    U32(&'a [u32]),
}

impl SampleRow<'_> {
    fn len(self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::U32(values) => values.len(),
        }
    }
}

/// The packed bytes of a block of `lines`, row by row the channels of each; the bytes themselves where packing does not make them
/// fewer, as the format asks (OpenEXR's `ImfZip.cpp`).
///
/// # Errors
/// None that a vector could give.
pub(super) fn pack(lines: &[SampleRow<'_>]) -> io::Result<Vec<u8>> {
    // Part the even bytes from the odd ones.
    let half = 2 * lines.iter().map(|line| line.len()).sum::<usize>();
    let mut parted = vec![0; 2 * half];
    let (mut even, mut odd) = parted.split_at_mut(half);
    for line in lines {
        let (even_line, odd_line);
        (even_line, even) = even.split_at_mut(2 * line.len());
        (odd_line, odd) = odd.split_at_mut(2 * line.len());
        match line {
            SampleRow::F32(values) => part(values.iter().map(|value| value.to_le_bytes()), even_line, odd_line),
            SampleRow::U32(values) => part(values.iter().map(|value| value.to_le_bytes()), even_line, odd_line),
        }
    }

    // Take differences, with 128 for none, and deflate them.
    let mut differences = parted.clone();
    for (difference, pair) in differences.iter_mut().skip(1).zip(parted.windows(2)) {
        *difference = pair[1].wrapping_sub(pair[0]).wrapping_add(128);
    }
    let mut packer = ZlibEncoder::new(Vec::with_capacity(half), Compression::new(EFFORT));
    packer.write_all(&differences)?;
    let packed = packer.finish()?;
    if packed.len() < parted.len() {
        return Ok(packed);
    }
    let (even, odd) = parted.split_at(half);
    Ok(even.iter().zip(odd).flat_map(|(even, odd)| [*even, *odd]).collect())
}

/// Parts the first and third byte of each word from the second and fourth.
fn part(words: impl Iterator<Item = [u8; 4]>, even: &mut [u8], odd: &mut [u8]) {
    for ([a, b, c, d], (even, odd)) in words.zip(even.chunks_exact_mut(2).zip(odd.chunks_exact_mut(2))) {
        even.copy_from_slice(&[a, c]);
        odd.copy_from_slice(&[b, d]);
    }
}
