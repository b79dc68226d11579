//! The direction and the bend of a lattice line at a corner, from the corners along it.
//!
//! Fitted against the way along the line, not against the index: the step changes along a line under perspective. At
//! first only positions are known. A fitted corner also knows the direction of its edges, and with both the bend at the
//! end of a line is known several times as well.

use super::lean::Lean;
use super::line_equations::{LineEquations, MOST_POWER, TERMS, derivatives, powers};
use glam::DVec2;
use nalgebra::SMatrix;

/// A position is not believed to be better than this, in px: what a fit without noise leaves.
const LEAST_SIGMA_PX: f64 = 2e-5;
/// What lies so many standard deviations out is no chance.
const CHANCE: f64 = 3.0;
/// The power of a line at most where the lean of its edges is sought.
const LEAN_POWER: usize = 4;
/// However many lines there are, a higher power must leave less than this share of what a lower one leaves.
const MOST_LUCK: f64 = 0.6;

/// A lattice line at a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LatticeLine {
    /// Unit tangent, towards rising index.
    pub(super) tangent: DVec2,
    /// Bend of the line, in 1/px: at distance t along the tangent the line lies at `-curvature t^2 / 2` along the
    /// normal, which is the tangent turned by -90 deg (x, y) -> (y, -x).
    pub(super) curvature: f64,
    /// Corners that it was found from.
    pub(super) corners: usize,
}

/// A corner on a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineCorner {
    pub(super) position: DVec2,
    /// Of the line there, where the corner was fitted.
    pub(super) tangent: Option<Tangent>,
}

/// A fitted edge at a corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tangent {
    /// Towards rising index.
    pub(super) unit: DVec2,
    /// Standard deviation of the corner across the edge, in px.
    pub(super) sigma_px: f64,
    /// Half of the edge that was fitted, in px.
    pub(super) half_px: f64,
    /// By how much the edge turns, in rad, where all edges lie 1 px towards dark: it is a step then, down at one corner and
    /// up at the next ([`lean`]).
    pub(super) turn_per_px: f64,
    /// How far the next parallel lines are, in px.
    pub(super) spacing_px: f64,
}

/// The way along the line from node to node, arc by arc where both ends know their direction, from `own`.
fn ways(nodes: &[LineCorner], own: usize) -> Vec<f64> {
    let mut way = Vec::with_capacity(nodes.len());
    way.push(0.0);
    for pair in nodes.windows(2) {
        let turn = pair[0].tangent.zip(pair[1].tangent).map_or(0.0, |(a, b)| a.unit.perp_dot(b.unit));
        let half = 0.5 * libm::asin(turn.clamp(-1.0, 1.0));
        let over_chord = if half.abs() < 1e-9 { 1.0 } else { half / libm::sin(half) };
        way.push(way[way.len() - 1] + pair[0].position.distance(pair[1].position) * over_chord);
    }
    let start = way[own];
    way.iter_mut().for_each(|w| *w -= start);
    way
}

/// The line at the node `own` as the positions show it, or `None` where it is the only one.
pub(super) fn line(nodes: &[LineCorner], own: usize) -> Option<LatticeLine> {
    let power = match nodes.len() {
        0..=1 => return None,
        2 => 1,
        3 => 2,
        4..=6 => 3,
        _ => 4,
    };
    let (way, centre) = (ways(nodes, own), nodes[own].position);
    let whole = way[way.len() - 1] - way[0];
    let places = way.iter().map(|w| w / whole).zip(nodes.iter().map(|n| n.position - centre));
    let [_, first, second, ..] = fit(places, power)?;
    let speed = first.length();
    // x'y'' - y'x'' over the speed cubed does not depend on how the line is parametrised.
    let curvature = 2.0 * first.perp_dot(second) / (speed * speed * speed);
    curvature.is_finite().then_some(LatticeLine { tangent: first / speed, curvature, corners: nodes.len() })
}

/// Coefficients of p = c0 + c1 t + .. + c_power t^power by least squares; those above `power` are 0.
fn fit(points: impl Iterator<Item = (f64, DVec2)>, power: usize) -> Option<[DVec2; 5]> {
    let mut normal = SMatrix::<f64, 5, 5>::identity();
    let mut right = SMatrix::<f64, 5, 2>::zeros();
    for i in 0..=power {
        normal[(i, i)] = 0.0;
    }
    for (t, p) in points {
        let powers = [1.0, t, t * t, t * t * t, t * t * t * t];
        for i in 0..=power {
            right[(i, 0)] += powers[i] * p.x;
            right[(i, 1)] += powers[i] * p.y;
            for j in 0..=power {
                normal[(i, j)] += powers[i] * powers[j];
            }
        }
    }
    let solved = normal.cholesky()?.solve(&right);
    Some(std::array::from_fn(|i| DVec2::new(solved[(i, 0)], solved[(i, 1)])))
}

/// The powers that a line of so many fitted nodes may have: a node makes two equations, and one at least must be left.
pub(super) fn powers_of(nodes: usize) -> std::ops::RangeInclusive<usize> {
    match nodes {
        0..=2 => 2..=2,
        3 => 3..=4,
        n => 4..=(2 * n - 2).min(MOST_POWER),
    }
}

/// The standard deviation of an edge's direction, in rad: a line fitted over 2 h turns by sqrt(3) / h where it shifts by 1.
fn turn_sigma(tangent: &Tangent) -> f64 {
    3f64.sqrt() * tangent.sigma_px.max(LEAST_SIGMA_PX) / tangent.half_px
}

/// The equations of a line of fitted nodes.
///
/// In the frame of the tangent at the node `own` the line is y = f(t) with the way t, and a node at t says f = y. Its edge
/// was fitted with a constant bend over t - h .. t + h, which turns it by h^2 / 10 times the bend's change a px: it says
/// f' + h^2 / 10 (f''' + bend^2 f') = the sine of its direction.
struct BendRows {
    /// Coefficients of the powers of u = (t - middle) / scale, over the standard deviation, and the value.
    rows: Vec<([f64; TERMS], f64)>,
    /// What a turn of each node's edge by one radian adds to its second row.
    turns: Vec<f64>,
    middle: f64,
    scale: f64,
}

impl BendRows {
    /// `None` where a node was not fitted or is the only one.
    fn new(nodes: &[LineCorner], own: usize) -> Option<Self> {
        // Take the frame of the tangent at the node, and scale the way along the line to -1..1.
        let tangents: Vec<Tangent> = nodes.iter().map(|n| n.tangent).collect::<Option<_>>()?;
        if nodes.len() < 2 {
            return None;
        }
        let (centre, along) = (nodes[own].position, tangents[own].unit);
        let way = ways(nodes, own);
        let (middle, scale) = (0.5 * (way[0] + way[way.len() - 1]), 0.5 * (way[way.len() - 1] - way[0]));

        // Estimate the bend where only its square matters: the turn from the node before to the node after.
        let bends = |i: usize| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(nodes.len() - 1));
            tangents[a].unit.perp_dot(tangents[b].unit) / (way[b] - way[a])
        };

        // Make two rows a node: its position and its direction, over their standard deviations.
        let pair = |(i, ((node, tangent), t)): (usize, ((&LineCorner, &Tangent), &f64))| {
            let powers = powers((t - middle) / scale);
            let sigma = tangent.sigma_px.max(LEAST_SIGMA_PX);
            let turn = turn_sigma(tangent);
            let tenth = 0.1 * tangent.half_px * tangent.half_px;
            let (first, third) = (1.0 + tenth * bends(i) * bends(i), tenth / (scale * scale));
            let (by_one, by_three) = (derivatives(&powers, 1), derivatives(&powers, 3));
            let slope = |k: usize| (first * by_one[k] + third * by_three[k]) / (scale * turn);
            [
                (powers.map(|p| p / sigma), along.perp_dot(node.position - centre) / sigma),
                (std::array::from_fn(slope), along.perp_dot(tangent.unit) / turn),
            ]
        };
        let turns = tangents.iter().map(|t| 1.0 / turn_sigma(t)).collect();
        let mut rows = Vec::with_capacity(2 * nodes.len());
        nodes.iter().zip(&tangents).zip(&way).enumerate().for_each(|node| rows.extend(pair(node)));
        Some(Self { rows, turns, middle, scale })
    }

    /// The sum of the squares that coefficients leave, in standard deviations.
    fn left(&self, c: &[f64; TERMS]) -> f64 {
        let squares = self.rows.iter().map(|(row, value)| {
            let left = row.iter().zip(c).map(|(a, b)| a * b).sum::<f64>() - value;
            left * left
        });
        squares.sum()
    }

    /// The bend of coefficients at the node `own`, and how it depends on each.
    fn bend(&self, c: &[f64; TERMS]) -> (f64, [f64; TERMS]) {
        let here = powers(-self.middle / self.scale);
        let twice = derivatives(&here, 2);
        let sum = |by: &[f64; TERMS]| by.iter().zip(c).map(|(by, c)| c * by).sum::<f64>();
        let square = self.scale * self.scale;
        let first = sum(&derivatives(&here, 1)) / self.scale;
        let arc = 1.0 + first * first;
        let over = 1.0 / (square * arc * arc.sqrt());
        (sum(&twice) * over, twice.map(|by| by * over))
    }
}

/// By how much the edges along a line lie towards dark, in the form of another lean: `None` where the line is too short.
///
/// Light that is clipped, ink that spreads or a wrong transfer curve shift every edge to one side. At a corner dark and bright
/// change sides, so the edge is a step there, and the straight line through it turns by 1.5 / h a px of shift: with one sign
/// at this corner and the other at the next. No smooth line does so; the shift is one more unknown beside its powers.
pub(super) fn lean(nodes: &[LineCorner], own: usize, form: Lean) -> Option<f64> {
    const MOST: usize = 6;
    if nodes.len() < 3 {
        return None;
    }
    let rows = BendRows::new(nodes, own)?;
    let power = LEAN_POWER.min(nodes.len() - 1);
    let one = |t: Tangent| t.turn_per_px * form.of(1.0).at(t.spacing_px);
    let turn = |i: usize| {
        if i.is_multiple_of(2) { 0.0 } else { rows.turns[i / 2] * nodes[i / 2].tangent.map_or(0.0, one) }
    };

    // Solve for the powers and the lean at once.
    let mut normal = SMatrix::<f64, MOST, MOST>::identity();
    let mut right = SMatrix::<f64, MOST, 1>::zeros();
    normal[(power + 1, power + 1)] = 0.0;
    (0..=power).for_each(|i| normal[(i, i)] = 0.0);
    for (number, (row, value)) in rows.rows.iter().enumerate() {
        let column = |i: usize| if i <= power { row[i] } else { turn(number) };
        for i in 0..=power + 1 {
            right[i] += column(i) * value;
            (0..=power + 1).for_each(|j| normal[(i, j)] += column(i) * column(j));
        }
    }
    Some(normal.cholesky()?.solve(&right)[power + 1]).filter(|shift| shift.is_finite())
}

/// For each of [`powers_of`] the sum of the squares, in standard deviations, that a polynomial of that power leaves of a
/// line, and its degrees of freedom.
pub(super) fn left_by_power(nodes: &[LineCorner], own: usize) -> Option<Vec<[f64; 2]>> {
    let rows = BendRows::new(nodes, own)?;
    let powers = powers_of(nodes.len());
    let equations = LineEquations::of(&rows.rows, *powers.end());
    let left = |power: usize| {
        let c = equations.solve(power)?;
        Some([rows.left(&c), (rows.rows.len() - power - 1) as f64])
    };
    powers.map(left).collect()
}

/// The least of some powers that no higher one explains better than chance would, given what each leaves: noise asks for
/// few powers, a strong bend for many. The number of the power in `left`.
pub(super) fn least_power(left: &[[f64; 2]]) -> usize {
    let mean = |k: usize| left[k][0] / left[k][1];
    let enough = |k: usize| {
        let (squares, freedom) = (left[k][0], left[k][1]);
        let higher = |q: usize| mean(q) < mean(k) * luck(left[q][1]).min(MOST_LUCK);
        squares <= freedom + 2.0 * (2.0 * freedom).sqrt() || !(k + 1..left.len()).any(higher)
    };
    (0..left.len()).find(|&k| enough(k)).unwrap_or(0)
}

/// Below this share of its expectation lies the mean square of `freedom` normal deviates once in a hundred times (Wilson
/// and Hilferty's approximation).
fn luck(freedom: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom);
    let root = (1.0 - spread - 2.326 * spread.sqrt()).max(0.0);
    root * root * root
}

/// The bend at the node `own`, in 1/px, of the polynomial of least squares; `None` where some node was not fitted.
pub(super) fn bend(nodes: &[LineCorner], own: usize, power: usize) -> Option<f64> {
    let rows = BendRows::new(nodes, own)?;
    let (curvature, _) = rows.bend(&LineEquations::of(&rows.rows, power).solve(power)?);
    curvature.is_finite().then_some(curvature)
}

/// How far that bend may be off, in 1/px, as a standard deviation: by what the nodes err, and by the next higher power, as far
/// as that says more than their errors do. The nodes' squared errors are `least_scale` times what is told at least.
pub(super) fn bend_doubt(nodes: &[LineCorner], own: usize, power: usize, least_scale: f64) -> Option<f64> {
    let rows = BendRows::new(nodes, own)?;
    let more = power < MOST_POWER && rows.rows.len() > power + 2;
    let equations = LineEquations::of(&rows.rows, power + usize::from(more));
    let at = |power: usize| {
        let c = equations.solve(power)?;
        let (bend, by) = rows.bend(&c);
        let freedom = (rows.rows.len() - power - 1) as f64;
        // The errors are as told, unless they leave more than chance would.
        let scale = scale_of(rows.left(&c) / freedom.max(1.0), freedom.max(1.0));
        Some((bend, equations.variance(power, &by), scale.max(least_scale)))
    };
    let (bend, variance, scale) = at(power)?;
    let higher = if more { at(power + 1) } else { None };
    let more = higher.map_or(0.0, |(other, wider, scale)| {
        let change = other - bend;
        (change * change - CHANCE * CHANCE * scale * (wider - variance).max(0.0)).max(0.0)
    });
    let doubt = (variance * scale + more).sqrt();
    doubt.is_finite().then_some(doubt)
}

/// By how much squared errors are larger than told, whose mean square over so many degrees of freedom is `mean` in their unit: 1 where
/// chance may make it.
pub(super) fn scale_of(mean: f64, freedom: f64) -> f64 {
    if mean > 1.0 + CHANCE * (2.0 / freedom).sqrt() { mean } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIDDLE: DVec2 = DVec2::new(700.0, 300.0);

    fn along(unit: DVec2) -> Tangent {
        Tangent { unit, sigma_px: 1e-3, half_px: 20.0, turn_per_px: 0.0, spacing_px: 50.0 }
    }

    /// Corners on a circle of radius 500 px, at uneven steps, with their directions.
    fn circle() -> Vec<LineCorner> {
        let node = |i: usize| {
            let (sin, cos) = libm::sincos(0.1 * i as f64 + 0.004 * (i * i) as f64);
            let outward = DVec2::new(cos, sin);
            LineCorner { position: MIDDLE + 500.0 * outward, tangent: Some(along(outward.perp())) }
        };
        (0..9).map(node).collect()
    }

    #[test]
    fn positions_show_the_bend_of_a_circle() {
        let nodes = circle();
        for (i, node) in nodes.iter().enumerate() {
            let line = line(&nodes, i).unwrap();
            let normal = DVec2::new(line.tangent.y, -line.tangent.x);
            let outward = (node.position - MIDDLE).normalize();
            // With rising angle the normal points outward, and the line falls away behind it. A line bent by a whole
            // radian is the hardest asked for: a tenth of that is a strong prism.
            assert!(normal.dot(outward) > 0.9999, "{i} {line:?} {outward}");
            assert!((line.curvature - 1.0 / 500.0).abs() < 4e-5, "{i} {}", line.curvature);
        }
    }

    #[test]
    fn directions_show_it_at_the_ends_as_well() {
        let nodes = circle();
        for own in 0..nodes.len() {
            let curvature = bend(&nodes, own, MOST_POWER).unwrap();
            // A circle over more than half a radian to each side is no polynomial: 0.6^8 / 8! at the ends, twice derived.
            assert!((curvature * 500.0 - 1.0).abs() < 1e-3, "{own} {curvature}");
        }
    }

    #[test]
    fn noise_asks_for_few_powers_and_a_strong_bend_for_many() {
        let known_to = |sigma_px: f64| {
            let node = |n: &LineCorner| LineCorner { tangent: n.tangent.map(|t| Tangent { sigma_px, ..t }), ..*n };
            left_by_power(&circle().iter().map(node).collect::<Vec<_>>(), 4).unwrap()
        };
        // A thousandth of a pixel does not tell the circle from a polynomial of power 4, a ten-thousandth does.
        assert_eq!(least_power(&known_to(1e-3)), 0);
        assert!(least_power(&known_to(1e-4)) > 1, "{:?}", known_to(1e-4));
        // On a straight line with errors of their own standard deviation, alternately to both sides.
        let noisy: Vec<LineCorner> = (0..9)
            .map(|i| LineCorner {
                position: DVec2::new(50.0 * f64::from(i), if i % 2 == 0 { 1e-3 } else { -1e-3 }),
                tangent: Some(along(DVec2::X)),
            })
            .collect();
        assert_eq!(least_power(&left_by_power(&noisy, 4).unwrap()), 0);
        // The same with ten times the error that the fits know of: no power explains it.
        let unknown: Vec<LineCorner> =
            noisy.iter().map(|n| LineCorner { position: n.position * DVec2::new(1.0, 10.0), ..*n }).collect();
        assert_eq!(least_power(&left_by_power(&unknown, 4).unwrap()), 0);
    }

    #[test]
    fn a_lone_or_unfitted_corner_has_no_line() {
        let nodes = circle();
        assert_eq!(line(&nodes[..1], 0), None);
        assert_eq!(bend(&nodes[..1], 0, 2), None);
        let mut unfitted = nodes;
        unfitted[3].tangent = None;
        assert_eq!(bend(&unfitted, 4, 4), None);
    }
}
