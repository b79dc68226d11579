//! The biprism: which face a ray meets first, and its way through for one ray, for a packet, and for light that is
//! reflected.

#[cfg(test)]
mod nonsequential_tests;
#[cfg(test)]
mod parity_tests;
pub mod packet;
pub mod reflections;
pub mod payload;
pub mod surface_modifier;
pub mod refract_at;
pub mod biprism;
mod as_built;
mod first_face;
pub mod side;
