//! Where a design is held against its law: pixels of the upper half, and points of the lens's opening.

use crate::num::quadrature::gauss_legendre;

/// A place of the half image with v > 0, from its middle, and the square root of its share of the mean square.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PixelNode {
    pub(super) u_mm: f64,
    pub(super) v_mm: f64,
    pub(super) weight: f64,
}

/// Places and weights of Gauss and Legendre with `n` nodes over -1 .. 1, moved outwards so that the outermost lie on the edge:
/// a polynomial that is held only inside runs away at the edge.
fn stretched(n: usize) -> Vec<[f64; 2]> {
    let rule = gauss_legendre(n);
    let outermost = rule.iter().map(|[s, _]| (2.0 * s - 1.0).abs()).fold(0.0, f64::max);
    rule.iter().map(|[s, w]| [(2.0 * s - 1.0) / outermost, *w]).collect()
}

/// `columns` x `rows` nodes over the half image with the half widths `half_mm`; the rows are those above its middle.
pub(super) fn nodes(half_mm: [f64; 2], columns: usize, rows: usize) -> Vec<PixelNode> {
    let upper: Vec<_> = stretched(2 * rows).into_iter().filter(|[t, _]| *t > 0.0).collect();
    let node = |[s, ws]: [f64; 2], [t, wt]: [f64; 2]| PixelNode {
        u_mm: half_mm[0] * s,
        v_mm: half_mm[1] * t,
        weight: (2.0 * ws * wt).sqrt(),
    };
    let across = stretched(columns);
    upper.iter().flat_map(|t| across.iter().map(|s| node(*s, *t))).collect()
}

/// How many columns and rows hold surfaces of degree `degree`.
pub(super) fn columns_and_rows(degree: usize) -> [usize; 2] {
    [degree + 6, (degree + 6) / 2 + 2]
}

/// Rays of a spot.
pub(super) const SPOT_RAYS: usize = 12;

/// Points over a disk of radius 1, each of the same share: two hexagons whose squared radii are nodes of Gauss and Legendre, so that
/// the mean of a polynomial is exact to the fifth degree, that of defocus, astigmatism, coma and their squares among them. They are their
/// own mirror images, so that the surfaces that they meet are met as far up as down.
pub(super) fn opening() -> [[f64; 2]; SPOT_RAYS] {
    let rings = gauss_legendre(2);
    std::array::from_fn(|k| {
        let radius = rings[k % 2][0].sqrt();
        let (sin, cos) = libm::sincos(std::f64::consts::PI * k as f64 / 6.0);
        [radius * cos, radius * sin]
    })
}
