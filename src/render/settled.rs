//! The slow way with a pixel, that of the reference: divided until its value settles.

use super::Work;
use super::cover::Jet;
use super::plan::Plan;
use super::tile::mean_of_parts;
use glam::DVec2;

/// The mean radiance of the pixel at `px`, unless its jet shows that no line of the pattern comes near it.
pub(super) fn pixel(plan: &Plan, px: DVec2, jet: &Jet, work: &mut Work) -> f64 {
    let reach = (jet.dx.abs() + jet.dy.abs()) + 2.0 * (jet.dxx.abs() + jet.dxy.abs() + jet.dyy.abs());
    if let Some(value) = plan.pattern.constant(jet.seen, reach) {
        return value;
    }
    work.counts.edge_pixels += 1;
    divided(plan, px, work)
}

/// The mean radiance of the pixel at `px` from traced parts, each by the tangent of the map: 4, 16, 64 ... of them until
/// two results in a row differ by less than the bend allowed, in px, would make. The error of a part falls as the square
/// of its side, so a third of their difference is what the last result is wrong by.
pub(super) fn divided(plan: &Plan, px: DVec2, work: &mut Work) -> f64 {
    let accuracy = &plan.system.accuracy;
    let (mut n, mut value) = (2, mean_of_parts(plan, px, 2, |_| 1.0, work));
    loop {
        n *= 2;
        let finer = mean_of_parts(plan, px, n, |_| 1.0, work);
        let difference = (finer - value).abs();
        value = finer;
        if difference <= accuracy.bend_px || 2 * n > accuracy.max_division {
            work.bend_px = work.bend_px.max(difference / 3.0);
            break;
        }
    }
    work.counts.divided_pixels += u64::from(n > 4);
    value
}
