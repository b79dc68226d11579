//! The measuring eye: a picture in, corners out. It knows nothing of the simulator, so it works on a photograph too.
//!
//! ```text
//! picture --response: saddle maxima--> peaks --ring: bright, dark, bright, dark--> candidates --grid: growth--> lattice
//!   --measure: blur, first fit, pruning, last fit--> corners, each with its covariance
//! ```
//!
//! Each corner is fitted with the model that a camera's pixels obey: two edges, bent as the grid says, under a Gaussian
//! blur and a square pixel, with light that varies linearly (`refine`). Without noise it errs by less than 0.001 px;
//! with noise it reaches the Cramer-Rao bound, and its covariance says so.
//!
//! # What counts as sufficiently visible
//! A corner is looked for where the ring of 4.5 px around it lies in the picture and outside every mask, and where at
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
mod crossing;
mod curvature;
mod equations;
mod gauss;
mod grid;
pub mod half;
mod measure;
mod place;
mod profile;
mod refine;
mod response;
mod ring;
mod sight;
mod strip;
mod window;

use crate::raster::Raster;
use glam::{DMat2, DVec2};

pub use grid::{Lattices, Seen, grow, upright};
pub use measure::measure;
pub use sight::{Sight, look};

/// The least visible share of a corner's window.
pub const LEAST_VISIBLE: f64 = 0.5;

/// How the blur of the picture is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Blur {
    /// One blur across each family of lines, estimated from the picture: right for most pictures.
    Common,
    /// A Gaussian of this standard deviation, in px; 0 is a picture that only the pixel's square has smoothed.
    Known(f64),
    /// Each corner has its own: for a blur that changes over the picture. The slowest.
    PerCorner,
}

/// Where light that is not even becomes so.
///
/// The blur takes light from the brighter side: on the board it moves every corner by its variance times the relative
/// change of the light a px (a blur of 1 px, and light that falls by 40 % over 500 px: 0.0008 px), and the fit takes that
/// back. A picture does not tell which it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Light {
    /// The board is lit unevenly.
    OnBoard,
    /// The lens or the sensor darkens a part of the picture that is already blurred: vignetting.
    InCamera,
}

/// The choices of [`detect`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Half the window of a corner as a share of the step to its neighbours, in 0.1..=0.5. A larger one is less noisy;
    /// above 0.5 neighbours would share pixels and their errors.
    pub window: f64,
    /// The blur.
    pub blur: Blur,
    /// Where the light varies.
    pub light: Light,
    /// A grid has at least so many corners; also at least three columns and three rows.
    pub min_corners: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { window: 0.45, blur: Blur::Common, light: Light::OnBoard, min_corners: 9 }
    }
}

/// Which diagonal of a corner is bright.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polarity {
    /// The square between +column and +row is bright, and the one opposite.
    Main,
    /// The other two squares are bright.
    Anti,
}

/// A measured corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Position, in px: pixel (i, j) covers `[i, i+1) x [j, j+1)`.
    pub position_px: DVec2,
    /// Column and row in one consistent lattice: +column runs along +x and +row along +y as nearly as possible (the
    /// lattice is turned, never mirrored), and the smallest of each is 0.
    pub index: [i32; 2],
    /// Covariance of the position, in px^2, from the fit's residual.
    pub covariance_px2: DMat2,
    /// Bright minus dark, in the unit of the picture.
    pub contrast: f64,
    /// Root mean square difference between picture and model over the window, in the unit of the picture.
    pub residual: f64,
    /// Which diagonal is bright.
    pub polarity: Polarity,
}

/// Why a candidate is not a corner of the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// The picture around it does not alternate bright, dark, bright, dark.
    Ring,
    /// It has no place in a grid of sufficient size.
    NoGrid,
    /// It belongs to a smaller grid than the one that is answered.
    OtherGrid,
    /// Less than its ring or half its window lies in the picture and outside the mask.
    Cut,
    /// The next lines are nearer than six blurs, and blur into its window.
    Blurred,
    /// Its contrast is far below that of the grid.
    LowContrast,
    /// The fit ended at another place.
    Moved,
    /// It makes a kink in its grid lines.
    OffLattice,
    /// The picture there is unlike two crossing edges: hidden in part, or a seam runs through it.
    Residual,
    /// The fit came to no end.
    NotConverged,
}

impl Reason {
    /// Every reason.
    pub const ALL: [Self; 10] = [
        Self::Ring,
        Self::NoGrid,
        Self::OtherGrid,
        Self::Cut,
        Self::Blurred,
        Self::LowContrast,
        Self::Moved,
        Self::OffLattice,
        Self::Residual,
        Self::NotConverged,
    ];

    /// The name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ring => "ring",
            Self::NoGrid => "no-grid",
            Self::OtherGrid => "other-grid",
            Self::Cut => "cut",
            Self::Blurred => "blurred",
            Self::LowContrast => "low-contrast",
            Self::Moved => "moved",
            Self::OffLattice => "off-lattice",
            Self::Residual => "residual",
            Self::NotConverged => "not-converged",
        }
    }
}

/// A candidate that is not in the answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rejected {
    /// Where it was last seen, in px.
    pub position_px: DVec2,
    /// Why.
    pub reason: Reason,
}

/// What was found in a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// The corners of the largest grid, by column, then by row. Empty where there is no grid.
    pub corners: Vec<Corner>,
    /// Every other candidate, with its reason.
    pub rejected: Vec<Rejected>,
    /// The standard deviation of the blur across the column lines' and the row lines' edges, in px; 0 is sharp. `None`
    /// where there is no grid.
    pub sigma_px: Option<[f64; 2]>,
}

impl Detection {
    /// How many candidates were rejected for each reason, in the order of [`Reason::ALL`].
    pub fn counts(&self) -> [(Reason, usize); 10] {
        Reason::ALL.map(|reason| (reason, self.rejected.iter().filter(|r| r.reason == reason).count()))
    }
}

/// Finds and measures the corners of the largest checkerboard in a picture of linear radiance.
///
/// Pixels where `mask` is false or whose value is not finite do not count. The answer is the same, bit for bit, for any
/// number of threads. Any picture is taken: where there is no board the answer is empty. It is [`look()`], [`grow()`] and
/// [`measure()`] in turn.
///
/// # Panics
/// When the mask has another size than the picture.
pub fn detect(image: &Raster<f32>, mask: Option<&Raster<bool>>, settings: &Settings) -> Detection {
    let sight = look(image, mask);
    let lattices = grow(&sight, settings);
    measure(&sight, lattices, settings)
}
