//! One number of a report, with all that is needed to compare it.

use crate::metrics::MeasuredAndTrue;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number that judges the optics: what a user would measure, what is exactly so, and how it is defined.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// From detected corners; `null` when it could not be measured.
    pub measured: Option<f64>,
    /// From exact positions or rays; `null` when these are unknown (a photograph).
    #[serde(rename = "true")]
    pub exact: Option<f64>,
    /// N behind `measured`, or behind `true` where nothing was measured.
    pub n: usize,
    /// N behind `true`, which may be taken on another set of points.
    pub n_true: usize,
    /// Unit of both values.
    pub unit: Unit,
    /// How N errors e became one value.
    pub normaliser: Normaliser,
    /// Where the errors live.
    pub frame: Frame,
    /// Where pixel (i, j) has its centre.
    pub pixel_centre: PixelCentreName,
    /// Nearest and farthest depth of the points behind the values, in mm, where it matters and is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depths_mm: Option<[f64; 2]>,
    /// Why a value is `null`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// Unit of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Unit {
    /// Pixels.
    #[serde(rename = "px")]
    Px,
    /// Millimetres.
    #[serde(rename = "mm")]
    Mm,
    /// Radians.
    #[serde(rename = "rad")]
    Rad,
    /// Degrees.
    #[serde(rename = "deg")]
    Deg,
    /// Hundredths.
    #[serde(rename = "%")]
    Percent,
}

/// How N errors became one value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Normaliser {
    /// Root mean square of N lengths or scalars: never over the 2N components of vectors.
    #[serde(rename = "sqrt(sum |e|^2 / N)")]
    Rms,
    /// Mean magnitude.
    #[serde(rename = "sum |e| / N")]
    MeanAbs,
    /// Signed mean.
    #[serde(rename = "sum e / N")]
    Mean,
    /// OpenCV's sum of two distances.
    #[serde(rename = "2 sum |e| / N")]
    TwiceMeanAbs,
    /// Largest magnitude.
    #[serde(rename = "max |e|")]
    Max,
    /// The one value of a fit to N points.
    #[serde(rename = "fit to N")]
    Fit,
}

/// Where errors live.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Frame {
    /// The raw half image, each half from its own top left corner, no rectification.
    #[serde(rename = "raw half image")]
    RawHalf,
    /// The image plane of the designed virtual camera, at its focal length.
    #[serde(rename = "virtual image plane")]
    VirtualImagePlane,
    /// The world.
    #[serde(rename = "world")]
    World,
}

/// Where pixel (i, j) has its centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "PixelCentre")]
pub enum PixelCentreName {
    /// The pixel-edge convention: it covers `[i, i+1) x [j, j+1)`. OpenCV's positions are less by 0.5.
    #[serde(rename = "(i + 0.5, j + 0.5)")]
    Half,
}

/// How a figure is defined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Definition {
    /// Unit of its values.
    pub unit: Unit,
    /// How N errors become one value.
    pub normaliser: Normaliser,
    /// Where the errors live.
    pub frame: Frame,
    /// Nearest and farthest depth of the points that were used, in mm, where it matters and is known.
    pub depths_mm: Option<[f64; 2]>,
}

impl Definition {
    /// In px of the raw half image.
    pub const fn px(normaliser: Normaliser) -> Self {
        Self { unit: Unit::Px, normaliser, frame: Frame::RawHalf, depths_mm: None }
    }

    /// In mm, in the given frame.
    pub const fn mm(normaliser: Normaliser, frame: Frame) -> Self {
        Self { unit: Unit::Mm, normaliser, frame, depths_mm: None }
    }

    /// A figure of this definition from results: `pick` takes the value and its N out of each. A side that was never
    /// asked for is `None`.
    pub fn figure<T>(self, both: &MeasuredAndTrue<T>, pick: impl Fn(&T) -> (f64, usize)) -> Figure {
        let side = |result: &Option<Result<T, crate::metrics::Unmeasurable>>| match result {
            None => (None, 0, None),
            Some(Err(reason)) => (None, 0, Some(reason.to_string())),
            Some(Ok(found)) => match pick(found) {
                (value, n) if value.is_finite() => (Some(value), n, None),
                (value, n) => (None, n, Some(format!("its value is {value}"))),
            },
        };
        let (measured, n, why_not_measured) = side(&both.measured);
        let (exact, n_true, why_not_true) = side(&both.exact);
        let reason = match (why_not_measured, why_not_true) {
            (Some(a), Some(b)) if a != b => Some(format!("measured: {a}; true: {b}")),
            (a, b) => a.or(b),
        };
        Figure {
            measured,
            exact,
            n: if measured.is_some() { n } else { n_true },
            n_true,
            unit: self.unit,
            normaliser: self.normaliser,
            frame: self.frame,
            pixel_centre: PixelCentreName::Half,
            depths_mm: self.depths_mm,
            reason,
        }
    }
}
