//! Numbering: where the columns and rows of a lattice run, and from which corner they count.

use super::detection::{Corner, Detection, Polarity};
use super::lattice_growth::Lattice;
use glam::{DMat2, DVec2, IVec2};

/// A corner that a detector, this or another, has put on a lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatticeCorner {
    /// Column and row in one consistent lattice.
    pub index: [i32; 2],
    /// Position, in px: pixel (i, j) covers `[i, i+1) x [j, j+1)`.
    pub position_px: DVec2,
    /// Which diagonal is bright, where the detector says.
    pub polarity: Option<Polarity>,
    /// Covariance of the position, in px^2, where the detector says.
    pub covariance_px2: Option<DMat2>,
}

impl From<&Corner> for LatticeCorner {
    fn from(corner: &Corner) -> Self {
        Self {
            index: corner.index,
            position_px: corner.position_px,
            polarity: Some(corner.polarity),
            covariance_px2: Some(corner.covariance_px2),
        }
    }
}

/// The lattice as [`detect`](crate::vision::detect) numbers it: +column along +x and +row along +y as nearly as possible, the
/// smallest of each 0. Other programs count rows before columns, or from another corner of the board.
pub fn upright(seen: &[LatticeCorner]) -> Vec<LatticeCorner> {
    let lattice: Lattice = seen.iter().enumerate().map(|(k, corner)| (corner.index, k)).collect();
    let axes = axes(&lattice, |k| seen[k].position_px, UPRIGHT);
    let polarity = |k: usize| Some(axes.polarity(seen[k].polarity?));
    let turned = from_zero(&axes.turned(&lattice));
    turned.into_iter().map(|(index, k)| LatticeCorner { index, polarity: polarity(k), ..seen[k] }).collect()
}

/// A detection numbered like another, of the same board from nearly the same side: with the columns and the rows that run as the
/// other's do, as nearly as a quarter turn brings them. A board that is rolled by 44 deg in one picture and by 46 deg in the other is
/// else a quarter turn apart in the two. The smallest column and row are 0 here as there.
pub fn turned_like(reference: &Detection, other: Detection) -> Detection {
    // Find where the reference's columns and rows run, and the axes of the other that run so.
    let lattice = |seen: &Detection| -> Lattice { seen.corners.iter().map(|c| c.index).zip(0..).collect() };
    let steps = mean_steps(&lattice(reference), |k| reference.corners[k].position_px);
    if reference.corners.is_empty() || other.corners.is_empty() {
        return other;
    }
    let numbered = lattice(&other);
    let axes = axes(&numbered, |k| other.corners[k].position_px, [steps.x_axis, steps.y_axis]);

    // Number it by them.
    let turned = from_zero(&axes.turned(&numbered));
    let corner = |(index, k): ([i32; 2], usize)| {
        let corner = other.corners[k];
        Corner { index, polarity: axes.polarity(corner.polarity), ..corner }
    };
    let corners = turned.into_iter().map(corner).collect();
    // The blurs are those of the column and of the row lines.
    let sigma_px = other.sigma_px.map(|[column, row]| if axes.column.x == 0 { [row, column] } else { [column, row] });
    Detection { corners, sigma_px, ..other }
}

/// Where the columns and rows of an upright lattice run in a lattice.
struct LatticeAxes {
    column: IVec2,
    row: IVec2,
}

impl LatticeAxes {
    fn turned(&self, lattice: &Lattice) -> Lattice {
        let turned = |cell: IVec2| [cell.dot(self.column), cell.dot(self.row)];
        lattice.iter().map(|(&cell, &k)| (turned(IVec2::from_array(cell)), k)).collect()
    }

    /// Which diagonal is bright by these axes.
    fn polarity(&self, by_lattice: Polarity) -> Polarity {
        // Whether the square between +column and +row is one that was beside it.
        let between = self.column + self.row;
        match by_lattice {
            Polarity::Main if between.x != between.y => Polarity::Anti,
            Polarity::Anti if between.x != between.y => Polarity::Main,
            same => same,
        }
    }
}

/// The lattice turned by a multiple of 90 deg (never mirrored) so that +column runs along +x and +row along +y as
/// nearly as possible, from column and row 0.
pub(super) fn normalise(lattice: &Lattice, position: impl Fn(usize) -> DVec2) -> Lattice {
    from_zero(&axes(lattice, position, UPRIGHT).turned(lattice))
}

/// Columns along +x and rows along +y.
const UPRIGHT: [DVec2; 2] = [DVec2::X, DVec2::Y];

/// The sums of the steps along the columns' and the rows' direction, in px.
fn mean_steps(lattice: &Lattice, position: impl Fn(usize) -> DVec2) -> DMat2 {
    let mean_step = |direction: IVec2| {
        lattice
            .iter()
            .filter_map(|(&cell, &k)| {
                let next = lattice.get(&(IVec2::from_array(cell) + direction).to_array())?;
                Some(position(*next) - position(k))
            })
            .sum::<DVec2>()
    };
    DMat2::from_cols(mean_step(IVec2::X), mean_step(IVec2::Y))
}

/// The axes that agree most with two directions in the picture.
fn axes(lattice: &Lattice, position: impl Fn(usize) -> DVec2, wanted: [DVec2; 2]) -> LatticeAxes {
    let steps = mean_steps(lattice, position);
    let wanted = wanted.map(DVec2::normalize_or_zero);
    let handed = if steps.determinant() < 0.0 { -1 } else { 1 };
    // The image of +column and +row under each of the four turns; the best agrees most with what is wanted.
    let turns = [IVec2::X, IVec2::Y, IVec2::NEG_X, IVec2::NEG_Y].map(|column| {
        let row = IVec2::new(-column.y, column.x) * handed;
        let along = |axis: IVec2| (steps * axis.as_dvec2()).normalize_or_zero();
        (column, row, along(column).dot(wanted[0]) + along(row).dot(wanted[1]))
    });
    let (column, row, _) = turns.into_iter().fold(turns[0], |best, turn| if turn.2 > best.2 { turn } else { best });
    LatticeAxes { column, row }
}

/// The lattice moved so that its smallest column and row are 0.
pub(super) fn from_zero(lattice: &Lattice) -> Lattice {
    let least = |axis: usize| lattice.keys().map(|cell| cell[axis]).min().unwrap_or(0);
    let first = [least(0), least(1)];
    lattice.iter().map(|(&[i, j], &k)| ([i - first[0], j - first[1]], k)).collect()
}
