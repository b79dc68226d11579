//! The corner detector: finds and measures checkerboard corners in a picture. It knows nothing of the simulator, so it
//! works on a photograph too.
//!
//! ```text
//! picture --response: saddle maxima--> peaks --ring_test: bright, dark, bright, dark--> candidates
//!   --lattice_growth--> lattice --fit_all: blur, first fit, pruning, last fit--> corners, each with its covariance
//! ```
//!
//! Each corner is fitted with the model that a camera's pixels obey: two edges, bent as the lattice says, under a blur
//! and a square pixel, with light that varies linearly (`corner_fit`). The blur is a Gaussian unless the picture clearly shows another
//! (`shape_fit`). Without noise it errs by less than 0.001 px
//! RMS over a picture, and by 0.0018 px at the worst corner of 70 kinds of picture (`tests/vision`); with noise it
//! reaches the Cramer-Rao bound, and its covariance says so.
//!
//! # What counts as sufficiently visible
//! A corner is sought where the ring of 4.5 px around it lies in the picture and outside every mask, and where at
//! least half of its window (0.45 of the way to each neighbour) does; any other is left out with [`Reason::Cut`]. The
//! lines beside it must be 10 px away, and six blurs ([`Reason::Blurred`]).
//!
//! # Example
//! ```
//! use biprism::raster::Raster;
//! use biprism::vision::{Settings, detect};
//!
//! // A board of 30 px squares, linear radiance: one value a pixel.
//! let board = |k: usize| if (k % 200 / 30 + k / 200 / 30) % 2 == 0 { 0.8 } else { 0.1 };
//! let image = Raster::from_data(200, 160, (0..200 * 160).map(board).collect());
//! let found = detect(&image, None, &Settings::default());
//! assert_eq!(found.corners.len(), 6 * 5);
//! assert!((found.corners[0].position_px - glam::DVec2::new(30.0, 30.0)).length() < 1e-3);
//! ```

mod blur;
mod marks;
mod resolution;
mod elongation;
mod blur_shape;
mod shape_fit;
mod line_equations;
mod curvature;
mod equations;
mod equation_sums;
mod column;
pub mod half;
mod response;
mod strip;
mod halving;
mod candidates;
mod corner_pixel_model;
mod crossing;
mod motion;
mod pilot_fits;
mod edge_spread;
mod profile;
mod corner_site;
mod kinks;
mod lattice_lines;
mod lattice_lean;
mod lean;
mod listed;
mod corner_fit;
mod fit_all;
mod neighbours;
mod odd_residuals;
mod boards;
mod numbering;
mod board_size;
mod ring_test;
mod lattice_growth;
mod settings;
mod sharp_crossing;
mod detection;
mod window;
mod corner_model;
mod pixel_sums;
mod scatter;
mod candidate;
mod cell_table;
mod buckets;

pub use detection::{Corner, Detection, ElongatedBlur, Polarity, Reason, Rejected};
pub use settings::{Blur, LEAST_VISIBLE, Settings, UnevenLight};

use crate::raster::Raster;

pub use board_size::{BoardSize, SizedBoard, board_of_size};
use boards::measure_coarser;
pub use boards::{measure, measure_all};
pub use candidates::{Candidates, find_candidates};
use lattice_growth::grow_coarser;
pub use lattice_growth::{Lattices, grow};
pub use numbering::{LatticeCorner, turned_like, upright};

/// Finds and measures the corners of the largest checkerboard in a picture of linear radiance.
///
/// Pixels where `mask` is false or whose value is not finite do not count. The answer is the same, bit for bit, for any
/// number of threads. Any picture is taken: where there is no board the answer is empty. It is [`find_candidates()`],
/// [`grow()`] and [`measure()`] in turn, and where corners that are in sight are missing from a rectangle, the same in coarser pictures.
///
/// # Panics
/// When the mask has another size than the picture.
pub fn detect(image: &Raster<f32>, mask: Option<&Raster<bool>>, settings: &Settings) -> Detection {
    let mut candidates = find_candidates(image, mask);
    let finest = grow(&candidates, settings);
    let found = measure(&candidates, finest.clone(), settings);
    if !found.corners.is_empty() && !candidates.misses_some(&found) {
        return found;
    }

    // Look whether coarser pictures show more.
    candidates.add_coarser();
    let lattices = grow_coarser(&candidates, settings, finest);
    measure_coarser(&candidates, &lattices, found, settings)
}

/// Finds and measures the corners of every checkerboard in a picture, that of most corners first; the first is there even where there
/// is none, as in [`detect()`].
///
/// # Panics
/// When the mask has another size than the picture.
pub fn detect_all(image: &Raster<f32>, mask: Option<&Raster<bool>>, settings: &Settings) -> Vec<Detection> {
    let mut candidates = find_candidates(image, mask);
    candidates.add_coarser();
    let lattices = grow(&candidates, settings);
    measure_all(&candidates, &lattices, settings)
}
