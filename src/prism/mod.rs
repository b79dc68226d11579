//! A ray's trip through interfaces.

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
