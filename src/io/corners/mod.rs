//! Corners to files and back: CSV for a table, JSON for a program, and the YAML of OpenCV's `FileStorage`.
//!
//! | file | a position is | ending |
//! |---|---|---|
//! | CSV, JSON | in px of the whole picture, pixel (i, j) centred at (i + 0.5, j + 0.5) | `.csv`, `.json` |
//! | OpenCV | in px of the whole picture, pixel (i, j) centred at (i, j) | `.yml`, `.yaml` |
//!
//! Every file names its convention, and a file that names none is refused: half a pixel is a hundred times the error of
//! a corner under noise of 1 %. The one function that goes between the two is [`move_centre`]. Numbers read back to the
//! last bit (OpenCV positions to half a unit in the last place, because of the shift).

mod csv;
mod json;
mod opencv;
#[cfg(test)]
mod tests;
mod pixel_centre;
mod view;
mod rules;
mod file;

pub use file::{CornerFormat, parse, read, to_text};
pub use pixel_centre::{PixelCentre, move_centre};
pub use rules::{MOST_BYTES, MOST_CORNERS, MOST_INDEX};
pub use view::{BlurEllipse, CornerView, IndexOrigin, ListedCorner, Quality, TransferFound};
