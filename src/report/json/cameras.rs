//! The cameras that the halves of a picture are used as.

use super::figure::Figure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the two cameras are to each other, by pinholes fitted to the corners.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// Distance of the centres.
    pub baseline_mm: Figure,
    /// Angle between the rays of the image centres, positive where they converge.
    pub vergence_deg: Figure,
    /// Field of view of a half between the middles of its left and right side, mean of both.
    pub field_h_deg: Figure,
    /// The same between top and bottom.
    pub field_v_deg: Figure,
    /// How far a point at the middle of the scene's own board moves along z for 1 px less of disparity.
    pub depth_per_px_mm: Figure,
}

/// Both cameras, in OpenCV's convention: pixel (i, j) has its centre at (i, j), x to the right, y down, z forward; each half
/// with px of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cameras {
    /// `true corners` or `found corners`.
    pub from: String,
    /// What was free in the fits; everything else as designed.
    pub free: Vec<String>,
    /// Nearest and farthest board of the fits, in mm.
    pub depths_mm: Option<[f64; 2]>,
    /// Columns and rows of a half.
    pub size_px: [u64; 2],
    /// The picture's column that is the right half's column 0.
    pub right_half_first_column: u64,
    /// Whether positions are meant as the plain pinhole of the same focal length would see them, in place of the scene's own camera
    /// with its principal point, rotation and distortion.
    pub rectified: bool,
    /// The camera of the left half.
    pub left: CameraEntry,
    /// The camera of the right half.
    pub right: CameraEntry,
    /// From the left to the right camera: `R`, `T` of `stereoCalibrate`.
    pub right_from_left: PairPose,
}

/// A pinhole fitted to a half.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Camera")]
pub struct CameraEntry {
    /// The camera matrix, row by row, in px.
    pub k: [[f64; 3]; 3],
    /// From the world to the camera.
    pub camera_from_world: PairPose,
    /// Length of the residuals, root mean square, in px.
    pub rms_px: f64,
    /// Corners behind the fit.
    pub n: u64,
}

/// A rigid motion: x' = R x + t.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Pose")]
pub struct PairPose {
    /// R, row by row.
    pub r: [[f64; 3]; 3],
    /// t, in mm.
    pub t_mm: [f64; 3],
}
