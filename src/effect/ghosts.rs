//! Light that reaches the camera after reflections at the surfaces of the glass.

/// Reflections, followed without chance through all surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ghosts {
    /// Light that has been reflected more often than this is given up; 0 for no ghosts.
    pub bounces: u32,
    /// Light of less power than this, of 1 that would come in, is given up.
    pub least_power: f64,
    /// Radiance of what lies on the camera's side of the glass, of full scale 1.
    pub behind: f64,
    /// Rays along each side of a pixel. Ghosts are sampled, for they are weak: an edge whose ghost has the weight w is
    /// right to w over twice this number, times the contrast.
    pub samples: usize,
}

impl Ghosts {
    /// Whether it changes nothing.
    pub fn is_nothing(&self) -> bool {
        self.bounces == 0
    }
}
