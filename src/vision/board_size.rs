//! A board of a known size: which of the lattices of a picture is it, and which part of the lattice.

use super::detection::{Corner, Detection};
use glam::{IVec2, Vec2Swizzles};

/// Columns and rows of a board's inner corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardSize {
    /// Corners along a row.
    pub columns: i32,
    /// Corners along a column.
    pub rows: i32,
}

impl BoardSize {
    /// A lattice has at least three columns and three rows; no picture shows more than so many.
    pub const LIMITS: [i32; 2] = [3, 1000];

    fn as_vector(self) -> IVec2 {
        IVec2::new(self.columns, self.rows)
    }
}

/// A detection cut to a board's size.
#[derive(Debug, Clone, PartialEq)]
pub struct SizedBoard {
    /// The corners that fit, numbered from column and row 0.
    pub board: Detection,
    /// How many did not.
    pub left_out: usize,
    /// Columns and rows over which the lattice reached.
    pub reached: BoardSize,
}

impl SizedBoard {
    /// Whether the lattice reached over the board's columns and rows, upright or on its side.
    pub fn is_whole(&self, size: BoardSize) -> bool {
        self.reached == size || self.reached == BoardSize { columns: size.rows, rows: size.columns }
    }
}

/// Of the boards of a picture, the one that a board of a known size is most likely: with most corners in a frame of that size,
/// upright or on its side, less those that it leaves out. `None` where there are no boards.
pub fn board_of_size(boards: Vec<Detection>, size: BoardSize) -> Option<SizedBoard> {
    let cut = boards.into_iter().map(|board| cut(board, size));
    cut.reduce(|best, other| if merit(&other) > merit(&best) { other } else { best })
}

fn merit(fitted: &SizedBoard) -> i64 {
    fitted.board.corners.len() as i64 - fitted.left_out as i64
}

/// The part of a lattice that fits: in the frame of that size that holds most corners.
fn cut(board: Detection, size: BoardSize) -> SizedBoard {
    // Find over how many columns and rows the lattice reaches; its smallest are 0.
    let index = |c: &Corner| IVec2::from_array(c.index);
    let last = board.corners.iter().map(index).fold(IVec2::NEG_ONE, IVec2::max);
    let reached = BoardSize { columns: last.x + 1, rows: last.y + 1 };

    // Find the place of the frame with most corners, upright or on its side; of equal ones the first stays.
    let mut best = ([IVec2::ZERO, size.as_vector()], 0);
    for frame in [size.as_vector(), size.as_vector().yx()] {
        for x in 0..=(last.x + 1 - frame.x).max(0) {
            // Count the corners of each row in these columns, and slide the frame along the rows.
            let mut rows = vec![0; usize::try_from(last.y + 1).unwrap_or(0)];
            let columns = x..x + frame.x;
            board.corners.iter().filter(|c| columns.contains(&c.index[0])).for_each(|c| rows[c.index[1] as usize] += 1);
            for y in 0..=(last.y + 1 - frame.y).max(0) {
                let count: usize = rows.iter().skip(y as usize).take(frame.y as usize).sum();
                if count > best.1 {
                    best = ([IVec2::new(x, y), frame], count);
                }
            }
        }
    }

    // Keep what lies in it, numbered from 0.
    let [low, frame] = best.0;
    let inside = |c: &&Corner| (index(c) - low).cmpge(IVec2::ZERO).all() && (index(c) - low).cmplt(frame).all();
    let kept: Vec<Corner> = board.corners.iter().filter(inside).copied().collect();
    let first = kept.iter().map(index).fold(IVec2::MAX, IVec2::min);
    let left_out = board.corners.len() - kept.len();
    let corners = kept.into_iter().map(|c| Corner { index: (index(&c) - first).to_array(), ..c }).collect();
    SizedBoard { board: Detection { corners, ..board }, left_out, reached }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::Polarity;
    use glam::{DMat2, DVec2};

    fn board(cells: impl Iterator<Item = [i32; 2]>) -> Detection {
        let corner = |index: [i32; 2]| Corner {
            index,
            position_px: DVec2::from_array(index.map(f64::from)),
            covariance_px2: DMat2::IDENTITY,
            contrast: 1.0,
            residual: 0.0,
            polarity: Polarity::Main,
        };
        Detection { corners: cells.map(corner).collect(), ..Detection::none(Vec::new()) }
    }

    fn grid(columns: i32, rows: i32) -> impl Iterator<Item = [i32; 2]> {
        (0..columns).flat_map(move |i| (0..rows).map(move |j| [i, j]))
    }

    const SIZE: BoardSize = BoardSize { columns: 4, rows: 3 };

    #[test]
    fn a_row_too_many_is_left_out_and_the_rest_counts_from_zero() {
        // Two crossings above the board, one beside it; the board stands on its side.
        let with_more = grid(3, 4).map(|[i, j]| [i, j + 1]).chain([[0, 0], [1, 0], [3, 2]]);
        let fitted = board_of_size(vec![board(with_more)], SIZE).unwrap();
        assert_eq!((fitted.left_out, fitted.reached), (3, BoardSize { columns: 4, rows: 5 }));
        assert!(fitted.board.corners.iter().map(|c| c.index).eq(grid(3, 4)));
        assert!(!fitted.is_whole(SIZE));
        // A part of a board is left as it is.
        let part = board_of_size(vec![board(grid(3, 3))], SIZE).unwrap();
        assert_eq!((part.left_out, part.board), (0, board(grid(3, 3))));
    }

    #[test]
    fn the_board_of_that_size_is_taken_though_another_is_larger() {
        let boards = vec![board(grid(9, 7)), board(grid(3, 4)), board(grid(3, 3))];
        let fitted = board_of_size(boards, SIZE).unwrap();
        assert!(fitted.is_whole(SIZE) && fitted.left_out == 0);
        assert_eq!(fitted.board, board(grid(3, 4)));
        assert_eq!(board_of_size(Vec::new(), SIZE), None);
    }
}
