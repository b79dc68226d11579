//! Points to numbers: how far a stereo pair is from ideal, and each half from a pinhole.
//!
//! It takes matched corners, rays and pinholes, and knows nothing of the simulator, so it judges a photograph as well.
//!
//! Conventions of every figure here, unless its own line says otherwise:
//! - image positions are px in the pixel-edge convention (pixel (i, j) covers `[i, i+1) x [j, j+1)`), each relative to
//!   the top left corner of its own half; world positions are mm;
//! - a residual is *found minus ideal*;
//! - `rms` is sqrt(sum |e|^2 / N) over N vectors, not the sqrt(sum |e|^2 / 2N) over scalars that ROS prints
//!   (see [`Deviation::rms_of_components`]);
//! - too little, collinear, or non-finite input is an [`Unmeasurable`] that says which, never a NaN.

pub use measured_and_true::{MeasuredAndTrue, Numbers};

pub mod line;
pub mod stereo;
pub mod depth_error;
pub mod pixel_map;
pub mod epipolar;
pub mod straightness;
pub mod pinhole;
pub mod reprojection;
pub mod row_law;
pub mod homography;
pub mod rectification;
pub mod rectified_pair;
pub mod pair_residual;
pub mod pair_geometry;
pub mod ray_bundle;
mod measured_and_true;
mod deviation;
mod observation;

pub use deviation::{Deviation, Unmeasurable};
pub use observation::{Observation, Pair};

#[cfg(test)]
mod noise;
