//! One ray at one place: surfaces, refraction, and how a ray can end.

pub mod crossing;
pub mod fate;
pub mod mesh;
pub mod snell;
pub mod surface;
