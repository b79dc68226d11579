//! The markers of a JPEG file (ITU-T T.81, annex B), as far as they tell whether it is whole.

use std::io::{self, BufRead, ErrorKind, Read};

/// Pixels that one byte of a JPEG stands for at most: a component at full resolution has a code of one bit for each of its
/// blocks of 64 pixels, and at the largest sampling factors two components share the resolution between them.
pub(super) const PIXELS_A_BYTE: u64 = 1024;

/// What the markers say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct JpegOutline {
    /// Whether the coefficients of the whole picture are held before it is made.
    pub(super) progressive: bool,
    /// Whether the end of the picture is there.
    pub(super) whole: bool,
}

/// Goes through the markers of a file from its start.
///
/// # Errors
/// Those of `source`, but for its end.
pub(super) fn outline(source: &mut impl BufRead) -> io::Result<JpegOutline> {
    let mut found = JpegOutline { progressive: false, whole: false };
    match walk(source, &mut found) {
        Err(error) if error.kind() != ErrorKind::UnexpectedEof => Err(error),
        _ => Ok(found),
    }
}

fn walk(source: &mut impl BufRead, found: &mut JpegOutline) -> io::Result<()> {
    let mut start = [0; 2];
    source.read_exact(&mut start)?;
    loop {
        match marker(source)? {
            // End of image.
            0xd9 => {
                found.whole = true;
                return Ok(());
            }
            // Markers without a segment; those of restarts stand within the coded data.
            0x01 | 0xd0..=0xd8 => {}
            code => {
                found.progressive |= matches!(code, 0xc2 | 0xc6 | 0xca | 0xce);
                let mut length = [0; 2];
                source.read_exact(&mut length)?;
                skip(source, u64::from(u16::from_be_bytes(length)).saturating_sub(2))?;
            }
        }
    }
}

/// The code of the next marker, past coded data.
fn marker(source: &mut impl BufRead) -> io::Result<u8> {
    loop {
        if source.skip_until(0xff)? == 0 {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        let mut code = [0xff];
        while code[0] == 0xff {
            source.read_exact(&mut code)?;
        }
        // A zero makes the 0xff before it a byte of the coded data.
        if code[0] != 0 {
            return Ok(code[0]);
        }
    }
}

fn skip(source: &mut impl BufRead, bytes: u64) -> io::Result<()> {
    let skipped = io::copy(&mut source.take(bytes), &mut io::sink())?;
    if skipped == bytes { Ok(()) } else { Err(ErrorKind::UnexpectedEof.into()) }
}
