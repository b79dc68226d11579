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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::Accuracy;
    use crate::render::tests::instruments;

    /// Against the corners of pixels, from Taylor expansions by differences of the neighbours' centres.
    #[test]
    fn what_expansions_leave_out_is_bounded_closely() {
        let (mut judged, mut largest) = (0, 0.0f64);
        for (name, system) in instruments(Accuracy::exact(), 1) {
            let bound = of_differences_px(&system, &mut 0);
            let [width, height] = system.camera().size_px();
            let mut worst: f64 = 0.0;
            for k in 0..(width - 2) * (height - 2) {
                let px = DVec2::new((k % (width - 2)) as f64 + 1.5, (k / (width - 2)) as f64 + 1.5);
                let Some(off) = left_out_px(&system, px) else { continue };
                worst = worst.max(off);
            }
            // Below 1e-9 px the roundings of the board's positions count; at the critical angle there is no third order.
            if (1e-9..0.1).contains(&bound) {
                judged += 1;
                assert!(worst <= 1.05 * bound, "{name}: {worst:e} above {bound:e}");
                largest = largest.max(worst / bound);
            }
        }
        println!("{judged} instruments, up to {largest:.3} of the bound");
        assert!(judged >= 8 && largest > 0.5, "{judged} {largest}");
    }

    /// How far the farthest corner of a pixel is from where the expansion about its centre has it, in px; `None` where one of
    /// the rays, or of its neighbours', passes another side or nothing.
    fn left_out_px(system: &System, px: DVec2) -> Option<f64> {
        let here = system.footprint(px).ok()?;
        let side = here.sight.side;
        let see = |x: f64, y: f64| system.trace(px + DVec2::new(x, y)).ok().filter(|sight| sight.side == side);
        let at = |x: f64, y: f64| see(x, y).map(|sight| sight.board_mm - here.sight.board_mm);
        let (dx, dxx) = (0.5 * (at(1.0, 0.0)? - at(-1.0, 0.0)?), at(1.0, 0.0)? + at(-1.0, 0.0)?);
        let (dy, dyy) = (0.5 * (at(0.0, 1.0)? - at(0.0, -1.0)?), at(0.0, 1.0)? + at(0.0, -1.0)?);
        let dxy = 0.25 * ((at(1.0, 1.0)? - at(-1.0, 1.0)?) - (at(1.0, -1.0)? - at(-1.0, -1.0)?));
        let inverse = here.jacobian.inverse();
        let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
        corners.iter().try_fold(0.0, |worst: f64, &(x, y)| {
            let told = dx * x + dy * y + 0.5 * (dxx * (x * x) + dyy * (y * y)) + dxy * (x * y);
            Some(worst.max((inverse * (at(x, y)? - told)).abs().max_element()))
        })
    }
}
