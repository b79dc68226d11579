//! Surfaces: the shapes that a ray can intersect, without their media.
//!
//! Each gives the first hit of a ray (`intersect`), its normal, and how the normal changes along the surface: planes,
//! polynomial surfaces, surfaces of revolution, triangle meshes, and any of them moved or with a figure error added to its height.

pub mod face;
pub mod shape;
mod polynomial;
mod revolved;
mod revolved_height;
mod height_field;
pub(crate) mod normals;
mod parts;
mod graph;
pub mod packed_graph;
mod shear;
pub mod triangle;
pub mod mesh;
pub mod closed_body;
pub mod solid;
pub(crate) mod weld;
pub mod figure_error;
pub(crate) mod hit;
