//! The mean radiance of one pixel from the map about its centre, or from traced parts of it.

use super::film::Class;
use super::pixel_mean::{PackedTaylor2, PixelMean, Taylor2, divided_mean, mean_of_points, pixel_means};
use super::plan::{PartBorders, Plan};
use super::work::Work;
use crate::accuracy::Accuracy;
use crate::num::simd::LANES;
use glam::DVec2;
use std::f64::consts::SQRT_2;

/// The mean radiance of a pixel that sees the board through one side all over.
pub(super) fn whole_pixel(plan: &Plan, px: DVec2, taylor: &Taylor2, work: &mut Work) -> f64 {
    // Where there are kinks no expansion stands that is not compared with the map.
    let truncation_px = if plan.kinks == PartBorders::None { plan.truncation_px } else { f64::INFINITY };
    mean_or_subdivide(plan, px, means_of(plan, &PackedTaylor2::splat(taylor), &plan.less(truncation_px))[0], work)
}

/// The means of what the board shows over [`LANES`] pixels.
#[inline(always)]
pub(super) fn means_of(plan: &Plan, pixels: &PackedTaylor2, accuracy: &Accuracy) -> [PixelMean; LANES] {
    if plan.plate.is_none() {
        return pixel_means(&plan.pattern, pixels, accuracy);
    }
    let face = plan.face();
    let mean = |polygon: &[DVec2; 4]| {
        face.mean_over(polygon).unwrap_or_else(|| mean_of_points(&|c| face.radiance(c), polygon, &square(0.5)))
    };
    std::array::from_fn(|k| divided_mean(&pixels.lane(k), accuracy, &mean))
}

/// The radiance of the pixel at `px` by its mean; traced in parts where its Taylor expansion does not tell it.
#[inline(always)]
pub(super) fn mean_or_subdivide(plan: &Plan, px: DVec2, mean: PixelMean, work: &mut Work) -> f64 {
    match mean {
        PixelMean::Constant(value) => value,
        PixelMean::Edge { value, parts, off_px } => {
            work.counts.edge_pixels += 1;
            work.counts.divided_pixels += u64::from(parts > 1);
            work.counts.capped_pixels += u64::from(off_px > plan.system.accuracy().bend_px);
            work.bend_px = work.bend_px.max(off_px);
            value
        }
        PixelMean::TooBent => {
            work.counts.edge_pixels += 1;
            subdivided(plan, px, work)
        }
    }
}

/// The mean over n x n parts of the active square of the pixel at `px`, each traced, and multiplied by `throughput` of its
/// place. Mirror images are summed in pairs.
pub(super) fn mean_of_parts(plan: &Plan, px: DVec2, n: u32, throughput: impl Fn(DVec2) -> f64, work: &mut Work) -> f64 {
    let share = 1.0 / f64::from(n);
    let side = plan.active * share;
    let outline = square(0.5 * side);
    let place = |k: u32| (f64::from(2 * k + 1) - f64::from(n)) * (0.5 * side);
    let mut sum = 0.0;
    for j in 0..n {
        let mut part = |i: u32| {
            let at = px + DVec2::new(place(i), place(j));
            part(plan, at, &outline, work) * throughput(at)
        };
        for i in 0..n / 2 {
            sum += part(i) + part(n - 1 - i);
        }
        if n % 2 == 1 {
            sum += part(n / 2);
        }
    }
    sum * (share * share)
}

/// A square about the origin, of side 2 `half`.
pub(super) fn square(half: f64) -> [DVec2; 4] {
    [DVec2::new(-half, -half), DVec2::new(half, -half), DVec2::new(half, half), DVec2::new(-half, half)]
}

/// The mean radiance over `outline` (about `px`, in px), by the tangent of the map at `px`.
pub(super) fn part(plan: &Plan, px: DVec2, outline: &[DVec2], work: &mut Work) -> f64 {
    work.counts.rays += 1;
    let footprint = match plan.system.footprint(px) {
        Ok(footprint) => footprint,
        Err(fate) => return ended_ray_radiance(plan, fate.into()),
    };
    let scale = plan.pattern.squares_per_mm();
    // At the critical angle itself the map has no derivative.
    if !footprint.jacobian.is_finite() {
        return plan.face().at(footprint.sight.board_mm);
    }
    let mut polygon = [DVec2::ZERO; MAX_VERTICES];
    for (corner, p) in polygon.iter_mut().zip(outline) {
        *corner = (footprint.sight.board_mm + footprint.jacobian * *p) * scale;
    }
    let polygon = &polygon[..outline.len()];
    let face = plan.face();
    face.mean_over(polygon).unwrap_or_else(|| mean_of_points(&|c| face.radiance(c), polygon, outline))
}

/// What a ray brings that never reaches the board: nothing from within the glass, the surroundings from past the board.
pub(super) fn ended_ray_radiance(plan: &Plan, class: Class) -> f64 {
    if class == Class::PastBoard { plan.pattern.background() } else { 0.0 }
}

/// A pixel's own corners are traced this far inside it, in px, so that a border that falls
/// exactly between two pixels cuts neither.
pub(super) const INSET_PX: f64 = 1e-9;
/// Corners of a pixel, and at most two cuts.
pub(super) const MAX_VERTICES: usize = 8;

/// The mean radiance of the pixel at `px` from traced parts, each by the tangent of the map: 4, 16, 64 ... of them until
/// it has settled.
pub(super) fn subdivided(plan: &Plan, px: DVec2, work: &mut Work) -> f64 {
    work.counts.divided_pixels += 1;
    let mut by_parts = |depth: u32, work: &mut Work| mean_of_parts(plan, px, 2 << depth, |_| 1.0, work);
    adaptive(plan, 0.0, &mut by_parts, work)
}

/// The last of the values at depth 0, 1, 2 ..., each of parts of half the side: until two in a row differ from those before
/// by less than the bend allowed, in px, would make. Two, for a line may by chance be as far from its place among small
/// parts as among large ones; and not before `stray_px`, of which each halving leaves a quarter, has fallen below the bend.
/// The error of a part falls as the square of its side, so a third of the last difference is what the last value is wrong
/// by.
pub(super) fn adaptive(
    plan: &Plan,
    stray_px: f64,
    value_at: &mut dyn FnMut(u32, &mut Work) -> f64,
    work: &mut Work,
) -> f64 {
    // A line that moves by 1 px changes a pixel by at most its contrast times the pixel's diagonal. Where all is of one
    // radiance, so does a border of light.
    let accuracy = plan.system.accuracy();
    let contrast = plan.pattern.contrast();
    let per_px = (if contrast > 0.0 { contrast } else { plan.pattern.background() } * SQRT_2).min(1.0);

    // Halve the parts until the value has settled.
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
