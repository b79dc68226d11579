//! Pixels cut by the image of the ridge or by the border of a region whose rays end at a fate, and pixels beside them.
//!
//! Such a pixel is clipped along the border, and each piece is integrated by itself. A border that is no straight line,
//! and several borders, are followed by dividing the pixel (`divided`).

use super::centre_rays::trace_scalar;
use super::cut::{are_adjacent, changes, pieces};
use super::divided::{along_borders, outline_is_simple};
use super::film::Class;
use super::passage::Passage;
use super::piece::{Piece, constant_between, piece_radiance};
use super::pixel::{INSET_PX, ended_ray_radiance, square, whole_pixel};
use super::pixel_mean::Taylor2;
use super::plan::Plan;
use super::steep;
use super::work::Work;
use crate::system::Side;
use glam::DVec2;

/// An arc takes this share of the rectangle about it, so that so much of its height counts as the move of a line.
const ARC_SHARE: f64 = 2.0 / 3.0;

/// Where light may pass between the corners of a pixel and its centre, it is divided in parts of at most this share of its side.
const LARGEST_PART: f64 = 1.0 / 16.0;

/// What may pass through a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Nearby {
    /// The ridge alone: its centre and those of its neighbours see the board.
    Ridge,
    /// The border of a fate, or a crease.
    Border,
    /// All of the glass: the picture has few pixels, and some see nothing of the board.
    Anything,
}

/// A pixel beside or under the ridge or the border of a fate. Where the straight ridge passes through it, it is cut in two
/// along it, and each piece is integrated by itself; any other border is followed. `nearby` is what may pass through it.
pub(super) fn border_pixel(plan: &Plan, px: DVec2, own: Class, nearby: Nearby, work: &mut Work) -> f64 {
    if nearby == Nearby::Anything {
        return along_borders(plan, px, LARGEST_PART * plan.active, work);
    }

    // Trace the corners of the active square, and find the sides on which the class changes.
    let corners = square(0.5 * plan.active);
    let corner_hits = corners.map(|c| trace_scalar(plan.system, px + c * (1.0 - 2.0 * INSET_PX)));
    let passages = [0, 1, 2, 3].map(|k| Passage::of(plan, px + corners[k] * (1.0 - 2.0 * INSET_PX), corner_hits[k].1));
    work.counts.rays += 4;
    let own = Passage::of(plan, px, own);

    // Take the pixel by the number of borders that cross its outline.
    match changes(&passages)[..] {
        // None, not even twice through one side.
        [] if passages[0] == own && !bulges(plan, px, &corners, own, nearby, work) => {
            if let Some(light) = plan.steep.then(|| steep::pixel(plan, px, work)).flatten() {
                return light;
            }
            if own.class.side().is_none() {
                return ended_ray_radiance(plan, own.class) * plan.throughput(px);
            }
            let corners_mm = corner_hits.map(|(seen_mm, _)| seen_mm);
            if let Some(value) = constant_between(plan, trace_scalar(plan.system, px).0, &corners_mm) {
                return value * plan.throughput(px);
            }
            match taylor2_within(plan, px, work) {
                Some(taylor) => whole_pixel(plan, px, &taylor, work) * plan.throughput(px),
                None => along_borders(plan, px, plan.active, work),
            }
        }
        // The ridge alone, as a straight line.
        [first, second] if nearby == Nearby::Ridge => {
            work.counts.cut_pixels += 1;
            let pieces = pieces(plan, px, &corners, &passages, [first, second], work);
            let lit = passages.iter().all(|passage| passage.class.side().is_some());
            let straight = || plan.straight_ridge || (are_adjacent(&pieces) && ridge_is_straight(plan, px, &pieces[0]));
            if lit && straight() {
                piece_radiance(plan, px, &pieces[0], work) + piece_radiance(plan, px, &pieces[1], work)
            } else {
                along_borders(plan, px, plan.active, work)
            }
        }
        // The border of a fate, several borders, or an island of one class within another.
        _ => {
            work.counts.cut_pixels += 1;
            along_borders(plan, px, plan.active, work)
        }
    }
}

/// Whether a border may pass through a side of the pixel twice, between its corners, whose passage is `own`.
fn bulges(plan: &Plan, px: DVec2, corners: &[DVec2; 4], own: Passage, nearby: Nearby, work: &mut Work) -> bool {
    if nearby == Nearby::Border {
        !outline_is_simple(plan, px, corners, &[own; 4], work)
    } else {
        ridge_bulges(plan, px, corners)
    }
}

/// How far right of the ridge a place of the picture meets the front, in mm.
fn off_ridge_mm(plan: &Plan, px: DVec2) -> Option<f64> {
    let off_mm = |side| plan.system.front_x_mm(px, side);
    off_mm(Side::Right).filter(|x| *x >= 0.0).or_else(|| off_mm(Side::Left))
}

/// Whether the ridge, along which a piece ends, strays from its chord by less than the bend allowed: by where the front is
/// met, which takes no ray to the board.
fn ridge_is_straight(plan: &Plan, px: DVec2, piece: &Piece) -> bool {
    let [from, to] = piece.border();
    let across = (to - from).perp().normalize_or_zero() * (0.25 * plan.active);
    let off_mm = |at: DVec2| off_ridge_mm(plan, px + at);
    let strays_px = || {
        let [ends, middle] = [[from, to], [from.lerp(to, 0.5) - across, from.lerp(to, 0.5) + across]];
        let ([a, b], [low, high]) = ([off_mm(ends[0])?, off_mm(ends[1])?], [off_mm(middle[0])?, off_mm(middle[1])?]);
        let px_per_mm = 2.0 * across.length() / (high - low).abs();
        let stray = |share: f64| Some((off_mm(from.lerp(to, share))? - (a + (b - a) * share)).abs() * px_per_mm);
        Some(stray(0.25)?.max(stray(0.5)?).max(stray(0.75)?))
    };
    strays_px().is_some_and(|stray_px| ARC_SHARE * stray_px <= plan.system.accuracy().bend_px)
}

/// Whether the ridge may pass through a side of the pixel twice, between its corners, and so far that it matters: by a
/// parabola along each side of where the front is met.
fn ridge_bulges(plan: &Plan, px: DVec2, corners: &[DVec2; 4]) -> bool {
    if plan.straight_ridge {
        return false;
    }
    let off_mm = |at: DVec2| off_ridge_mm(plan, px + at);
    let bulges = || {
        let own = off_mm(DVec2::ZERO)?;
        let mut ends = [0.0; 4];
        let mut middles = [0.0; 4];
        for k in 0..4 {
            ends[k] = off_mm(corners[k])? * own.signum();
            middles[k] = off_mm(0.5 * (corners[k] + corners[(k + 1) % 4]))? * own.signum();
        }
        // In mm by px, across the ridge.
        let slope = DVec2::new(middles[0] - middles[2], middles[1] - middles[3]).length() / plan.active;
        let lowest = (0..4).map(|k| lowest([ends[k], middles[k], ends[(k + 1) % 4]])).fold(f64::INFINITY, f64::min);
        Some(ARC_SHARE * lowest < -plan.system.accuracy().bend_px * slope)
    };
    bulges().unwrap_or(true)
}

/// The least value of the parabola through these, at 0, 1/2 and 1, between its ends.
fn lowest([a, m, b]: [f64; 3]) -> f64 {
    let (bend, slope) = (2.0 * (a + b - 2.0 * m), 4.0 * m - 3.0 * a - b);
    let at = -0.5 * slope / bend;
    if at > 0.0 && at < 1.0 { a + (slope + bend * at) * at } else { a.min(b) }
}

/// The Taylor expansion of a pixel by differentials inside it: its neighbours see through another side or nothing.
/// `None` where it sees nothing itself.
fn taylor2_within(plan: &Plan, px: DVec2, work: &mut Work) -> Option<Taylor2> {
    work.counts.rays += 5;
    let reach = 0.5 * plan.active - INSET_PX;
    let scale = plan.pattern.squares_per_mm();
    let jacobian = |step: DVec2| plan.system.footprint(px + step).map(|f| f.jacobian * scale).ok();
    let here = plan.system.footprint(px).ok()?;
    let (x, y) = (DVec2::new(reach, 0.0), DVec2::new(0.0, reach));
    let along_x = (jacobian(x)? - jacobian(-x)?) * (0.5 / reach);
    let along_y = (jacobian(y)? - jacobian(-y)?) * (0.5 / reach);
    let tangent = here.jacobian * scale;
    let taylor = Taylor2 {
        seen: here.sight.board_mm * scale,
        dx: tangent.x_axis,
        dy: tangent.y_axis,
        dxx: along_x.x_axis,
        dxy: along_y.x_axis,
        dyy: along_y.y_axis,
    };
    Some(taylor.by_steps_of(plan.active))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::Accuracy;
    use crate::render::tests::{built, scene};

    /// Two facets that are bent in y, off the camera's axis: their ridge is seen as a curve. Every pixel that it passes
    /// through, against the same by division, which compares the border itself with its chord.
    #[test]
    fn a_curved_ridge_is_followed() {
        let prism = "kind = \"polynomial\"\nindex = 1.48\nposition_mm = [3.0, 0.0, 0.0]\n\
                     front = { centre_mm = [0, 0], scale_mm = [1, 1], domain_mm = [[-1, 14], [-9, 9]],\
                     terms = [[0, 0, 79], [1, 0, 0.155779], [0, 2, 0.04]] }\n\
                     back = { centre_mm = [0, 0], scale_mm = [1, 1], domain_mm = [[-1, 14], [-9, 9]],\
                     terms = [[0, 0, 87]] }";
        let board = "columns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]";
        let system = built(&scene(66, 37, prism, board), Accuracy::exact());
        let plan = Plan::new(&system);
        let allowed = std::f64::consts::SQRT_2 * system.accuracy().bend_px;
        let (mut cut, mut curved) = (0, 0);
        let corners = square(0.5 * plan.active);
        for (i, j) in (0..66).flat_map(|i| (0..37).map(move |j| (i, j))) {
            // Find the pixels that the ridge cuts in two.
            let px = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
            let mut work = Work::default();
            let passages = corners.map(|c| Passage::at(&plan, px + c, &mut work));
            let [first, second] = changes(&passages)[..] else { continue };
            cut += 1;

            // Compare their light.
            let own = trace_scalar(&system, px).1;
            let light = border_pixel(&plan, px, own, Nearby::Ridge, &mut work);
            let followed = along_borders(&plan, px, plan.active, &mut work);
            assert!(work.counts.unpromised_pixels == 0, "{px}");
            assert!((light - followed).abs() <= allowed, "{px}: {light} {followed}");

            // Count those in which the ridge strays from its chord.
            let [from, to] = pieces(&plan, px, &corners, &passages, [first, second], &mut work)[0].border();
            let across = (to - from).perp().normalize() * (10.0 * system.accuracy().bend_px);
            let [one, other] = [1.0, -1.0].map(|way| trace_scalar(&system, px + from.lerp(to, 0.5) + way * across).1);
            curved += usize::from(one == other);
        }
        assert!(cut >= 37 && curved >= 20, "{cut} {curved}");
    }
}
