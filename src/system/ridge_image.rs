//! The image of the ridge: where it crosses rows of the picture, and how far it moves.

use super::instrument::System;
use glam::DVec2;

/// Places stay this far inside the picture, in px.
pub(super) const INSET_PX: f64 = 1e-6;
/// Rows in which the ridge's image is sought.
const ROWS: usize = 5;
/// Halvings of the width when it is sought in a row.
const HALVINGS: usize = 40;

/// Rows of the picture in which the ridge is sought.
pub(super) fn rows(system: &System) -> impl Iterator<Item = f64> + use<> {
    let height = system.camera().size_px()[1] as f64;
    (0..ROWS).map(move |k| (height * k as f64 / (ROWS - 1) as f64).clamp(INSET_PX, height - INSET_PX))
}

/// How far the image of the ridge moves from one instrument to another, to the right, in px, in each row: 0 where neither
/// shows it. `None` where it is not known.
pub(super) fn ridge_moves(a: &System, b: &System) -> Option<Vec<f64>> {
    if a.prism().is_none() {
        return Some(vec![0.0; ROWS]);
    }
    let moved = rows(a).map(|y| match (ridge(a, y)?, ridge(b, y)?) {
        (Some(a), Some(b)) => Some(b - a),
        (None, None) => Some(0.0),
        // It comes into the picture or leaves it.
        _ => None,
    });
    moved.collect()
}

/// Where the image of the ridge crosses a row: `None` where rays end, `Some(None)` where one side is seen all along.
pub(super) fn ridge(system: &System, y: f64) -> Option<Option<f64>> {
    let width = system.camera().size_px()[0] as f64;
    let side = |x: f64| system.trace(DVec2::new(x, y)).ok().map(|sight| sight.side);
    let (mut a, mut b) = (INSET_PX, width - INSET_PX);
    let (left, right) = (side(a)?, side(b)?);
    if left == right {
        return Some(None);
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (a + b);
        if side(middle)? == left { a = middle } else { b = middle }
    }
    Some(Some(0.5 * (a + b)))
}

/// The direction of the image of the ridge; `None` where it is not in the picture all along, or the lens bends it.
pub(super) fn ridge_direction(system: &System) -> Option<DVec2> {
    if !system.camera().keeps_lines() {
        return None;
    }
    let places: Option<Vec<DVec2>> = rows(system).map(|y| Some(DVec2::new(ridge(system, y)??, y))).collect();
    let places = places?;
    (places[ROWS - 1] - places[0]).try_normalize()
}
