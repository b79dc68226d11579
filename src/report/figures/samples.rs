//! For the tests: pictures and corners of a realistic shape.

use super::comparison::CornerMark;
use crate::raster::Raster;
use glam::DVec2;

/// Side of a square of the board, in px.
const SQUARE: f64 = 64.0;

/// Where the corner that the ideal pinhole sees at `ideal` (in px of a half image of 960 x 1080, from its middle) is
/// seen: up to `largest` px away, and rows and columns are bent.
fn seen(ideal: DVec2, largest: f64) -> DVec2 {
    let n = ideal / DVec2::new(480.0, 540.0);
    ideal + DVec2::new(0.2 * n.x * n.x + 0.8 * n.y * n.y, 0.7 * n.x * n.y) * (largest / 1.22)
}

/// The stereo image of a checkerboard through a prism that moves corners by up to `largest` px; mirror images.
pub(super) fn board(largest: f64) -> (Raster<f32>, Vec<CornerMark>) {
    let side = |x: f64| if x < 960.0 { -1.0 } else { 1.0 };
    let in_half = |p: DVec2| DVec2::new((p.x - 960.0 - 480.0 * side(p.x)) * side(p.x), p.y - 540.0);
    let value = |p: DVec2| {
        let there = in_half(p);
        // The map is undone by iteration: it moves little.
        let ideal = (0..6).fold(there, |ideal, _| there - (seen(ideal, largest) - ideal));
        let cell = (ideal / SQUARE).floor();
        if (cell.x + cell.y).rem_euclid(2.0) == 0.0 { 0.9 } else { 0.05 }
    };
    let subsamples = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)];
    let pixel = |i: usize, j: usize| {
        let sum: f64 = subsamples.iter().map(|(dx, dy)| value(DVec2::new(i as f64 + dx, j as f64 + dy))).sum();
        (0.25 * sum) as f32
    };
    let data = (0..1080).flat_map(|j| (0..1920).map(move |i| (i, j))).map(|(i, j)| pixel(i, j)).collect();
    let mut corners = Vec::new();
    for s in [-1.0, 1.0] {
        for row in -8..=8 {
            for column in -7..=7 {
                let ideal = DVec2::new(f64::from(column), f64::from(row)) * SQUARE;
                let real = seen(ideal, largest);
                if real.x.abs() < 475.0 && real.y.abs() < 535.0 {
                    let flip = DVec2::new(s, 1.0);
                    let position_px = DVec2::new(960.0 + 480.0 * s, 540.0) + real * flip;
                    corners.push(CornerMark { index: [column, row], position_px, error_px: (real - ideal) * flip });
                }
            }
        }
    }
    (Raster::from_data(1920, 1080, data), corners)
}
