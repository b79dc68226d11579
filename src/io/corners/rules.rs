//! The rules that corner files keep in every format.

use super::view::CornerView;
use crate::error::Error;
use std::collections::BTreeSet;

/// Corners in a file at most.
pub const MOST_CORNERS: usize = 1_000_000;
/// Views in a file at most: a search among them stays cheap.
pub(super) const MOST_VIEWS: usize = 16;
/// Columns and rows are within this of 0.
pub const MOST_INDEX: i32 = 1_000_000;
/// Bytes in a file at most.
pub const MOST_BYTES: u64 = 1 << 28;
/// How a file of ours says where a pixel's centre lies.
pub(super) const CENTRE: &str = "(i + 0.5, j + 0.5)";
/// How a file of OpenCV's convention says it.
pub(super) const OPENCV_CENTRE: &str = "(i, j)";

/// The rules that hold in every format.
pub(super) fn check(views: &[CornerView], place: &str) -> Result<(), Error> {
    let mut names = BTreeSet::new();
    for view in views {
        let name = &view.name;
        if name.is_empty() || !name.bytes().all(|b| b.is_ascii_lowercase()) {
            return Err(broken(place, format!("a view is named {name:?}, and must be named in letters a to z")));
        }
        if !names.insert(name) {
            return Err(broken(place, format!("the view {name:?} is there twice, and must be there once")));
        }
        let mut indices = BTreeSet::new();
        for corner in &view.corners {
            let [i, j] = corner.index;
            let at = format!("corner ({i}, {j}) of the view {name:?}");
            if !indices.insert(corner.index) {
                return Err(broken(place, format!("{at} is there twice, and must be there once")));
            }
            if corner.index.iter().any(|i| i.unsigned_abs() > MOST_INDEX.unsigned_abs()) {
                return Err(broken(place, format!("{at} must have a column and a row within {MOST_INDEX} of 0")));
            }
            if !corner.position_px.is_finite() {
                return Err(broken(place, format!("{at} lies at {}, and must lie at finite px", corner.position_px)));
            }
            let Some(quality) = &corner.quality else { continue };
            let v = quality.covariance_px2;
            let variances = v.x_axis.x >= 0.0 && v.y_axis.y >= 0.0;
            // A determinant of 0 may come out slightly below it.
            let positive = variances && v.determinant() >= -1e-12 * v.x_axis.x * v.y_axis.y;
            if !(v.is_finite() && positive && v.x_axis.y == v.y_axis.x) {
                return Err(broken(
                    place,
                    format!("{at} has the covariance {v}, and must have a symmetric, positive one"),
                ));
            }
            if !(quality.contrast.is_finite() && quality.contrast >= 0.0) {
                return Err(broken(
                    place,
                    format!("{at} has the contrast {}, and must have one of 0 or more", quality.contrast),
                ));
            }
            if !(quality.residual.is_finite() && quality.residual >= 0.0) {
                return Err(broken(
                    place,
                    format!("{at} has the residual {}, and must have one of 0 or more", quality.residual),
                ));
            }
        }
    }
    Ok(())
}

/// A file that says how many corners it has must have them: one that was cut between two lines has fewer.
pub(super) fn same_count(stated: Option<usize>, views: &[CornerView], place: &str) -> Result<(), Error> {
    let found: usize = views.iter().map(|v| v.corners.len()).sum();
    match stated.filter(|&count| count != found) {
        None => Ok(()),
        Some(count) => Err(broken(place, format!("it holds {found} corners, and says that it has {count}"))),
    }
}

/// What to do about a file that is broken.
pub(super) const HELP: &str = "mend the file, or write it again with `biprism corners`";

pub(super) fn broken(place: &str, rule: String) -> Error {
    Error::new(place, rule, HELP)
}

pub(super) fn too_many(place: &str) -> Error {
    Error::new(
        place,
        format!("the file holds more than {MOST_CORNERS} corners, the most that are taken"),
        "give the corners of one picture",
    )
}
