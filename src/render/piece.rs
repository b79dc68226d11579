//! The radiance over a convex piece of a pixel of one class.

use super::passage::Passage;
use super::pixel::{adaptive, ended_ray_radiance, part};
use super::plan::{PartBorders, Plan};
use super::steepness::LARGEST_CHANGE;
use super::work::Work;
use crate::system::Side;
use glam::{DMat2, DVec2};

/// The arc of a border is at most this share of its chord high.
pub(super) const ARC_HEIGHT: f64 = 1.0 / 8.0;
/// Quarterings of a piece at most.
const MOST_QUARTERINGS: u32 = 4;

/// A convex piece of a pixel between the sides of a square and a border, on which its outline begins and ends.
#[derive(Debug)]
pub(super) struct Piece {
    /// Its vertices about the pixel's centre, in px.
    pub(super) outline: Vec<DVec2>,
    /// What becomes of rays in it.
    pub(super) passage: Passage,
}

impl Piece {
    /// The ends of its border, in the order of the outline.
    pub(super) fn border(&self) -> [DVec2; 2] {
        [self.outline[self.outline.len() - 1], self.outline[0]]
    }
}

/// The mean radiance of the piece, times its share of the pixel's active square.
pub(super) fn piece_radiance(plan: &Plan, px: DVec2, piece: &Piece, work: &mut Work) -> f64 {
    let Piece { outline, passage } = piece;
    let class = passage.class;
    if let Some(light) = plan.steep.then(|| by_throughput(plan, px, outline, work)).flatten() {
        return light;
    }
    let throughput = plan.throughput(px + middle(outline));
    let Some(side) = class.side() else {
        return ended_ray_radiance(plan, class) * share(plan, outline) * throughput;
    };
    let seen = seen(plan, px, outline, side, work);
    let plain = seen.as_ref().and_then(|(corners_mm, middle_mm)| constant_between(plan, *middle_mm, corners_mm));
    let mean = match plain {
        Some(value) => value * share(plan, outline),
        None => {
            let stray_px = seen.map_or(0.0, |(corners_mm, middle_mm)| stray_px(outline, &corners_mm, middle_mm));
            weighted(plan, px, outline, stray_px, work)
        }
    };
    mean * throughput
}

/// The light over a convex piece of a pixel, times its share of the pixel, by parts: where the throughput changes steeply
/// between its corners and its middle.
fn by_throughput(plan: &Plan, px: DVec2, outline: &[DVec2], work: &mut Work) -> Option<f64> {
    work.counts.rays += outline.len() as u64 + 1;
    let places = outline.iter().copied().chain([middle(outline)]);
    let throughputs = places.map(|at| plan.throughput(px + at));
    let (low, high) = throughputs.fold((f64::INFINITY, 0.0f64), |(low, high), t| (low.min(t), high.max(t)));
    let change = (high - low) / high * share(plan, outline);
    let quarterings = (0.5 * libm::log2(change / LARGEST_CHANGE)).ceil().min(f64::from(MOST_QUARTERINGS));
    if quarterings.is_nan() || quarterings <= 0.0 {
        return None;
    }
    let parts =
        (0..quarterings as u32).fold(fan(outline), |parts, _| parts.iter().flat_map(|part| quarters(part)).collect());
    let light = |part: &Vec<DVec2>| convex(plan, px, part, work) * plan.throughput(px + middle(part));
    Some(parts.iter().map(light).sum())
}

/// The radiance of a piece, and of what lies beside it within an eighth of its border's length, if it is the same all over.
pub(super) fn constant_radiance(plan: &Plan, px: DVec2, piece: &Piece, work: &mut Work) -> Option<f64> {
    let class = piece.passage.class;
    let Some(side) = class.side() else { return Some(ended_ray_radiance(plan, class)) };

    // With the corners of the rectangle over the border, from which the arc does not lead out.
    let mut outline = piece.outline.clone();
    let [from, to] = piece.border();
    let outward = (from - to).perp() * ARC_HEIGHT;
    outline.extend([from + outward, to + outward]);
    let (corners_mm, middle_mm) = seen(plan, px, &outline, side, work)?;
    constant_between(plan, middle_mm, &corners_mm)
}

/// How far the map strays from a linear one, fitted to what the corners and the middle of a piece see, at most at these
/// places, in px.
fn stray_px(outline: &[DVec2], corners_mm: &[DVec2], middle_mm: DVec2) -> f64 {
    let places = || outline.iter().copied().chain([middle(outline)]).zip(corners_mm.iter().copied().chain([middle_mm]));
    let count = (outline.len() + 1) as f64;
    let (at, seen_mm) = places().fold((DVec2::ZERO, DVec2::ZERO), |sum, place| (sum.0 + place.0, sum.1 + place.1));
    let about = || places().map(|place| (place.0 - at / count, place.1 - seen_mm / count));
    let (mut spread, mut both) = (DMat2::ZERO, DMat2::ZERO);
    for (px, mm) in about() {
        spread += DMat2::from_cols(px * px.x, px * px.y);
        both += DMat2::from_cols(mm * px.x, mm * px.y);
    }
    let map = both * spread.inverse();
    let inverse = map.inverse();
    about().map(|(px, mm)| (inverse * (mm - map * px)).length()).fold(0.0, f64::max)
}

/// The least and the largest components of places, and their mean.
#[inline(always)]
fn extent(places: &[DVec2]) -> [DVec2; 3] {
    let (mut low, mut high, mut sum) = (DVec2::INFINITY, DVec2::NEG_INFINITY, DVec2::ZERO);
    for place in places {
        (low, high, sum) = (low.min(*place), high.max(*place), sum + *place);
    }
    [low, high, sum / places.len() as f64]
}

/// The radiance of a convex piece whose middle and whose corners see these places of the board, if it is the same all over.
#[inline(always)]
pub(super) fn constant_between(plan: &Plan, middle_mm: DVec2, corners_mm: &[DVec2]) -> Option<f64> {
    let [low, high, mean] = extent(corners_mm);
    // Twice as far as the middle of the corners is from what the middle sees: the map's bend carries no point farther out.
    let bend = 2.0 * (mean - middle_mm).abs();
    let scale = plan.pattern.squares_per_mm();
    plan.face().constant(0.5 * (low + high) * scale, (0.5 * (high - low) + bend) * scale)
}

/// What the corners and the middle of a convex piece of a pixel see through `side`, in mm.
fn seen(plan: &Plan, px: DVec2, outline: &[DVec2], side: Side, work: &mut Work) -> Option<(Vec<DVec2>, DVec2)> {
    let mut see = |at: DVec2| {
        work.counts.rays += 1;
        let ray = plan.system.exit_ray_through(px + at, side).ok()?;
        plan.system.board().intersect(&ray).ok().map(|(board_mm, _)| board_mm)
    };
    // A corner on a crease may see by the facet beyond it.
    let inset_px = if plan.creases == PartBorders::Few { plan.system.accuracy().bend_px } else { 0.0 };
    let middle = middle(outline);
    let within = |at: DVec2| at + (middle - at).clamp_length_max(inset_px);
    let corners_mm = outline.iter().map(|at| see(within(*at))).collect::<Option<Vec<_>>>()?;
    Some((corners_mm, see(middle)?))
}

/// The mean radiance of a convex piece of a pixel's active square, times its share of it: by the tangent of the map at
/// its middle, then at those of ever smaller parts, until it has settled and the map, which strays from a linear one by
/// `stray_px`, strays in them by less than the bend allowed.
fn weighted(plan: &Plan, px: DVec2, outline: &[DVec2], stray_px: f64, work: &mut Work) -> f64 {
    let mut parts = vec![outline.to_vec()];
    let mut by_parts = |depth: u32, work: &mut Work| {
        match depth {
            0 => (),
            1 => parts = fan(outline),
            _ => parts = parts.iter().flat_map(|p| quarters(p)).collect(),
        }
        parts.iter().map(|p| convex(plan, px, p, work)).sum()
    };
    adaptive(plan, stray_px, &mut by_parts, work)
}

/// The mean of the corners.
pub(super) fn middle(outline: &[DVec2]) -> DVec2 {
    outline.iter().copied().sum::<DVec2>() / outline.len() as f64
}

/// A convex polygon as triangles from its middle to its sides: mirror images are cut alike.
fn fan(outline: &[DVec2]) -> Vec<Vec<DVec2>> {
    let n = outline.len();
    (0..n).map(|k| vec![middle(outline), outline[k], outline[(k + 1) % n]]).collect()
}

/// A triangle cut in four through the middles of its sides.
fn quarters(triangle: &[DVec2]) -> [Vec<DVec2>; 4] {
    let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
    let [d, e, f] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
    [[a, d, f], [d, b, e], [f, e, c], [d, e, f]].map(Vec::from)
}

/// The mean radiance of a convex piece of a pixel's active square, times its share of it, by the tangent of the map at its middle.
fn convex(plan: &Plan, px: DVec2, outline: &[DVec2], work: &mut Work) -> f64 {
    let share = share(plan, outline);
    if share <= 0.0 {
        return 0.0;
    }
    let middle = middle(outline);
    let about_middle: Vec<DVec2> = outline.iter().map(|p| *p - middle).collect();
    share * part(plan, px + middle, &about_middle, work)
}

/// The light over a convex piece by the tangent of the map at its middle, times its share of the pixel.
pub(super) fn convex_light(plan: &Plan, px: DVec2, outline: &[DVec2], work: &mut Work) -> f64 {
    let by_parts = plan.steep.then(|| by_throughput(plan, px, outline, work)).flatten();
    by_parts.unwrap_or_else(|| convex(plan, px, outline, work) * plan.throughput(px + middle(outline)))
}

/// The area of a polygon as a share of a pixel's active square.
pub(super) fn share(plan: &Plan, outline: &[DVec2]) -> f64 {
    let n = outline.len();
    let twice_area: f64 = (0..n).map(|k| outline[k].perp_dot(outline[(k + 1) % n])).sum();
    0.5 * twice_area / (plan.active * plan.active)
}
