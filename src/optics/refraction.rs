//! The refraction record of a ray at one surface.

use glam::DVec3;

/// A ray refracted at a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refraction {
    /// Unit direction before the surface.
    pub incoming: DVec3,
    /// Unit direction behind it.
    pub outgoing: DVec3,
    /// The unit normal, turned against the incoming ray.
    pub normal: DVec3,
    /// Cosine of the angle of incidence, in 0..=1.
    pub cos_in: f64,
    /// Cosine of the angle of refraction, in 0..=1.
    pub cos_out: f64,
    /// n_in / n_out
    pub eta: f64,
    /// Length of the ray's way to here from the surface before, or from its origin, in mm.
    pub way_mm: f64,
}
