//! One ray at one place: surfaces, refraction, and how a ray can end.

pub mod fate;
pub mod fresnel;
pub mod medium;
pub mod polarisation;
pub mod snell;
pub mod spectrum;
pub mod refraction;
