//! The slow way with a pixel whose jet does not tell it: divided until its value settles.

use super::Work;
use super::plan::Plan;
use super::tile::mean_of_parts;
use glam::DVec2;
use std::f64::consts::SQRT_2;

/// The mean radiance of the pixel at `px` from traced parts, each by the tangent of the map: 4, 16, 64 ... of them until
/// it has settled.
pub(super) fn divided(plan: &Plan, px: DVec2, work: &mut Work) -> f64 {
    work.counts.divided_pixels += 1;
    let mut by_parts = |depth: u32, work: &mut Work| mean_of_parts(plan, px, 2 << depth, |_| 1.0, work);
    settled(plan, 0.0, &mut by_parts, work)
}

/// The last of the values at depth 0, 1, 2 ..., each of parts of half the side: until two in a row differ from those before
/// by less than the bend allowed, in px, would make. Two, for a line may by chance be as far from its place among small
/// parts as among large ones; and not before `stray_px`, of which a quarter is left each time, has fallen below the bend. The
/// error of a part falls as the square of its side, so a third of the last difference is what the last value is wrong by.
pub(super) fn settled(
    plan: &Plan,
    stray_px: f64,
    value_at: &mut dyn FnMut(u32, &mut Work) -> f64,
    work: &mut Work,
) -> f64 {
    let accuracy = &plan.system.accuracy;
    // A line that moves by 1 px changes a pixel by at most its contrast times the pixel's diagonal.
    let per_px = (plan.pattern.contrast() * SQRT_2).min(1.0);
    let deepest = accuracy.max_division.max(8).ilog2() - 1;
    let (mut value, mut close_before) = (value_at(0, work), false);
    for depth in 1..=deepest {
        let finer = value_at(depth, work);
        let difference = (finer - value).abs();
        value = finer;
        let close = difference <= accuracy.bend_px * per_px;
        let straight = stray_px <= accuracy.bend_px * f64::from(1u32 << (2 * depth));
        if (close && close_before && straight) || depth == deepest {
            if difference > 0.0 {
                work.bend_px = work.bend_px.max(difference / (3.0 * per_px));
            }
            work.counts.capped_pixels += u64::from(!(close && straight));
            break;
        }
        close_before = close;
    }
    value
}
