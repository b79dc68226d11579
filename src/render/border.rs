//! Pixels that the ridge or the border of a fate passes through or by.

use super::cover::Jet;
use super::looks::alone;
use super::plan::Plan;
use super::settled::settled;
use super::tile::{dark, mean_of_parts, part, square, whole_pixel};
use super::{Class, Work};
use glam::DVec2;

/// Halvings of a pixel's border when the place is sought where one class ends: 2^-40 px.
const BORDER_HALVINGS: u32 = 40;
/// Where a pixel's own corners are asked for their class: this far inside it, in px, so that a border that falls
/// exactly between two pixels cuts neither.
const INSET_PX: f64 = 1e-9;

/// A pixel beside or under the ridge or the border of a fate. Where that passes through it, it is cut along the straight
/// line through the places where its outline changes class, and each piece is seen by itself.
pub(super) fn border_pixel(plan: &Plan, px: DVec2, own: Class, work: &mut Work) -> f64 {
    let corners = square(0.5 * plan.active);
    let looks = corners.map(|c| alone(plan.system, px + c * (1.0 - 2.0 * INSET_PX)));
    let classes = looks.map(|(_, class)| class);
    work.counts.rays += 4;
    let parts = |work: &mut Work| mean_of_parts(plan, px, 16, |at| plan.gain(at), work);
    let changes: Vec<usize> = (0..4).filter(|&k| classes[k] != classes[(k + 1) % 4]).collect();
    match changes[..] {
        [] if !matches!(own, Class::Left | Class::Right) || classes[0] != own => {
            // A fate all over, or an island of one class within another: seen part by part.
            if classes[0] == own { dark(plan, own) * plan.gain(px) } else { parts(work) }
        }
        [] => match plain_between(plan, px, looks.map(|(seen_mm, _)| seen_mm)) {
            Some(value) => value * plan.gain(px),
            None => match jet_within(plan, px, work) {
                Some(jet) => whole_pixel(plan, px, &jet, work) * plan.gain(px),
                None => parts(work),
            },
        },
        [first, second] => {
            work.counts.cut_pixels += 1;
            let cut = |k: usize| border(plan, px, corners[k], corners[(k + 1) % 4], classes[k]);
            let (a, b) = (cut(first), cut(second));
            work.counts.rays += 2 * u64::from(BORDER_HALVINGS);
            let piece = |from: usize, to: usize, start: DVec2, end: DVec2| {
                let mut outline = vec![start];
                outline.extend((from + 1..=to).map(|k| corners[k % 4]));
                outline.push(end);
                outline
            };
            [piece(first, second, a, b), piece(second, first + 4, b, a)]
                .iter()
                .map(|outline| weighted(plan, px, outline, work))
                .sum()
        }
        // More than one border: sixteen parts a side, each taken whole.
        _ => {
            work.counts.cut_pixels += 1;
            parts(work)
        }
    }
}

/// The radiance of a pixel whose corners see `corners_mm`, if it is the same all over.
fn plain_between(plan: &Plan, px: DVec2, corners_mm: [DVec2; 4]) -> Option<f64> {
    let (centre_mm, _) = alone(plan.system, px);
    let [a, b, c, d] = corners_mm;
    let (low, high) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
    // Twice as far as the middle of the corners is from the centre: the map's bend carries no point farther out.
    let bend = 2.0 * (0.25 * ((a + b) + (c + d)) - centre_mm).abs();
    let scale = plan.pattern.squares_per_mm();
    plan.pattern.constant(0.5 * (low + high) * scale, (0.5 * (high - low) + bend) * scale)
}

/// The jet of a pixel from inside it alone: its neighbours see through another side or nothing. `None` where it sees
/// nothing itself.
fn jet_within(plan: &Plan, px: DVec2, work: &mut Work) -> Option<Jet> {
    work.counts.rays += 5;
    let reach = 0.5 * plan.active - INSET_PX;
    let scale = plan.pattern.squares_per_mm();
    let jacobian = |step: DVec2| plan.system.footprint(px + step).map(|f| f.jacobian * scale).ok();
    let here = plan.system.footprint(px).ok()?;
    let (x, y) = (DVec2::new(reach, 0.0), DVec2::new(0.0, reach));
    let along_x = (jacobian(x)? - jacobian(-x)?) * (0.5 / reach);
    let along_y = (jacobian(y)? - jacobian(-y)?) * (0.5 / reach);
    let tangent = here.jacobian * scale;
    let jet = Jet {
        seen: here.sight.board_mm * scale,
        dx: tangent.x_axis,
        dy: tangent.y_axis,
        dxx: along_x.x_axis,
        dxy: along_y.x_axis,
        dyy: along_y.y_axis,
    };
    Some(jet.by_steps_of(plan.active))
}

/// The place between the corners `a` (of class `class`) and `b` (of another) where the class changes.
fn border(plan: &Plan, px: DVec2, a: DVec2, b: DVec2, class: Class) -> DVec2 {
    let (mut near, mut far) = (0.0, 1.0);
    for _ in 0..BORDER_HALVINGS {
        let middle = 0.5 * (near + far);
        if alone(plan.system, px + a + (b - a) * middle).1 == class { near = middle } else { far = middle }
    }
    a + (b - a) * (0.5 * (near + far))
}

/// The light that a convex piece of a pixel's active square receives, times its share of it: by the tangent of the map at
/// its middle, then at those of ever smaller parts, until it has settled. What effects leave of it is that of its middle.
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
    settled(&plan.system.accuracy, &mut by_parts, work) * plan.gain(px + middle(outline))
}

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
    let n = outline.len();
    let twice_area: f64 = (0..n).map(|k| outline[k].perp_dot(outline[(k + 1) % n])).sum();
    if twice_area <= 0.0 {
        return 0.0;
    }
    let middle = middle(outline);
    let about_middle: Vec<DVec2> = outline.iter().map(|p| *p - middle).collect();
    let share = 0.5 * twice_area / (plan.active * plan.active);
    share * part(plan, px + middle, &about_middle, work)
}
