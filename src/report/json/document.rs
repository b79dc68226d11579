//! The types of `report.json`.

use super::board_pose::{BoardPoseEntry, MatchingEntry};
use super::budget::ErrorBudget;
use super::cameras::{Cameras, Geometry};
use super::figure::Figure;
use super::fit::SurfaceFits;
use crate::accuracy::keeps_to;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A whole report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// Name and version of this format.
    pub schema: SchemaName,
    /// Name of the scene, or of the picture that was measured.
    pub scene: String,
    /// One entry for each prism judged.
    pub designs: Vec<Design>,
}

/// Name and version of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum SchemaName {
    /// The only one so far.
    #[serde(rename = "biprism-report/1")]
    V1,
}

/// One prism, judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// `flat`, `freeform`, or the scene's own name for it.
    pub name: String,
    /// Each half by itself.
    pub halves: Halves,
    /// Left against right.
    pub stereo: Stereo,
    /// Both halves, pooled, against their pinholes.
    pub pinhole: PinholeEntry,
    /// What the cameras of the halves are to each other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometry: Option<Geometry>,
    /// The cameras of the halves; absent where they could not be fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cameras: Option<Cameras>,
    /// Corners of both halves together.
    pub corners: Corners,
    /// How the rays ended, by name of the fate.
    pub fates: BTreeMap<String, u64>,
    /// Seconds of wall-clock time, by step.
    pub timing_s: BTreeMap<String, f64>,
    /// Why no figure of the pair was measured; absent where some was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_judged: Option<String>,
    /// The name of that cause.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_judged_cause: Option<String>,
    /// How the halves of a picture were matched that was not made here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matching: Option<MatchingEntry>,
    /// Where the board of a picture is that was not made here; absent without corners.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub board_pose: Option<BoardPoseEntry>,
    /// The light in which the true values are true; absent where there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth_light: Option<String>,
    /// Effects that smear edges, which moves corners besides: what they do is in the difference of found and true corners.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub smeared_by: Vec<String>,
    /// How accurately the picture was made; absent where it was not made here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracyEntry>,
    /// Where the error of a corner comes from, when it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_budget: Option<ErrorBudget>,
    /// How well the surfaces go through the points that they were fitted to, where they were.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_fits: Option<SurfaceFits>,
}

/// How accurately a picture was made: shifts of its lines and corners, in px.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Accuracy")]
pub struct AccuracyEntry {
    /// `draft`, `standard`, `exact` or `reference`.
    pub level: String,
    /// What was asked for, where the level was chosen by that: the cheapest that promises it.
    pub target_px: Option<f64>,
    /// What the level promises against the reference.
    pub promise_px: f64,
    /// What it kept to, as far as the picture itself can tell: error of the map, and bend left inside pixels.
    pub achieved_px: f64,
    /// Pixels that were divided as often as allowed and not as often as it takes.
    pub capped_pixels: u64,
    /// Standard error of a pixel in the worst block of 16 x 16 px, of full scale 1, where random sets tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
    /// What that should have been at most, where `quadrature.noise` asked for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_target: Option<f64>,
    /// Pixels whose division along their borders ended at the most rays allowed, for which the promise does not hold; absent
    /// where there are none.
    #[serde(default, skip_serializing_if = "crate::render::is_zero")]
    pub unpromised_pixels: u64,
}

impl AccuracyEntry {
    /// What was asked for and is not kept, a sentence each.
    pub fn unmet(&self) -> Vec<String> {
        let missed = self.target_px.filter(|target_px| !keeps_to(*target_px, self.achieved_px));
        let geometry = missed.map(|target_px| format!("not kept to {target_px:.0e} px, as was asked for"));
        let loud = self.noise_target.filter(|target| self.noise.is_none_or(|noise| noise > *target));
        let noise = loud.map(|target| {
            let reached = self.noise.map_or("not told".to_owned(), |noise| format!("{noise:.1e}"));
            format!(
                "the standard error in the worst block is {reached}, and `quadrature.noise` asks for {target:.1e}: give more \
                 `replicates` or `points`"
            )
        });
        geometry.into_iter().chain(noise).collect()
    }
}

/// The two halves of the image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Halves {
    /// Columns `0..width / 2`.
    pub left: HalfEntry,
    /// Columns from `width / 2` rounded up to `width`; the middle column of an odd width is in neither half.
    pub right: HalfEntry,
}

/// One half of the image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Half")]
pub struct HalfEntry {
    /// Its corners.
    pub corners: Corners,
    /// It against its pinhole.
    pub pinhole: PinholeEntry,
}

/// Left against right, on the raw halves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stereo {
    /// Of y_L - y_R: ROS's epipolar error, but without rectification.
    pub vertical_disparity_rms_px: Figure,
    /// Of y_L - y_R.
    pub vertical_disparity_max_px: Figure,
    /// Mean of y_L - y_R, signed.
    pub vertical_disparity_mean_px: Figure,
    /// OpenCV's "average epipolar err" for horizontal epipolar lines: 2 mean |y_L - y_R|.
    pub opencv_average_epipolar_px: Figure,
    /// Largest |slope| of an epipolar curve's best line.
    pub epipolar_slope_max_rad: Figure,
    /// Mean |slope|.
    pub epipolar_slope_mean_rad: Figure,
    /// Rise of the steepest line over the width of a half image.
    pub epipolar_rise_max_px: Figure,
    /// Perpendicular distances of the curves' samples from their best lines.
    pub epipolar_departure_rms_px: Figure,
    /// The largest of these.
    pub epipolar_departure_max_px: Figure,
    /// Of y_L - y_R after one homography a half: rectified by the cameras that fit best over all depths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rectified_vertical_disparity_rms_px: Option<Figure>,
    /// The largest of these.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rectified_vertical_disparity_max_px: Option<Figure>,
    /// Disparities x_L - x_R about the law offset + gain / depth of an ideal pair.
    pub depth_law_rms_px: Figure,
    /// Depth of the scene's own board by the designed pair on the raw halves less the true one, from the left centre on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_error_rms_mm: Option<Figure>,
    /// The largest of these.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_error_max_mm: Option<Figure>,
    /// The same of the true depth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_error_rms_percent: Option<Figure>,
    /// The largest of these.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_error_max_percent: Option<Figure>,
}

/// An image against a pinhole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Pinhole")]
pub struct PinholeEntry {
    /// Against the designed virtual camera, nothing fitted: rays on its virtual image plane.
    pub designed: Designed,
    /// Against the pinhole that fits best.
    pub fitted: Fitted,
    /// Against the best pinhole with two focal lengths, where one was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub anamorphic: Option<Fitted>,
    /// Against the best pinhole with its principal point free too, where one was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub principal: Option<Fitted>,
    /// Against the designed virtual camera over all depths, after one homography of the half.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub homography: Option<Fitted>,
    /// Against the row law that fits best over all depths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub row_law: Option<RowLaw>,
    /// Inner corners of rows and columns from the chord of the end corners (ROS linearity, which takes rows only).
    pub straightness_rms_px: Figure,
    /// The largest of these.
    pub straightness_max_px: Figure,
    /// The rays against one centre, where rays were traced or corners seen at several depths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre: Option<Centre>,
    /// The same at each board depth, nearest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub depths: Vec<Depth>,
}

/// Against the designed virtual camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Designed {
    /// Horizontal: Table 1 of the design paper.
    pub mean_abs_h_mm: Figure,
    /// Vertical.
    pub mean_abs_v_mm: Figure,
    /// Horizontal, in px.
    pub mean_abs_h_px: Figure,
    /// Vertical, in px.
    pub mean_abs_v_px: Figure,
    /// Length of the error vectors.
    pub rms_px: Figure,
    /// The longest.
    pub max_px: Figure,
}

/// Against a fitted pinhole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fitted {
    /// What was free in the fit; everything else as designed.
    pub free: Vec<String>,
    /// Length of the residual vectors; ROS's reprojection error is this over sqrt(2).
    pub rms_px: Figure,
    /// The longest.
    pub max_px: Figure,
}

/// Against u = f_x X/Z + c_x, v = f_y Y/Z with a centre that is free in X and Z.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RowLaw {
    /// What was free in the fit.
    pub free: Vec<String>,
    /// Along the rows, of the rows as they are.
    pub rms_u_px: Figure,
    /// Across the rows.
    pub rms_v_px: Figure,
    /// Along the rows, each row's own shift kappa(v) undone.
    pub undone_rms_u_px: Figure,
    /// Across the rows.
    pub undone_rms_v_px: Figure,
    /// The longest error vector, undone.
    pub undone_max_px: Figure,
}

/// The object-side rays against one centre of projection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Centre {
    /// From the designed centre to the point nearest to all rays.
    pub drift_mm: Figure,
    /// Distances of the rays from the point nearest to all: 0 for a central camera.
    pub miss_rms_mm: Figure,
    /// Distances of the rays from the designed centre.
    pub designed_miss_rms_mm: Figure,
}

/// A half (or both) at one depth of the board.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Depth {
    /// Distance of the board's centre from the camera along z, in mm.
    pub depth_mm: f64,
    /// Against the designed virtual camera, nothing fitted: corners against projected corners.
    pub designed: Designed,
    /// Against a pinhole fitted at this depth alone.
    pub fitted: Fitted,
    /// From the designed centre to that of the pinhole fitted at this depth.
    pub centre_drift_mm: Figure,
    /// As for the whole.
    pub straightness_rms_px: Figure,
}

/// What the detector did, judged by the exact positions where they are known.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Corners {
    /// Corners whose four squares lie wholly in their half; `null` where the truth is unknown.
    pub visible: Option<u64>,
    /// How many of these were found; all that were found, where the truth is unknown.
    pub found: u64,
    /// Corners found of which a square is cut by the border of the half.
    #[serde(default)]
    pub partial: u64,
    /// Found where there is none, or with a wrong index; `null` where the truth is unknown.
    #[serde(rename = "false")]
    pub spurious: Option<u64>,
    /// sqrt(sum |e|^2 / N) over the N = found + partial corners, of detected minus exact position, in px (pixel-edge
    /// convention).
    pub rms_error_px: Option<f64>,
    /// Largest |e|, in px.
    pub max_error_px: Option<f64>,
    /// Candidates given up, by reason.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub rejected: BTreeMap<String, u64>,
}
