//! The two surfaces of a prism, by where they face.

/// One of the two surfaces that a ray passes in sequence; `face as usize` is its index in pairs of front and back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Face {
    /// The surface that faces the camera.
    Front,
    /// The surface that faces the scene.
    Back,
}

impl Face {
    /// Both, in the order of their indices.
    pub const ALL: [Self; 2] = [Self::Front, Self::Back];
}
