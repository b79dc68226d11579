//! By how much edges lie towards dark.

/// Light that is clipped and a wrong transfer curve shift every edge by the same; ink that spreads, by a share of the square where
/// squares keep their share of the picture, and so by less where the board is farther away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Lean {
    /// By so many px everywhere.
    Even(f64),
    /// By this share of the distance between the lines there.
    OfSquare(f64),
}

impl Lean {
    pub(super) const NONE: Self = Self::Even(0.0);

    pub(super) fn is_none(self) -> bool {
        self == Self::NONE
    }

    /// Another one of the same form.
    pub(super) fn of(self, value: f64) -> Self {
        match self {
            Self::Even(_) => Self::Even(value),
            Self::OfSquare(_) => Self::OfSquare(value),
        }
    }

    /// The px or the share.
    pub(super) fn value(self) -> f64 {
        let (Self::Even(value) | Self::OfSquare(value)) = self;
        value
    }

    /// In px, at an edge whose next parallel lines are so far away.
    pub(super) fn at(self, spacing_px: f64) -> f64 {
        match self {
            Self::Even(px) => px,
            Self::OfSquare(share) => share * spacing_px,
        }
    }
}
