//! The corners of one view of the board, as a file holds them.

use crate::vision::{Corner, Detection, Polarity};
use glam::{DMat2, DVec2};
use serde::{Deserialize, Serialize};

/// How well a corner was measured; a file of another program may not say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Covariance of the position, in px^2.
    pub covariance_px2: DMat2,
    /// Bright minus dark, in the unit of the picture.
    pub contrast: f64,
    /// Root mean square difference between picture and model, in the unit of the picture.
    pub residual: f64,
    /// Which diagonal is bright.
    pub polarity: Polarity,
}

/// A corner in a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ListedCorner {
    /// Column and row.
    pub index: [i32; 2],
    /// Position in the whole picture, in px, in our own convention ([`PixelCentre::Half`](super::PixelCentre::Half)).
    pub position_px: DVec2,
    /// How well it was measured, where that is known.
    pub quality: Option<Quality>,
}

/// What the column and row of a corner count from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IndexOrigin {
    /// The first column and row of the lattice that was found in that view, which may be any of the board's.
    Lattice,
    /// The inner corner of the board's top left square.
    Board,
}

impl IndexOrigin {
    const ALL: [Self; 2] = [Self::Lattice, Self::Board];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Lattice => "lattice",
            Self::Board => "board",
        }
    }

    /// The origin of that name, or what must be in its place.
    pub(super) fn of(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|origin| origin.name() == name).ok_or_else(|| {
            format!("the origin of the indices is {name:?}, and must be \"lattice\" (each view's own) or \"board\"")
        })
    }

    /// What all views of a file count from; `None` where they differ or one does not say.
    pub(super) fn of_all(views: &[CornerView]) -> Option<Self> {
        let first = views.first()?.index_origin;
        first.filter(|_| views.iter().all(|view| view.index_origin == first))
    }
}

/// One view of the board: a half of the picture, or the whole of it.
#[derive(Debug, Clone, PartialEq)]
pub struct CornerView {
    /// `left`, `right` or `whole`: lower-case letters.
    pub name: String,
    /// What their indices count from, where that is known.
    pub index_origin: Option<IndexOrigin>,
    /// Its corners.
    pub corners: Vec<ListedCorner>,
    /// How many candidates were turned down for each reason; kept in JSON only.
    pub rejected: Vec<(String, usize)>,
    /// The blur across both families of lines, in px; kept in JSON only.
    pub blur_px: Option<[f64; 2]>,
    /// The blur as an ellipse, where it is elongated: standard deviations along and across, in px, and the direction from +x towards
    /// +y (down), in deg; kept in JSON only.
    pub elongated_blur: Option<BlurEllipse>,
    /// By how many px edges lie towards dark ([`Detection::lean_px`]); kept in JSON only.
    pub lean_px: Option<f64>,
    /// Whether squares hold marks ([`Detection::marked_squares`]); kept in JSON only.
    pub marked_squares: bool,
    /// The transfer curve that was found for the picture, where its file states none; kept in JSON only.
    pub transfer: Option<TransferFound>,
}

/// An elongated blur.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlurEllipse {
    /// The largest standard deviation, in px.
    pub along_px: f64,
    /// The one across that direction, in px.
    pub across_px: f64,
    /// Where it is largest, from +x towards +y (down), in deg, in `[-90, 90]`.
    pub direction_deg: f64,
}

/// A transfer curve that was found from the picture's corners.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransferFound {
    /// Its name: `linear`, `sRGB` or `power 2.20` (light = value^2.20).
    pub curve: String,
    /// Median of residual over contrast under it.
    pub residual: f64,
    /// The next best curve.
    pub next: String,
    /// The same under that one.
    pub next_residual: f64,
    /// By how many standard errors both are told apart; at most 999.
    pub standard_errors: f64,
}

impl CornerView {
    /// Corners of which no more is known than these.
    pub(super) fn bare(name: String, corners: Vec<ListedCorner>) -> Self {
        Self {
            name,
            index_origin: None,
            corners,
            rejected: Vec::new(),
            blur_px: None,
            elongated_blur: None,
            lean_px: None,
            marked_squares: false,
            transfer: None,
        }
    }

    /// Corners of the board that are known without a picture, by their places on it.
    pub fn of_board(name: &str, corners: Vec<ListedCorner>) -> Self {
        Self { index_origin: Some(IndexOrigin::Board), ..Self::bare(name.to_owned(), corners) }
    }

    /// What was detected in the columns of a picture from `first_column` on.
    pub fn new(name: &str, first_column: usize, detection: &Detection) -> Self {
        let listed = |c: &Corner| ListedCorner {
            index: c.index,
            position_px: c.position_px + DVec2::new(first_column as f64, 0.0),
            quality: Some(Quality {
                covariance_px2: c.covariance_px2,
                contrast: c.contrast,
                residual: c.residual,
                polarity: c.polarity,
            }),
        };
        Self {
            name: name.to_owned(),
            index_origin: Some(IndexOrigin::Lattice),
            corners: detection.corners.iter().map(listed).collect(),
            rejected: detection.counts().into_iter().map(|(reason, n)| (reason.name().to_owned(), n)).collect(),
            blur_px: detection.sigma_px,
            elongated_blur: detection.elongated_blur.map(|blur| BlurEllipse {
                along_px: blur.along_px,
                across_px: blur.across_px,
                direction_deg: blur.direction_rad.to_degrees(),
            }),
            lean_px: detection.sigma_px.map(|_| detection.lean_px),
            marked_squares: detection.marked_squares,
            transfer: None,
        }
    }
}

pub(super) fn polarity_name(polarity: Polarity) -> &'static str {
    match polarity {
        Polarity::Main => "main",
        Polarity::Anti => "anti",
    }
}

pub(super) fn polarity_of(name: &str) -> Option<Polarity> {
    [Polarity::Main, Polarity::Anti].into_iter().find(|&p| polarity_name(p) == name)
}
