//! A ray's trip through interfaces.

pub mod packet;
pub mod reflections;
pub mod payload;
pub mod surface_modifier;
pub mod refract_at;
pub mod biprism;
mod as_built;
mod follow;
mod first_face;
pub mod side;
