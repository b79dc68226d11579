//! One ray at one place: surfaces, refraction, and how a ray can end.

pub mod crossing;
pub mod fate;
pub mod flaw;
mod freeform;
pub mod fresnel;
pub mod medium;
mod height;
pub mod mesh;
pub mod polarisation;
pub mod snell;
pub mod spectrum;
pub mod surface;
