//! The entries of the fits of a prism's surfaces to their points.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The surfaces of a prism that was given by points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceFits {
    /// The surface towards the camera.
    pub front: SurfaceFitEntry,
    /// The surface towards the board.
    pub back: SurfaceFitEntry,
}

/// How well a polynomial goes through the points of a surface, and what its misfit moves in the picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "SurfaceFit")]
pub struct SurfaceFitEntry {
    /// Total degree of the polynomial.
    pub degree: u64,
    /// Its coefficients.
    pub coefficients: u64,
    /// Points that they were fitted to.
    pub points: u64,
    /// Root mean square of the residuals along z.
    pub rms_mm: f64,
    /// Largest residual along z.
    pub max_mm: f64,
    /// Number of the point that has it, from 1 in the order of the file.
    pub worst_point: u64,
    /// That point, in the prism's frame.
    pub worst_mm: [f64; 3],
    /// How far a sag that is wrong by `rms_mm` moves the board's point in the picture, by the ray that passes nearest to the
    /// worst point, without the slope that comes with it; `null` where no ray passes.
    pub rms_px: Option<f64>,
    /// The same for `max_mm`.
    pub max_px: Option<f64>,
    /// Largest shift of the picture when the surface is fitted with two degrees more: what the misfit does by its slopes;
    /// `null` where the points do not determine so many coefficients twice over.
    pub finer_px: Option<f64>,
}
