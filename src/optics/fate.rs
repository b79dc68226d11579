//! Ray fates: how a ray can end before it reaches the board.

/// Why a ray carries no light from the board. A ray that ends is data: counted, reported, and a map in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// It met no facet, or no base, inside the region where the surface is given.
    Missed,
    /// It met a surface beyond the critical angle.
    TotalReflection,
    /// The surface solver did not reach its residual: the ray is given up rather than guessed.
    NotConverged,
    /// It left the prism and never meets the plane of the board.
    PastBoard,
    /// It met the rim of the glass, a ridge that is not sharp, or a stop.
    Clipped,
}

impl Fate {
    /// All fates, in the order of their codes.
    pub const ALL: [Self; 5] =
        [Self::Missed, Self::TotalReflection, Self::NotConverged, Self::PastBoard, Self::Clipped];

    /// The name used in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Missed => "missed",
            Self::TotalReflection => "total_reflection",
            Self::NotConverged => "not_converged",
            Self::PastBoard => "past_board",
            Self::Clipped => "clipped",
        }
    }
}
