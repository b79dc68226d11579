//! How a plane looks that is no checkerboard: its radiance from place to place, and the exact mean of that over a polygon.

mod convex;
mod texels;
mod chart;
pub mod noise;
mod plate;

pub use chart::Chart;
pub use convex::Convex;
pub use plate::{Plate, Texture};
pub use texels::{MOST_TEXELS, TexelFilter, Texels};
