//! The direction and the bend of a lattice line at a corner, from the corners along it.
//!
//! Fitted against the way along the line, not against the index: the step changes along a line under perspective.

use super::grid::Lattice;
use glam::{DVec2, IVec2};
use nalgebra::SMatrix;

/// Corners along a line that are used at most: the corner and the nearest ones.
const MOST: usize = 9;

/// A lattice line at a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// Unit tangent, towards rising index.
    pub(super) tangent: DVec2,
    /// Bend of the line, in 1/px: at distance t along the tangent the line lies at `-curvature t^2 / 2` along the
    /// normal, which is the tangent turned by -90 deg (x, y) -> (y, -x).
    pub(super) curvature: f64,
    /// Corners that it was found from.
    pub(super) corners: usize,
}

/// The line through `cell` along `direction` (`IVec2::X` or `IVec2::Y`), or `None` where `cell` has no neighbour on it.
pub(super) fn line(
    lattice: &Lattice,
    position: impl Fn(usize) -> DVec2,
    cell: IVec2,
    direction: IVec2,
) -> Option<Line> {
    let at = |offset: i32| lattice.get(&(cell + direction * offset).to_array()).map(|&k| position(k));
    let centre = at(0)?;
    // Outwards on both sides in turn, each side until its first gap.
    let mut reach = [0, 0];
    let mut open = [true, true];
    while open != [false, false] && ((reach[0] + reach[1]) as usize) < MOST - 1 {
        for (side, sign) in [(0, -1), (1, 1)] {
            if open[side] && ((reach[0] + reach[1]) as usize) < MOST - 1 {
                open[side] = at(sign * (reach[side] + 1)).is_some();
                reach[side] += i32::from(open[side]);
            }
        }
    }
    let points: Vec<DVec2> = (-reach[0]..=reach[1]).filter_map(at).collect();
    let power = match points.len() {
        0..=1 => return None,
        2 => 1,
        3 => 2,
        4..=6 => 3,
        _ => 4,
    };
    // The way along the line from the corner, chord by chord, in units of the whole.
    let mut way: Vec<f64> = points
        .windows(2)
        .scan(0.0, |sum, pair| {
            *sum += pair[0].distance(pair[1]);
            Some(*sum)
        })
        .collect();
    way.insert(0, 0.0);
    let (whole, own) = (way[way.len() - 1], way[reach[0] as usize]);
    let [_, first, second, ..] =
        fit(way.iter().map(|w| (w - own) / whole).zip(points.iter().map(|&p| p - centre)), power)?;
    let speed = first.length();
    // x'y'' - y'x'' over the speed cubed does not depend on how the line is parametrised.
    let curvature = 2.0 * first.perp_dot(second) / (speed * speed * speed);
    curvature.is_finite().then_some(Line { tangent: first / speed, curvature, corners: points.len() })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners on a circle of radius 500 px, at uneven steps.
    fn circle() -> (Lattice, Vec<DVec2>) {
        let points: Vec<DVec2> = (0..11)
            .map(|i| {
                let (sin, cos) = libm::sincos(0.1 * i as f64 + 0.004 * (i * i) as f64);
                DVec2::new(700.0, 300.0) + 500.0 * DVec2::new(cos, sin)
            })
            .collect();
        ((0..11).map(|i| ([i as i32, 0], i)).collect(), points)
    }

    #[test]
    fn the_bend_of_a_circle_is_one_over_its_radius() {
        let (lattice, points) = circle();
        for (i, &point) in points.iter().enumerate() {
            let line = line(&lattice, |k| points[k], IVec2::new(i as i32, 0), IVec2::X).unwrap();
            let normal = DVec2::new(line.tangent.y, -line.tangent.x);
            let outward = (point - DVec2::new(700.0, 300.0)).normalize();
            // With rising angle the normal points outward, and the line falls away behind it. A line bent by a whole
            // radian is the hardest asked for: a tenth of that is a strong prism.
            assert!(normal.dot(outward) > 0.9999, "{i} {line:?} {outward}");
            assert!((line.curvature - 1.0 / 500.0).abs() < 4e-5, "{i} {}", line.curvature);
        }
    }

    #[test]
    fn a_lone_corner_has_no_line() {
        let lattice = Lattice::from([([0, 0], 0)]);
        assert_eq!(line(&lattice, |_| DVec2::ZERO, IVec2::ZERO, IVec2::X), None);
    }
}
