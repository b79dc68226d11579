//! Bytes of files, in and out, and nothing of what a scene means. Every size that a file states has a limit, checked before
//! memory is taken.

pub mod inputs;
pub mod atomic;
pub(crate) mod metadata;
mod curve_source;
mod open;
pub(crate) mod picture_file;
mod photo;
mod jpeg;
mod jpeg_scan;
mod pnm;
mod tiff;
pub mod memory;
pub mod exr;
pub mod png;
pub mod npy;
pub mod npy_table;
pub mod embedded_picture;
mod ply;
pub mod mesh;
mod stl;
pub mod solid;
pub mod point_cloud;
pub mod point_grid;
pub mod grid_sag;
pub(crate) mod file_storage;
pub mod corners;
pub mod calibration;
mod lines;

pub use curve_source::CurveSource;
pub use metadata::{GAMMA, Metadata, Notes};
pub use picture_file::read;
