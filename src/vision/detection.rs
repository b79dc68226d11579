//! The detector's result: corners, and rejected candidates with the reason.

use glam::{DMat2, DVec2};

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

/// A blur that is longer one way than across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElongatedBlur {
    /// The largest standard deviation, in px.
    pub along_px: f64,
    /// The one across that direction, in px.
    pub across_px: f64,
    /// Where it is largest, from +x towards +y (down), in rad, in `[-pi/2, pi/2]`.
    pub direction_rad: f64,
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
    /// Its contrast is far below what the corners beside it lead to.
    LowContrast,
    /// The fit ended at another place.
    Moved,
    /// It makes a kink in its grid lines, or hangs on the grid by a single neighbour though the places beside it are in sight.
    OffLattice,
    /// The picture there is far less like two crossing edges than around it: hidden in part, a seam runs through it, or the board's rim
    /// meets an edge behind it.
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
    /// The blur as an ellipse, where it is clearly longer than wide: motion, or astigmatism.
    pub elongated_blur: Option<ElongatedBlur>,
    /// By how many px every edge lies towards its dark side, as its lattice lines show it; below 0: towards the bright one,
    /// and 0 where they show none. A corner stays where it is; what does this is light that is clipped, ink that spread, or
    /// another transfer curve than the picture's.
    pub lean_px: f64,
    /// Whether the squares of one colour hold marks, as those of a ChArUco board do: what is away from the edges was then left out
    /// of the fits, and [`Self::lean_px`] is that of the marks' borders.
    pub marked_squares: bool,
}

impl Detection {
    /// That no board was found.
    pub(super) fn none(rejected: Vec<Rejected>) -> Self {
        Self {
            corners: Vec::new(),
            rejected,
            sigma_px: None,
            elongated_blur: None,
            lean_px: 0.0,
            marked_squares: false,
        }
    }

    /// How many candidates were rejected for each reason, in the order of [`Reason::ALL`].
    pub fn counts(&self) -> [(Reason, usize); 10] {
        Reason::ALL.map(|reason| (reason, self.rejected.iter().filter(|r| r.reason == reason).count()))
    }
}
