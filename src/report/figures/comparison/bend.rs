//! The line that an image bends most of those that a pinhole keeps straight.

use super::corner_mark::CornerMark;
use glam::DVec2;
use std::collections::BTreeMap;

/// Which way a line of corners runs on the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LineDirection {
    /// Corners of one row of the board.
    Row,
    /// Corners of one column of the board.
    Column,
}

/// The name of a line of corners: it is the same in every picture of the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct LineName {
    /// Whether its corners lie in the right half image.
    pub right: bool,
    /// Row or column.
    pub along: LineDirection,
    /// Index of the row or column.
    pub index: i32,
}

impl LineName {
    /// The name in words: "row 3, left half".
    pub fn words(&self) -> String {
        let along = match self.along {
            LineDirection::Row => "row",
            LineDirection::Column => "column",
        };
        format!("{along} {}, {} half", self.index, if self.right { "right" } else { "left" }).replace('-', "−")
    }
}

/// A line of corners and how far it leaves the straight line between its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Bend {
    /// Which line.
    pub line: LineName,
    /// Its corners in their order on the board, in px; at least three.
    pub corners_px: Vec<DVec2>,
    /// The corner that is farthest from the straight line between the end corners, in px.
    pub farthest_px: DVec2,
    /// The point of that straight line nearest to it, in px.
    pub straight_px: DVec2,
}

impl Bend {
    /// Distance of the farthest corner from the straight line between the end corners, in px.
    pub fn size_px(&self) -> f64 {
        self.farthest_px.distance(self.straight_px)
    }

    /// The first and the last corner, in px.
    pub fn ends_px(&self) -> [DVec2; 2] {
        [self.corners_px[0], self.corners_px[self.corners_px.len() - 1]]
    }

    fn of(line: LineName, corners_px: Vec<DVec2>) -> Option<Self> {
        let (first, last) = (*corners_px.first()?, *corners_px.last()?);
        let direction = (last - first).try_normalize()?;
        let on_line = |p: DVec2| first + direction * (p - first).dot(direction);
        let inner = corners_px.get(1..corners_px.len() - 1)?;
        let farthest_px = *inner
            .iter()
            .max_by(|a, b| a.distance_squared(on_line(**a)).total_cmp(&b.distance_squared(on_line(**b))))?;
        Some(Self { line, farthest_px, straight_px: on_line(farthest_px), corners_px })
    }
}

/// Every row and column of at least three corners in either half, with its bend; the halves meet at `seam_px`.
pub fn bends(corners: &[CornerMark], seam_px: f64) -> BTreeMap<LineName, Bend> {
    let mut lines: BTreeMap<LineName, BTreeMap<i32, DVec2>> = BTreeMap::new();
    for corner in corners.iter().filter(|corner| corner.position_px.is_finite()) {
        let right = corner.position_px.x >= seam_px;
        let [column, row] = corner.index;
        for (along, index, order) in [(LineDirection::Row, row, column), (LineDirection::Column, column, row)] {
            lines.entry(LineName { right, along, index }).or_default().insert(order, corner.position_px);
        }
    }
    let bend = |(line, corners): (LineName, BTreeMap<i32, DVec2>)| {
        Some((line, Bend::of(line, corners.into_values().collect())?))
    };
    lines.into_iter().filter_map(bend).collect()
}

/// The line that is bent most; of equals the first by name.
pub fn worst(bends: &BTreeMap<LineName, Bend>) -> Option<&Bend> {
    bends.values().fold(None, |worst: Option<&Bend>, bend| match worst {
        Some(w) if w.size_px() >= bend.size_px() => worst,
        _ => Some(bend),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(column: i32, row: i32, x: f64, y: f64) -> CornerMark {
        CornerMark { index: [column, row], position_px: DVec2::new(x, y), error_px: DVec2::ZERO }
    }

    #[test]
    fn the_sagitta_of_an_arc_is_found_where_it_is() {
        // Column 2 of the left half is an arc y -> 100 + 8 (1 - t^2), t from -1 to 1: its sagitta is 8 at t = 0.
        let mut corners: Vec<CornerMark> = (0..9)
            .flat_map(|row| {
                let t = f64::from(row - 4) / 4.0;
                let y = 40.0 * f64::from(row);
                [mark(2, row, 100.0 + 8.0 * (1.0 - t * t), y), mark(3, row, 140.0, y), mark(2, row, 600.0, y)]
            })
            .collect();
        corners.reverse();
        let all = bends(&corners, 500.0);
        let worst = worst(&all).expect("there are lines");
        assert_eq!(worst.line, LineName { right: false, along: LineDirection::Column, index: 2 });
        assert!((worst.size_px() - 8.0).abs() < 1e-12);
        assert_eq!(worst.farthest_px, DVec2::new(108.0, 160.0));
        assert_eq!(worst.corners_px.len(), 9);
        assert_eq!(worst.line.words(), "column 2, left half");
    }

    #[test]
    fn two_corners_and_what_is_no_number_make_no_line() {
        let corners = [mark(0, 0, 1.0, 1.0), mark(1, 0, 2.0, 1.0), mark(2, 0, f64::NAN, 1.0)];
        assert!(bends(&corners, 100.0).is_empty());
        assert!(worst(&bends(&[], 100.0)).is_none());
        let same = [mark(0, 0, 1.0, 1.0), mark(1, 0, 1.0, 1.0), mark(2, 0, 1.0, 1.0)];
        assert!(bends(&same, 100.0).is_empty());
    }
}
