//! Prism design: the freeform prism of a camera and a virtual camera.
//!
//! Everything here is in the prism's frame with the camera's pinhole O at the origin, and for the right half (x > 0);
//! the left half is its mirror image.

pub mod angle;
pub mod virtual_camera;
pub mod slope;
pub mod march;
pub mod marched;
pub mod fit;
pub mod cloud_fit;
pub mod misfit;
pub mod text;

pub mod point_grid;
pub mod starter;
mod axial;
mod designed_law;
mod revolved;
mod optimise;
mod freeform;

pub use designed_law::DesignedLaw;
pub use freeform::{
    DesignInput, DesignPoints, FreeformDesign, VIRTUAL_CAMERA_Z_MM, fitted_points, freeform, freeform_by, revolved_by,
    stated_integrator,
};
pub use optimise::{LawFigures, MetLaw, SpotFigures};
