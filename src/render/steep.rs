//! Pixels over which the throughput changes so much that its value at their centre does not stand for all of them: near a
//! lamp's foot on the board, or near the critical angle. They are taken by parts, whose errors fall as the square of their side.

use super::pixel::mean_of_parts;
use super::plan::Plan;
use super::steepness::{LARGEST_CHANGE, change};
use super::work::Work;
use glam::DVec2;

/// Parts along each side of a pixel at most; one that needs more holds no promise.
const MOST_PARTS: u32 = 32;

/// The light of a pixel that no border crosses, where it is to be taken by parts.
pub(super) fn pixel(plan: &Plan, px: DVec2, work: &mut Work) -> Option<f64> {
    work.counts.rays += 5;
    let parts = (change(plan.system(), px, plan.active) / LARGEST_CHANGE).sqrt().ceil();
    let light = |n: u32, work: &mut Work| mean_of_parts(plan, px, n, |at| plan.throughput(at), work);
    work.counts.unpromised_pixels += u64::from(parts > f64::from(MOST_PARTS));
    (parts > 1.0).then(|| light(parts.min(f64::from(MOST_PARTS)) as u32, work))
}

/// The same of the pixels of a row that are not listed, the first with its centre at `start`.
pub(super) fn row(plan: &Plan, start: DVec2, row: &mut [f32], unlisted: impl Fn(u32) -> bool, work: &mut Work) {
    for (i, value) in row.iter_mut().enumerate().filter(|(i, _)| unlisted(*i as u32)) {
        if let Some(light) = pixel(plan, start + DVec2::new(i as f64, 0.0), work) {
            *value = light as f32;
        }
    }
}
