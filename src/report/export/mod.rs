//! A prism as other optics programs take it.

mod half_surface;
pub mod grid_sag;
pub mod optiland;
pub mod zemax_extended;
