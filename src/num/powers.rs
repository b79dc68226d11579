//! Which terms of a polynomial of two variables are kept.

/// Which powers of y a fit has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Powers {
    /// All: a surface without symmetry.
    All,
    /// Even ones: a surface that is its own mirror image in the plane y = 0.
    EvenInY,
}
