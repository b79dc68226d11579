//! PNG files: 16-bit pictures of light and 8-bit figures out, any PNG in.

mod read;
mod levels;
mod write;

pub use read::read;
pub use write::{
    SampleCoding, SamplePacking, write_grey16, write_grey16_strips, write_rgb, write_rgb16_strips, write_rgba,
};

pub(super) use read::read_from;
pub(super) use write::srgb_levels16;

/// The first bytes of every PNG file.
pub(super) const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
