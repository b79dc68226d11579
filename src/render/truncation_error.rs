//! The truncation error of the Taylor expansions of pixels: the third order of the map, which they leave out.

use crate::system::System;
use glam::{DMat2, DVec2};

/// Places along each side of the sensor at which it is estimated: the outermost are the middles of the outermost pixels,
/// where it is mostly largest.
const PLACES: usize = 7;
/// Steps of the differences, in px: from the middle of a pixel they do not leave it, nor the glass.
const STEP_PX: f64 = 0.5;

/// What a Taylor expansion from differences of neighbours is wrong by inside a pixel, in px, at most: from third
/// differences of traced positions all over the sensor. The differences of a Taylor expansion hold a sixth of the third
/// derivative, of which a pixel's side is reached by half; with the third order itself that is at most a twelfth.
pub(super) fn of_differences_px(system: &System, rays: &mut u64) -> f64 {
    let size = DVec2::from(system.camera().size_px().map(|n| n as f64));
    let share = |k: usize| k as f64 / (PLACES - 1) as f64;
    let mut worst: f64 = 0.0;
    for k in 0..PLACES * PLACES {
        let px = 0.5 + (size - 1.0) * DVec2::new(share(k % PLACES), share(k / PLACES));
        *rays += 6;
        let Ok(hit) = system.trace(px) else { continue };
        let map = |step: DVec2| system.footprint_through(px + step, hit.side).map(|f| f.jacobian);
        let Ok(here) = map(DVec2::ZERO) else { continue };
        let by_step = |step: DVec2| Some((map(step).ok()? - here * 2.0) + map(-step).ok()?);
        let second = |axis: DVec2| Some(by_step(axis * STEP_PX)? * (1.0 / (STEP_PX * STEP_PX)));
        let (Some(xx), Some(yy)) = (second(DVec2::X), second(DVec2::Y)) else { continue };
        let third = (xx.x_axis.abs() + 3.0 * xx.y_axis.abs()) + (3.0 * yy.x_axis.abs() + yy.y_axis.abs());
        worst = worst.max(in_px(here, third) / 12.0);
    }
    worst
}

/// What a pixel makes at most, in px, of a vector on the board of these magnitudes, given d board / d px.
pub(super) fn in_px(map: DMat2, most: DVec2) -> f64 {
    let inverse = map.inverse();
    (inverse.x_axis.abs() * most.x + inverse.y_axis.abs() * most.y).max_element()
}
