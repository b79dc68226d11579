//! The renderer: from an instrument to a film of radiance with ground truth.
//!
//! [`render`] reads from top to bottom: passes, plan and bands, accumulation, diffraction, sensor. A plan (`plan`)
//! fixes everything before the first pixel; its bands (`bands`) are filled by the certified map (`map`, `tiling`,
//! `mapped`, along seams `seam_map` and `seam_pixels`), by tracing every pixel's centre (`tile`), or by the slow and simple reference
//! (`reference`); pixels under a border are clipped (`border`), those of meshes along the sides of triangles (`triangles`).

pub mod checkerboard;
mod pixel_mean;
mod region;
mod film;
mod work;
mod band;
mod centre_rays;
mod truncation_error;
mod map;
mod seam_map;
mod tiling;
mod steepness;
mod plan;
mod board_face;
mod passage;
mod pixel;
mod steep;
mod kinks;
mod border;
mod cut;
mod divided;
mod piece;
mod triangles;
mod centres;
mod tile;
mod draft;
mod row_map;
mod map_blocks;
mod mapped;
mod seam_pixels;
mod reference;
mod sights;
mod layers;
mod bands;
mod strips;
mod ghosts;
mod fill;
mod ground_truth;
mod sums;
mod accumulate;
mod diffraction;
mod driver;
mod sample;
pub mod supersample;

pub use bands::picture;
pub use centre_rays::{WayToBoard, WayTracer};
pub use diffraction::{cells, frame_px};
pub use driver::{render, render_classed, render_wanted};
pub(crate) use film::is_zero;
pub use film::{AccuracyReport, Class, Counts, Film, Outputs, Strip};
pub use plan::Plan;
pub use sample::{DiffractionSample, GhostSample, PieceOfWork, PixelWork};
pub use strips::{STRIP_ROWS, render_strips, strip_rows};

#[cfg(test)]
mod tests;
