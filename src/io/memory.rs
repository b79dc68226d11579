//! How much memory the reading of a file may take, and how short a file of so many pixels may be: both are asked before
//! memory is taken.

use crate::error::Error;
use std::io::{self, Seek, SeekFrom};
use std::path::Path;

/// Bytes of memory that a picture may take while it is read: the file's values as far as they are held at a time, and the
/// light that is made of them in f32, together.
pub const PICTURE_BYTES: u64 = 1 << 30;

/// Bytes that one compressed byte becomes at most.
///
/// - Deflate: 258 bytes of two codes of one bit each, 1032 (RFC 1951, 3.2.5); PXR24 packs four bytes into three before.
/// - PIZ: codes of one bit, with runs of up to 255 numbers of two bytes by nine bits, 453; run lengths of EXR 64; B44A 11.
pub(super) const MOST_EXPANSION: u64 = 1032;

/// Refuses a picture whose reading would hold `held` bytes at a time besides its light.
///
/// # Errors
/// More than [`PICTURE_BYTES`] together.
pub(super) fn check_memory(path: &Path, (width, height): (usize, usize), held: u64) -> Result<(), Error> {
    let light = 4 * width as u64 * height as u64;
    let needed = light.saturating_add(held);
    if needed <= PICTURE_BYTES {
        return Ok(());
    }
    let rule = format!(
        "the picture is {width} x {height}, and to read it takes {} MiB of memory; the limit is {} MiB",
        needed.div_ceil(1 << 20),
        PICTURE_BYTES >> 20
    );
    Err(Error::new(path.display(), rule, "use a smaller picture: cut out the part that is meant, or take fewer pixels"))
}

/// Refuses a file of `bytes` bytes that needs `needed` for the pixels that it announces.
///
/// # Errors
/// Fewer bytes than needed.
pub(super) fn check_length(path: &Path, (width, height): (usize, usize), bytes: u64, needed: u64) -> Result<(), Error> {
    if bytes >= needed {
        return Ok(());
    }
    let rule = format!(
        "the file has {bytes} bytes, and {width} x {height} pixels of its kind need {needed} or more: it is cut short, or \
         its header is wrong"
    );
    Err(Error::new(path.display(), rule, "copy the file again, or export it anew"))
}

/// The length of a file in bytes; it is then read from its start.
pub(super) fn length(source: &mut impl Seek) -> io::Result<u64> {
    let bytes = source.seek(SeekFrom::End(0))?;
    source.rewind()?;
    Ok(bytes)
}
