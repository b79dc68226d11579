//! A picture from a real camera, or of a board that does not stand where the scene says: its halves matched by their
//! lattices, and the board's pose fitted to them.
//!
//! ```text
//! lattices of the halves --rays--> sightings --plane of one half alone--> where the other half's corners lie on it
//!   --matching: a shift by whole squares--> one lattice --pose_fit: six numbers--> its plane
//!   --placement: which corners of the board--> the board's pose, held against the one that the scene states
//! ```
//!
//! The lattice has no mark, so its plane is fitted before anything is said of which corners of the board it shows: what is
//! measured of the pair depends neither on the stated pose nor on the place on the board.

mod sighting;
mod pose_fit;
mod pose_start;
mod offsets;
mod matching;
mod placement;
mod joint;
mod study;

pub use matching::{HalfMatch, MatchedBy};
pub use placement::PlacedBy;
pub use study::{FoundPose, Photograph, PoseSource, StatedPose, photograph};
