//! Pictures as data: pixels, transfer curves, comparison. Nothing here touches a file.

mod pixels;
pub mod transfer;
pub mod compare;

pub use pixels::{MAX_PIXELS, MAX_SIDE_PX, Raster};
