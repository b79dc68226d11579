//! The hit: the intersection of a ray with a surface.

use glam::DVec3;

/// The intersection of a ray with a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance along the ray, in mm.
    pub t_mm: f64,
    /// Unit normal, of either orientation.
    pub normal: DVec3,
    /// The number of the triangle in a mesh; of the backs of a solid prism the side; 0 of other surfaces.
    pub part: u32,
}
