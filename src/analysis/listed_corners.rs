//! Corners that another program found, or that were kept in a file, as what a detector says of each half.

use super::half_image::HalfFrame;
use super::view::DetectedLattice;
use crate::error::Error;
use crate::io::corners::{CornerView, ListedCorner};
use crate::system::System;
use crate::vision::half::Half;
use crate::vision::{LatticeCorner, upright};
use std::fmt::Display;

/// The corners that a file lists, in the px of the halves that they must lie in; `file` is its name in errors.
///
/// # Errors
/// A view that is neither left nor right, and a corner outside its half.
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
