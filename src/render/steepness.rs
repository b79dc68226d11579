//! How steeply the throughput changes across pixels.

use crate::system::System;
use glam::DVec2;

/// Where the throughput changes by this share across a pixel or less, its value at the centre is taken for all of it. A line
/// of the pattern through the pixel then moves by at most an eighth of it, in px: the light of one half of a pixel counts
/// for that of the other.
pub(super) const LARGEST_CHANGE: f64 = 2e-3;
/// Places along the width and the height of a picture at which its throughput is compared; all centres of a smaller one. A
/// lamp near the board is steep far beyond its foot: d px away, 4 / d a pixel.
const PLACES: [usize; 2] = [17, 9];

/// Whether the throughput changes steeply across some pixel of the picture.
pub(super) fn is_steep(system: &System, rays: &mut u64) -> bool {
    let size = system.camera().size_px();
    let count = [0, 1].map(|axis| PLACES[axis].min(size[axis]));
    let place = |axis: usize, k: usize| (k * size[axis] / count[axis]) as f64 + 0.5;
    *rays += 5 * (count[0] * count[1]) as u64;
    (0..count[0] * count[1]).any(|k| {
        let px = DVec2::new(place(0, k % count[0]), place(1, k / count[0]));
        change(system, px, 1.0) > LARGEST_CHANGE
    })
}

/// By how much of its middle's value the throughput changes at most across a pixel of side `active`.
pub(super) fn change(system: &System, px: DVec2, active: f64) -> f64 {
    let own = system.throughput(px);
    let sides = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y];
    let off = sides.map(|side| (system.throughput(px + side * (0.5 * active)) - own).abs());
    // A throughput of nothing is nothing all over.
    if own > 0.0 { 2.0 * off.into_iter().fold(0.0, f64::max) / own } else { 0.0 }
}
