//! TODO room

pub mod shape;
mod polynomial;
mod height_field;
pub mod mesh;
pub mod closed_body;
pub(crate) mod weld;
pub mod figure_error;
pub(crate) mod hit;
