//! Studies as sheets and figures.

pub mod document;
pub mod spots;
pub mod foci;
pub mod contrasts;
pub mod reprojections;
pub mod convergences;
pub mod layouts;
pub mod tolerances;
pub mod trial_lines;
pub mod trials;
pub mod surfaces;
pub mod paper_page;
pub mod stereo_residuals;
