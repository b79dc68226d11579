//! The biprism: its shapes and media, and the kernels that refract rays through it, one by one, in packets, and with
//! reflections. One rule says which face a ray meets first (`first_face`).

#[cfg(test)]
mod parity_tests;
pub mod lanes;
pub mod packet;
pub mod packed_revolved;
pub mod reflections;
pub mod payload;
pub mod surface_modifier;
pub mod refract_at;
pub mod biprism;
mod as_built;
pub mod triangles;
pub mod packed_triangles;
mod first_face;
pub mod side;
