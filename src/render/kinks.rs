//! Pixels in which the map has a kink: where it passes the side of a triangle whose normals are smooth.

use super::centre_rays::trace_scalar;
use super::divided::along_borders;
use super::pixel::{INSET_PX, square, subdivided};
use super::pixel_mean::Taylor2;
use super::plan::{KINK_STRAY_SHARE, PartBorders, Plan};
use super::steep;
use super::triangles;
use super::work::Work;
use crate::prism::triangles::TrianglePair;
use crate::system::System;
use glam::{DMat2, DVec2};

/// Whether the expansion of the pixel at `px`, by steps of a pixel, holds at its corners and at the middles of its sides. A
/// straight kink that passes through the pixel has a corner beyond it, at which the map strays most.
pub(super) fn holds(plan: &Plan, px: DVec2, taylor: &Taylor2, work: &mut Work) -> bool {
    work.counts.rays += 8;
    let inverse = DMat2::from_cols(taylor.dx, taylor.dy).inverse();
    let most = KINK_STRAY_SHARE * plan.system.accuracy().bend_px;
    places(plan).into_iter().all(|at| {
        let Some(seen) = seen(plan.system, px + at) else { return false };
        let bend = 0.5 * (taylor.dxx * (at.x * at.x) + taylor.dyy * (at.y * at.y)) + taylor.dxy * (at.x * at.y);
        let told = taylor.seen + taylor.dx * at.x + taylor.dy * at.y + bend;
        (inverse * (seen * plan.pattern.squares_per_mm() - told)).length() <= most
    })
}

/// The light of a pixel whose expansion does not hold, given the triangles that its centre sees where they tell it: cut along the sides of triangles where these tell it, along the kinks where they
/// are followed, else divided, and counted as one without promise where there are any.
pub(super) fn pixel(plan: &Plan, px: DVec2, middle: Option<TrianglePair>, work: &mut Work) -> f64 {
    work.counts.edge_pixels += 1;
    if let Some(light) = middle.and_then(|middle| triangles::pixel(plan, px, middle, work)) {
        return light;
    }
    if plan.kinks == PartBorders::Few {
        return along_borders(plan, px, plan.active, work);
    }
    let own = plan.system.parts(px);
    let parted = places(plan).into_iter().any(|at| plan.system.parts(px + at) != own);
    work.counts.unpromised_pixels += u64::from(parted);
    if let Some(light) = plan.steep.then(|| steep::pixel(plan, px, work)).flatten() {
        return light;
    }
    subdivided(plan, px, work) * plan.throughput(px)
}

/// The corners of a pixel's active square and the middles of its sides.
fn places(plan: &Plan) -> [DVec2; 8] {
    let corners = square(0.5 * plan.active - INSET_PX);
    let middles = [0, 1, 2, 3].map(|k| corners[k].lerp(corners[(k + 1) % 4], 0.5));
    std::array::from_fn(|k| if k < 4 { corners[k] } else { middles[k - 4] })
}

/// What `px` sees of the board, in mm.
fn seen(system: &System, px: DVec2) -> Option<DVec2> {
    let (seen_mm, class) = trace_scalar(system, px);
    class.side().map(|_| seen_mm)
}
