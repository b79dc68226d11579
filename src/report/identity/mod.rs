//! Which instrument made a picture, so that no other one's truth is taken for its own.
//!
//! What the truth of a picture depends on has four parts: camera, prism, board, effects. Each is told by the hash FNV-1a of
//! 64 bits over its canonical JSON. Its values are those of the checked scene in its units (mm, rad, nm, px), whatever its file
//! calls them and whatever types hold them; its keys are words of this folder alone. The form is [`FORM`]:
//!
//! - keys are sorted by their bytes, and nothing stands between tokens;
//! - a number is an f64 in the fewest digits that read back, with one digit before the point and an exponent (`3.5e1`), and
//!   -0 is `0e0`; counts are numbers; a seed is a string of digits, for an f64 does not hold it;
//! - triangles, which may be millions, are told by checksums: of the first, second and third coordinates of their corners, of the
//!   normals there, and of their numbers of corners, as f64 and u32 from the lowest byte on. What is told of such a prism has the
//!   number 2 in its form;
//! - what is absent (an effect, a glass, a stop) has no key, so that a version that learns something new tells the instruments
//!   without it as before.
//!
//! A picture whose notes name no form, or another one, was written by another version: nothing is known of its instrument, which
//! [`likeness`] says, and a user is told.

mod canonical;
mod effects;
mod parts;

pub use canonical::checksum_of_bytes;
pub use parts::{FORM, Likeness, likeness, parts};
