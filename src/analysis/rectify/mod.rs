//! The halves of a picture as a rectified pair: the two cameras that fit best, the maps from their images into the picture, and what
//! these leave at other depths.
//!
//! A pixel of a half sees along one ray. Where all rays of the half meet in one point, one map makes it a pinhole, at every depth.
//! Where they do not, a map is right at one depth: what it leaves elsewhere grows as the difference of the inverse depths.

mod maps;
mod rectifier;
mod residual;

pub use maps::{NOT_SEEN, SourceMap, Sources};
pub use rectifier::Rectifier;
pub(super) use rectifier::plane;
pub use residual::DepthResidual;
pub(super) use residual::seen_px;
