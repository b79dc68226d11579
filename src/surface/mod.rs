//! TODO room

pub mod face;
pub mod shape;
mod polynomial;
mod height_field;
pub mod mesh;
pub mod figure_error;
pub(crate) mod hit;
