//! The causes for which a pair of half images has no figure: each by its own name, with what to do.

use crate::optics::fate::Fate;

/// Why no corner of the board could be paired between the left and the right half. The first that holds, in this order.
#[derive(Debug, Clone, PartialEq)]
pub enum NotJudged {
    /// All squares have one radiance.
    NoContrast,
    /// Most rays of a half end, in this way.
    RaysEnd(&'static str, Fate),
    /// Corners were found in both halves, and no shift by whole squares takes one lattice to the other: the nearest is off by
    /// so many squares, where there is one.
    NotMatched(Option<f64>),
    /// A half sees none of the board's inner corners.
    BoardOutside(&'static str),
    /// Each half sees corners, and no corner is in both.
    NothingInCommon,
    /// The squares of a half are narrower than this, in px, and the detector needs [`LEAST_SQUARE_PX`].
    SquaresTooSmall(&'static str, f64),
    /// A half shows so many corners, and the detector needs a grid of [`LEAST_CORNERS`].
    TooFewCorners(&'static str, usize),
    /// The detector found no lattice in a half.
    NoneFound(&'static str),
    /// The detector found no lattice in either half.
    NoneInEither,
    /// The detector found a lattice of so many corners in a half of an own picture, whose place on the board is not known.
    NotPlaced(&'static str, usize),
    /// Corners were found and placed in both halves, and none is the same.
    NonePaired,
}

/// Lines of the board must be this far apart for the detector, in px.
pub const LEAST_SQUARE_PX: f64 = 10.0;
/// The detector's smallest grid: three columns and three rows.
pub const LEAST_CORNERS: usize = 9;

impl NotJudged {
    /// The name in reports.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::NoContrast => "no-contrast",
            Self::RaysEnd(..) => "rays-end",
            Self::NotMatched(_) => "not-matched",
            Self::BoardOutside(_) => "board-outside",
            Self::NothingInCommon => "nothing-in-common",
            Self::SquaresTooSmall(..) => "squares-too-small",
            Self::TooFewCorners(..) => "too-few-corners",
            Self::NoneFound(_) => "none-found",
            Self::NoneInEither => "none-in-either",
            Self::NotPlaced(..) => "not-placed",
            Self::NonePaired => "none-paired",
        }
    }
}

impl std::fmt::Display for NotJudged {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoContrast => write!(
                f,
                "the board's squares have one radiance, and no corner can be seen: give `board.black` and `board.white` \
                 different values"
            ),
            Self::RaysEnd(half, fate) => write!(
                f,
                "most rays of the {half} half never see the board ({}): `biprism check` tells where they end",
                fate.name()
            ),
            Self::NotMatched(doubt) => {
                write!(f, "the corners of the two halves are not matched")?;
                match doubt {
                    Some(squares) => write!(
                        f,
                        ": the scene's prism and camera put those of one {squares:.2} squares beside those of the other, which \
                         is between two shifts"
                    )?,
                    None => write!(f, ": nothing tells by how many squares one lattice is shifted against the other")?,
                }
                write!(
                    f,
                    "; show the whole board in both halves, or correct `board.square_mm`, `[prism]` and `[camera]`"
                )
            }
            Self::BoardOutside(half) => write!(
                f,
                "the {half} half sees no inner corner of the board: move the board, or give it more or larger squares"
            ),
            Self::NothingInCommon => write!(
                f,
                "the left and the right half see different parts of the board: move it farther away, or make it larger"
            ),
            Self::SquaresTooSmall(half, px) => write!(
                f,
                "the squares are {px:.1} px wide in the {half} half, and the detector needs {LEAST_SQUARE_PX}: make them larger"
            ),
            Self::TooFewCorners(half, n) => write!(
                f,
                "the {half} half shows {n} corners that make no grid of three columns and three rows, {LEAST_CORNERS} corners, \
                 which the detector needs: move the board, or give it more or smaller squares"
            ),
            Self::NoneFound(half) => write!(
                f,
                "the detector found no checkerboard in the {half} half: look at the picture, whether it is in focus, and whether \
                 the scene is the picture's own; `biprism corners` tells what was turned down"
            ),
            Self::NoneInEither => write!(
                f,
                "the detector found no checkerboard in either half: look at the picture, whether it is in focus, and whether the \
                 scene is the picture's own; `biprism corners` tells what was turned down"
            ),
            Self::NotPlaced(half, n) => write!(
                f,
                "the detector found {n} corners in the {half} half, and the scene does not tell which corners of the board \
                 they are: its board must be where the picture's is, to 0.3 of a square"
            ),
            Self::NonePaired => write!(
                f,
                "corners were found in both halves, and none is the same corner of the board: `biprism corners` shows which"
            ),
        }
    }
}
