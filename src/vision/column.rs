//! A number of each of some pixels that are worked on together.

/// Pixels that are worked on together.
pub(super) const CHUNK: usize = 32;

/// A number of each of them.
pub(super) type Column = [f64; CHUNK];
