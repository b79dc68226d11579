//! The sides of a biprism and its four surfaces.

use crate::surface::face::Face;

/// A side of the prism: x < 0 or x >= 0 in its own frame; `side as usize` is its index in pairs of left and right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// x < 0
    Left,
    /// x >= 0
    Right,
}

impl Side {
    /// Both, in the order of their indices.
    pub const ALL: [Self; 2] = [Self::Left, Self::Right];

    /// The side across the ridge.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }
}

/// A surface of a biprism, each a graph z(x, y) in the prism's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PrismFace {
    /// The side that it belongs to.
    pub side: Side,
    /// The facet that faces the camera, or the back.
    pub face: Face,
}
