//! Which instrument made a picture, so that no other one's truth is taken for its own.
//!
//! What the truth of a picture depends on has four parts: camera, prism, board, effects. Each is told by the hash FNV-1a of
//! 64 bits over its values in the order in which they stand in this file. The values are canonical: they are those of the
//! checked scene in its units (mm, rad, nm), whatever its file calls them and whatever types hold them.
//!
//! - a number is the 8 bytes of its f64, little-endian, with -0 as 0; counts and flags are numbers;
//! - a word (which kind of prism, which glass) is its bytes in UTF-8 and a byte 0xff;
//! - a list is its length, then its items; what may be missing is a list of none or one.
//!
//! A change of this order, or of the units, orphans the pictures that were rendered before: they are refused as another
//! instrument's.

mod checksum;
mod effects;
mod parts;

pub use parts::{others, parts};
