//! Pixels cut by the image of the ridge or by the border of a region whose rays end at a fate, and pixels beside them.
//!
//! Such a pixel is clipped along the border (a straight line through it), and each piece is integrated by itself.

use super::centre_rays::trace_scalar;
use super::film::Class;
use super::pixel::{adaptive, ended_ray_radiance, mean_of_parts, part, square, whole_pixel};
use super::pixel_mean::Taylor2;
use super::plan::Plan;
use super::work::Work;
use crate::system::Side;
use glam::DVec2;

/// The place where one class ends on a pixel's border is known to this share of the border: 2^-40.
const BORDER_SHARE: f64 = 1.0 / (1u64 << 40) as f64;
/// Steps of the secant method to the ridge; it is nearly straight, and 3 to 4 are enough.
const SECANTS: usize = 6;
/// A pixel's own corners are traced this far inside it, in px, so that a border that falls
/// exactly between two pixels cuts neither.
const INSET_PX: f64 = 1e-9;

/// A pixel beside or under the ridge or the border of a fate. Where that passes through it, it is cut along the straight
/// line through the places where its outline changes class, and each piece is integrated by itself.
pub(super) fn border_pixel(plan: &Plan, px: DVec2, own: Class, work: &mut Work) -> f64 {
    // Trace the corners of the active square, and find the sides on which the class changes.
    let corners = square(0.5 * plan.active);
    let corner_hits = corners.map(|c| trace_scalar(plan.system, px + c * (1.0 - 2.0 * INSET_PX)));
    let classes = corner_hits.map(|(_, class)| class);
    work.counts.rays += 4;
    let parts = |work: &mut Work| mean_of_parts(plan, px, 16, |at| plan.throughput(at), work);
    let changes: Vec<usize> = (0..4).filter(|&k| classes[k] != classes[(k + 1) % 4]).collect();

    // Take the pixel by the number of borders that cross its outline.
    match changes[..] {
        // No border: a fate all over, or an island of one class within another, which is traced in parts.
        [] if own.side().is_none() || classes[0] != own => {
            if classes[0] == own {
                ended_ray_radiance(plan, own) * plan.throughput(px)
            } else {
                parts(work)
            }
        }
        // No border, and one side all over: a constant radiance, the mean by the Taylor expansion, or traced parts.
        [] => match constant_between(plan, trace_scalar(plan.system, px).0, &corner_hits.map(|(seen_mm, _)| seen_mm)) {
            Some(value) => value * plan.throughput(px),
            None => match taylor2_within(plan, px, work) {
                Some(taylor) => whole_pixel(plan, px, &taylor, work) * plan.throughput(px),
                None => parts(work),
            },
        },

        // One border: cut the pixel where its outline changes class, and integrate each piece by itself.
        [first, second] => {
            work.counts.cut_pixels += 1;

            // Find where one class ends and the next begins, on a side of the outline.
            let mut cuts = |k: usize| {
                let next = (k + 1) % 4;
                let ends = border(plan, px, [corners[k], corners[next]], [classes[k], classes[next]], work);
                // A ground ridge may lie between the two sides: it is in neither piece, and dark.
                let ground = plan.system.clips() && classes[k].side().is_some() && classes[next].side().is_some();
                let swapped = ([corners[next], corners[k]], [classes[next], classes[k]]);
                let begins = if ground { border(plan, px, swapped.0, swapped.1, work) } else { ends };
                (ends, begins)
            };
            let ((end_a, begin_a), (end_b, begin_b)) = (cuts(first), cuts(second));

            // Integrate each piece of the outline between the two cuts.
            let mut piece = |from: usize, to: usize, start: DVec2, end: DVec2| {
                let mut outline = vec![start];
                outline.extend((from + 1..=to).map(|k| corners[k % 4]));
                outline.push(end);
                let mean = match constant(plan, px, &outline, classes[to % 4], work) {
                    Some(value) => value * share(plan, &outline),
                    None => weighted(plan, px, &outline, work),
                };
                mean * plan.throughput(px + middle(&outline))
            };
            piece(first, second, begin_a, end_b) + piece(second, first + 4, begin_b, end_a)
        }
        // More than one border: trace sixteen parts a side, each taken whole.
        _ => {
            work.counts.cut_pixels += 1;
            parts(work)
        }
    }
}

/// The radiance of a convex piece whose middle and whose corners see these places of the board, if it is the same all over.
#[inline(always)]
fn constant_between(plan: &Plan, middle_mm: DVec2, corners_mm: &[DVec2]) -> Option<f64> {
    let (mut low, mut high, mut sum) = (DVec2::INFINITY, DVec2::NEG_INFINITY, DVec2::ZERO);
    for corner_mm in corners_mm {
        (low, high, sum) = (low.min(*corner_mm), high.max(*corner_mm), sum + *corner_mm);
    }
    // Twice as far as the middle of the corners is from what the middle sees: the map's bend carries no point farther out.
    let bend = 2.0 * (sum / corners_mm.len() as f64 - middle_mm).abs();
    let scale = plan.pattern.squares_per_mm();
    plan.pattern.constant(0.5 * (low + high) * scale, (0.5 * (high - low) + bend) * scale)
}

/// The radiance of a convex piece of a pixel that sees through the side of `class` all over, if it is the same all over.
fn constant(plan: &Plan, px: DVec2, outline: &[DVec2], class: Class, work: &mut Work) -> Option<f64> {
    let side = class.side()?;
    let mut see = |at: DVec2| {
        work.counts.rays += 1;
        let ray = plan.system.exit_ray_through(px + at, side).ok()?;
        plan.system.board().intersect(&ray).ok().map(|(board_mm, _)| board_mm)
    };
    let corners_mm = outline.iter().map(|at| see(*at)).collect::<Option<Vec<_>>>()?;
    constant_between(plan, see(middle(outline))?, &corners_mm)
}

/// The Taylor expansion of a pixel by differentials inside it: its neighbours see through another side or nothing. `None` where it sees
/// nothing itself.
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

/// The place between two corners of these classes where the first class ends.
fn border(plan: &Plan, px: DVec2, [a, b]: [DVec2; 2], classes: [Class; 2], work: &mut Work) -> DVec2 {
    let at = |share: f64| px + a + (b - a) * share;
    let offset_mm = |share: f64| {
        work.counts.rays += 1;
        plan.system.front_x_mm(at(share), Side::Right)
    };
    let on_ridge = if classes.iter().all(|class| class.side().is_some()) { ridge(offset_mm) } else { None };
    let mut narrowed = (0.0, 1.0);
    let mut narrow = |(near, far): (f64, f64), share: f64| {
        if share <= near || share >= far {
            return (near, far);
        }
        work.counts.rays += 1;
        if trace_scalar(plan.system, at(share)).1 == classes[0] { (share, far) } else { (near, share) }
    };
    if let Some(share) = on_ridge {
        narrowed = narrow(narrowed, share - 0.5 * BORDER_SHARE);
        narrowed = narrow(narrowed, share + 0.5 * BORDER_SHARE);
    }
    // Of the ridge this is done already, but where rounding hides on which side of it a ray passes.
    while narrowed.1 - narrowed.0 > BORDER_SHARE {
        narrowed = narrow(narrowed, 0.5 * (narrowed.0 + narrowed.1));
    }
    a + (b - a) * (0.5 * (narrowed.0 + narrowed.1))
}

/// Where the secant method, from the ends of 0..1 on, finds `offset_mm` to be 0; `None` where it is not known somewhere.
fn ridge(mut offset_mm: impl FnMut(f64) -> Option<f64>) -> Option<f64> {
    let (mut before, mut here) = ((0.0, offset_mm(0.0)?), (1.0, offset_mm(1.0)?));
    for _ in 0..SECANTS {
        let share: f64 = here.0 - here.1 * (here.0 - before.0) / (here.1 - before.1);
        if !share.is_finite() || (share - here.0).abs() < 0.25 * BORDER_SHARE {
            break;
        }
        (before, here) = (here, (share, offset_mm(share)?));
    }
    Some(here.0)
}

/// The light that a convex piece of a pixel's active square receives, times its share of it: by the tangent of the map at
/// its middle, then at those of ever smaller parts, until it has settled.
fn weighted(plan: &Plan, px: DVec2, outline: &[DVec2], work: &mut Work) -> f64 {
    let mut parts = vec![outline.to_vec()];
    let mut by_parts = |depth: u32, work: &mut Work| {
        match depth {
            0 => (),
            1 => parts = fan(outline),
            _ => parts = parts.iter().flat_map(|p| quarters(p)).collect(),
        }
        parts.iter().map(|p| convex(plan, px, p, work)).sum()
    };
    adaptive(plan.system.accuracy(), &mut by_parts, work)
}

/// The mean of the corners.
fn middle(outline: &[DVec2]) -> DVec2 {
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

/// The light of a convex piece of a pixel's active square, times its share of it, by the tangent of the map at its middle.
fn convex(plan: &Plan, px: DVec2, outline: &[DVec2], work: &mut Work) -> f64 {
    let share = share(plan, outline);
    if share <= 0.0 {
        return 0.0;
    }
    let middle = middle(outline);
    let about_middle: Vec<DVec2> = outline.iter().map(|p| *p - middle).collect();
    share * part(plan, px + middle, &about_middle, work)
}

/// The area of a polygon as a share of a pixel's active square.
fn share(plan: &Plan, outline: &[DVec2]) -> f64 {
    let n = outline.len();
    let twice_area: f64 = (0..n).map(|k| outline[k].perp_dot(outline[(k + 1) % n])).sum();
    0.5 * twice_area / (plan.active * plan.active)
}
