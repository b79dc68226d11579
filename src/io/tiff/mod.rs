//! TIFF pictures (revision 6.0, and BigTIFF) of 8 or 16 bits, grey or RGB, to linear light, strip by strip or tile by tile.

mod tags;
mod directory;
mod layout;
mod unpack;
mod read;

pub(super) use directory::is_tiff;
pub(super) use read::read_from;
