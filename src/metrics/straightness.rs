//! Rows and columns of a board: straight in the world, so straight in any pinhole's image, wherever the board stands.

use super::deviation::{Unmeasurable, all_finite, at_least};
use super::line::Line;
use glam::DVec2;
use std::collections::BTreeMap;

/// A board corner in one half image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IndexedCorner {
    /// Column and row on the board.
    pub index: [i32; 2],
    /// Position, in px.
    pub image_px: DVec2,
}

/// Which line a row is held against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StraightnessReference {
    /// The chord of the row's first and last corner; distances of the corners between (ROS `linear_error`).
    Chord,
    /// The line of total least squares; distances of all corners. Less at the mercy of two corners' noise.
    TotalLeastSquares,
}

/// How straight the lines of a board are. Frame: raw half image, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Straightness {
    /// Lines with 3 corners or more.
    pub lines: usize,
    /// N, the count of distances.
    pub n: usize,
    /// sqrt(sum d^2 / N), in px.
    pub rms_px: f64,
    /// Largest |d|, in px.
    pub max_px: f64,
}

/// Straightness of rows, of columns, and of both together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowsAndColumns {
    /// Lines of one row index: the only ones that ROS takes.
    pub rows: Straightness,
    /// Lines of one column index.
    pub columns: Straightness,
    /// All of them, each distance with the same weight.
    pub both: Straightness,
}

/// Straightness of the rows and columns of a board. Corners may be missing; a line needs 3.
///
/// # Errors
/// [`Unmeasurable::TooFew`] when no row, or no column, has 3 corners, [`Unmeasurable::NotFinite`],
/// [`Unmeasurable::Degenerate`] when the corners of a line coincide.
pub fn straightness(
    corners: &[IndexedCorner],
    reference: StraightnessReference,
) -> Result<RowsAndColumns, Unmeasurable> {
    all_finite("corner", corners, |c| c.image_px.is_finite())?;
    let rows = distances(corners, 1, reference)?;
    let columns = distances(corners, 0, reference)?;
    let both = [rows.as_slice(), columns.as_slice()].concat();
    Ok(RowsAndColumns {
        rows: sizes(&rows, "rows of 3 corners")?,
        columns: sizes(&columns, "columns of 3 corners")?,
        both: sizes(&both, "lines of 3 corners")?,
    })
}

/// The distances of each line's corners; lines are the corners that share `index[fixed]`.
fn distances(
    corners: &[IndexedCorner],
    fixed: usize,
    reference: StraightnessReference,
) -> Result<Vec<Vec<f64>>, Unmeasurable> {
    let mut lines: BTreeMap<i32, BTreeMap<i32, DVec2>> = BTreeMap::new();
    for c in corners {
        lines.entry(c.index[fixed]).or_default().insert(c.index[1 - fixed], c.image_px);
    }
    let of_line = |line: BTreeMap<i32, DVec2>| {
        let points: Vec<DVec2> = line.into_values().collect();
        let inner = 1..points.len() - 1;
        let (line, judged) = match reference {
            StraightnessReference::Chord => (Line::chord(points[0], points[inner.end])?, &points[inner]),
            StraightnessReference::TotalLeastSquares => (Line::through(&points)?, &points[..]),
        };
        Ok(judged.iter().map(|p| line.distance(*p)).collect())
    };
    lines.into_values().filter(|line| line.len() >= 3).map(of_line).collect()
}

fn sizes(lines: &[Vec<f64>], what: &'static str) -> Result<Straightness, Unmeasurable> {
    at_least(what, lines.len(), 1)?;
    let all: Vec<f64> = lines.iter().flatten().copied().collect();
    let (rms_px, max_px) = (crate::num::stats::rms(&all), crate::num::stats::max_abs(&all));
    Ok(Straightness { lines: lines.len(), n: all.len(), rms_px, max_px })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn board(map: impl Fn(f64, f64) -> DVec2) -> Vec<IndexedCorner> {
        let indices = (0..7).flat_map(|j| (0..9).map(move |i| [i, j]));
        indices.map(|index| IndexedCorner { index, image_px: map(f64::from(index[0]), f64::from(index[1])) }).collect()
    }

    #[test]
    fn a_homography_keeps_lines_straight() {
        let view = board(|x, y| DVec2::new(3.0 * x + y, 5.0 * y - x + 2.0) * 40.0 / (1.0 + 0.02 * x - 0.01 * y));
        for reference in [StraightnessReference::Chord, StraightnessReference::TotalLeastSquares] {
            let s = straightness(&view, reference).unwrap();
            assert!(s.both.max_px < 1e-11, "{s:?}");
            assert_eq!((s.rows.lines, s.columns.lines, s.both.lines), (7, 9, 16));
        }
    }

    #[test]
    fn bent_rows_have_their_closed_form() {
        // y bends by x (8 - x) / 16: rows are parabolas of sagitta 1 px about their chord; columns stay straight.
        let view = board(|x, y| DVec2::new(50.0 * x, 50.0 * y + x * (8.0 - x) / 16.0));
        let s = straightness(&view, StraightnessReference::Chord).unwrap();
        let sagitta: Vec<f64> = (1..8).map(|x| f64::from(x * (8 - x)) / 16.0).collect();
        assert_eq!((s.rows.n, s.columns.n, s.both.n), (49, 45, 94));
        assert!((s.rows.rms_px - crate::num::stats::rms(&sagitta)).abs() < 1e-12);
        assert!((s.rows.max_px - 1.0).abs() < 1e-12 && s.columns.max_px < 1e-12);
        assert!((s.both.rms_px - s.rows.rms_px * (49.0f64 / 94.0).sqrt()).abs() < 1e-12);
        let t = straightness(&view, StraightnessReference::TotalLeastSquares).unwrap();
        assert_eq!(t.rows.n, 63);
        assert!(t.rows.rms_px < s.rows.rms_px);
    }

    #[test]
    fn short_lines_are_left_out_and_none_is_a_reason() {
        let view = board(|x, y| DVec2::new(10.0 * x, 10.0 * y));
        let gap: Vec<_> = view.iter().copied().filter(|c| c.index[1] != 2 || c.index[0] < 2).collect();
        assert_eq!(straightness(&gap, StraightnessReference::Chord).unwrap().rows.lines, 6);
        let row: Vec<_> = view.iter().copied().filter(|c| c.index[1] == 0).collect();
        let reason = straightness(&row, StraightnessReference::Chord);
        assert_eq!(reason, Err(Unmeasurable::TooFew { what: "columns of 3 corners", found: 0, needed: 1 }));
        assert!(matches!(straightness(&[], StraightnessReference::Chord), Err(Unmeasurable::TooFew { found: 0, .. })));
        let coincident = board(|_, _| DVec2::ONE);
        assert!(matches!(straightness(&coincident, StraightnessReference::Chord), Err(Unmeasurable::Degenerate(_))));
        let mut bad = view;
        bad[3].image_px.x = f64::NAN;
        let reason = straightness(&bad, StraightnessReference::Chord);
        assert_eq!(reason, Err(Unmeasurable::NotFinite { what: "corner", index: 3 }));
    }

    proptest! {
        #[test]
        fn moving_turning_and_renumbering_the_image_changes_nothing(
            shift in (-1e4..1e4, -1e4..1e4), angle in -3.2..3.2, offset in -50..50i32,
        ) {
            let bent = |x: f64, y: f64| DVec2::new(50.0 * x + 0.1 * y * y, 50.0 * y + 0.05 * x * x);
            let (sin, cos) = libm::sincos(angle);
            let moved = board(|x, y| DVec2::new(cos, sin).rotate(bent(x, y)) + DVec2::from(shift));
            let moved: Vec<_> = moved.into_iter()
                .map(|c| IndexedCorner { index: [c.index[0] + offset, c.index[1] - offset], ..c }).rev().collect();
            for reference in [StraightnessReference::Chord, StraightnessReference::TotalLeastSquares] {
                let a = straightness(&board(bent), reference).unwrap().both;
                let b = straightness(&moved, reference).unwrap().both;
                prop_assert!((a.rms_px - b.rms_px).abs() < 1e-9 && (a.max_px - b.max_px).abs() < 1e-9);
            }
        }
    }
}
