//! Corners that another program found, or that were kept in a file, as what a detector says of each half.

use super::half_image::HalfFrame;
use super::view::DetectedLattice;
use crate::error::Error;
use crate::io::corners::{CornerView, ListedCorner};
use crate::system::System;
use crate::vision::half::Half;
use crate::vision::{LatticeCorner, upright};
use std::collections::BTreeSet;
use std::fmt::Display;

/// The corners that a file lists, in the px of the halves that they must lie in; `file` is its name in errors.
///
/// # Errors
/// A view that is neither left nor right, a corner outside its half, two corners of one index, indices that no board of this size has, and
/// a covariance that is none.
pub fn lattices(file: &dyn Display, system: &System, views: &[CornerView]) -> Result<[DetectedLattice; 2], Error> {
    let known = |view: &CornerView| Half::BOTH.iter().any(|half| half.name() == view.name);
    if let Some(view) = views.iter().find(|view| !known(view)) {
        let rule = format!("it has corners of a view {:?}, and must have those of left and right", view.name);
        return Err(Error::new(file, rule, "detect in each half of the picture by itself"));
    }
    let [left, right] = Half::BOTH.map(|half| {
        let Some(view) = views.iter().find(|view| view.name == half.name()) else {
            return Ok(DetectedLattice::default());
        };
        let frame = HalfFrame::new(system, half);
        if let Some(stray) = view.corners.iter().find(|c| !frame.contains(frame.own(c.position_px))) {
            let (low, high) = (frame.first_column, frame.full(frame.size_px));
            let rule = format!(
                "corner ({}, {}) of the {} half lies at {}, and must lie in columns {low} to {} and rows 0 to {}",
                stray.index[0],
                stray.index[1],
                half.name(),
                stray.position_px,
                high.x,
                high.y
            );
            let help = "give positions in px of the whole picture, of the size that the scene says";
            return Err(Error::new(file, rule, help));
        }
        corners_of_one_board(file, system, half, &view.corners)?;
        let seen = |c: &ListedCorner| LatticeCorner {
            index: c.index,
            position_px: frame.own(c.position_px),
            polarity: c.quality.map(|q| q.polarity),
            covariance_px2: c.quality.map(|q| q.covariance_px2),
        };
        Ok(DetectedLattice {
            corners: upright(&view.corners.iter().map(seen).collect::<Vec<_>>()),
            rejected: view.rejected.iter().cloned().collect(),
            blur_px: view.blur_px,
        })
    });
    Ok([left?, right?])
}

/// Refuses corners of a half that cannot be those of one board.
fn corners_of_one_board(
    file: &dyn Display,
    system: &System,
    half: Half,
    corners: &[ListedCorner],
) -> Result<(), Error> {
    let problem = |[column, row]: [i32; 2], what: String| {
        let rule = format!("corner ({column}, {row}) of the {} half {what}", half.name());
        Err(Error::new(file, rule, "give each corner of the board once, with its column and row"))
    };

    // Each index once, and all within a board.
    let inner = system.board().inner_corners();
    let mut known = BTreeSet::new();
    let lowest = [0, 1].map(|axis| corners.iter().map(|c| c.index[axis]).min().unwrap_or(0));
    for ListedCorner { index, quality, .. } in corners {
        if !known.insert(*index) {
            return problem(*index, "is there twice".to_owned());
        }
        // Indices count from anywhere, and columns may be rows.
        let beyond = [0, 1]
            .iter()
            .any(|axis| i64::from(index[*axis]) - i64::from(lowest[*axis]) >= inner[0].max(inner[1]) as i64);
        if beyond {
            let [columns, rows] = inner;
            return problem(
                *index,
                format!(
                    "is farther from ({}, {}) than a board of {columns} x {rows} corners has any",
                    lowest[0], lowest[1]
                ),
            );
        }

        // A covariance is symmetric and positive.
        if let Some(quality) = quality {
            let [a, b] = [quality.covariance_px2.x_axis, quality.covariance_px2.y_axis];
            if !(a.x > 0.0 && b.y > 0.0 && a.x * b.y >= a.y * b.x && (a.x + b.y).is_finite()) {
                return problem(*index, format!("has the covariance {a}, {b} px^2, which is none"));
            }
        }
    }
    Ok(())
}
