//! The relay reading of the design paper's Figs. 7 to 9: a point near the camera's pinhole seen backwards through one half of
//! the prism, by an ideal lens behind it whose axis is parallel to the camera's.
//!
//! A central camera asks of a prism that all rays of one point, its pinhole O, leave the prism as if they came of one point O'.
//! So O is the object, the lens is focused on the plane of O', and its spot, its field curvature and its contrast tell how near the
//! prism comes to that. All surfaces are those of the scene's prism as made; the lens has no errors of its own.

pub mod lens;
pub mod pencil;
pub mod spot;
pub mod field_curvature;
pub mod wave_error;
pub mod mtf;
pub mod study;

#[cfg(test)]
pub(super) mod tests;
