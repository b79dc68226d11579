//! The entries of how the corners of a photograph were matched and where its board is.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the board of a picture is that was not made here, and how that is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "BoardPose")]
pub struct BoardPoseEntry {
    /// Where it comes from.
    pub source: BoardPoseSource,
    /// The numbers that were free in the fit; none where nothing was fitted.
    pub free: Vec<String>,
    /// Position of the middle of the squares; `null` where it is not known.
    pub position_mm: Option<[f64; 3]>,
    /// Tilt about the fixed x, then y, then z axis.
    pub tilt_deg: Option<[f64; 3]>,
    /// sqrt(sum |e|^2 / N) over the N corners of both halves, of found minus explained position: along the rays as the scene's
    /// prism and camera bend them.
    pub residual_rms_px: Option<f64>,
    /// The largest |e|.
    pub residual_max_px: Option<f64>,
    /// N.
    pub corners: u64,
    /// The RMS that the stated pose leaves, where one was fitted in its place; `null` too where a ray does not meet it.
    pub stated_rms_px: Option<f64>,
    /// From the stated to the fitted place.
    pub off_mm: Option<f64>,
    /// Between the stated and the fitted tilt.
    pub off_deg: Option<f64>,
    /// Tilt of another pose that the corners do not tell from this one, where there is such.
    pub other_tilt_deg: Option<[f64; 3]>,
    /// Why the fit failed, where it did.
    pub failure: Option<String>,
    /// What told which corners of the board are seen.
    pub placed_by: PlacedByName,
    /// Columns and rows over which the corners of both halves reach.
    pub seen: [u64; 2],
}

/// Where a pose comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum BoardPoseSource {
    /// The scene states it, and the corners agree.
    #[serde(rename = "stated")]
    Stated,
    /// Fitted, as `board.pose` asks.
    #[serde(rename = "fitted as asked")]
    Asked,
    /// Fitted, because the stated one does not match the corners.
    #[serde(rename = "fitted in place of the stated one")]
    Mismatch,
    /// The fit failed, and the stated one does not match.
    #[serde(rename = "unknown")]
    Unknown,
}

/// What told which corners of the board are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "PlacedBy")]
pub enum PlacedByName {
    /// No other place has the board's size and colours.
    #[serde(rename = "only place")]
    OnlyPlace,
    /// Of the places that have, the one nearest to the stated pose: position and indices hold up to whole squares.
    #[serde(rename = "nearest to the stated pose")]
    NearestToStated,
    /// No place has the board's colours.
    #[serde(rename = "against the colours")]
    AgainstColours,
    /// The corners reach over more columns or rows than the board has, and are counted from the first one seen.
    #[serde(rename = "larger than the board")]
    LargerThanBoard,
}

/// Which corner of the left half is which of the right one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Matching")]
pub struct MatchingEntry {
    /// What told the shift in columns.
    pub columns_by: MatchedByName,
    /// What told the shift in rows.
    pub rows_by: MatchedByName,
    /// How far the shift is from what the rays, or the stated pose, say, in squares.
    pub doubt_squares: f64,
    /// The figures that rest on the match, by path; none where both halves show the whole board.
    pub rests: Vec<String>,
}

/// What told a shift between the halves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "MatchedBy")]
pub enum MatchedByName {
    /// Both halves show all of the board's columns, or rows.
    #[serde(rename = "whole board")]
    WholeBoard,
    /// The size of the squares in one half, and the rays of the other one.
    #[serde(rename = "rays")]
    Rays,
    /// The stated pose.
    #[serde(rename = "stated pose")]
    StatedPose,
}
