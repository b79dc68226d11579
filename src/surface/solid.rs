//! The watertight body between a lower and an upper surface over a rectangle, as triangles.

use crate::geom::Rect;
use glam::{DVec2, DVec3};

/// A closed body of triangles: every edge belongs to two of them, which run along it in opposite senses; seen from outside
/// their corners go round anticlockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Corners, in mm.
    pub points_mm: Vec<DVec3>,
    /// The corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// A grid over a rectangle whose middle column is x = 0.
struct Cells {
    outline: Rect,
    size: [usize; 2],
}

impl Cells {
    fn place(&self, i: usize, j: usize) -> DVec2 {
        let [columns, rows] = self.size;
        // From both borders towards the middle, so that it is its own mirror image, bit for bit.
        let share = |k: usize, n: usize| (2.0 * k as f64 - n as f64) / n as f64;
        let Rect { min, max } = self.outline;
        0.5 * (min + max) + 0.5 * (max - min) * DVec2::new(share(i, columns), share(j, rows))
    }

    /// The number of a corner of the lower or of the upper sheet.
    fn name(&self, upper: bool, i: usize, j: usize) -> u32 {
        let [columns, rows] = self.size.map(|n| n + 1);
        (usize::from(upper) * columns * rows + j * columns + i) as u32
    }

    /// Two triangles a cell, cut alike in both halves.
    fn sheet(&self, upper: bool) -> impl Iterator<Item = [u32; 3]> + '_ {
        let [columns, rows] = self.size;
        (0..rows).flat_map(move |j| (0..columns).map(move |i| (i, j))).flat_map(move |(i, j)| {
            let at = |i: usize, j: usize| self.name(upper, i, j);
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let two = if 2 * i < columns { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] };
            two.map(|[a, b, c]| if upper { [a, b, c] } else { [a, c, b] })
        })
    }

    /// The upright walls along the border, anticlockwise from above.
    fn walls(&self) -> Vec<[u32; 3]> {
        let [columns, rows] = self.size;
        let around = (0..columns).map(|i| [i, 0]).chain((0..rows).map(|j| [columns, j]));
        let around = around.chain((0..columns).map(|i| [columns - i, rows])).chain((0..rows).map(|j| [0, rows - j]));
        let places: Vec<[usize; 2]> = around.collect();
        let pairs = (0..places.len()).map(|k| [places[k], places[(k + 1) % places.len()]]);
        let wall = |[from, to]: [[usize; 2]; 2]| {
            let [low, high] = [false, true].map(|upper| [from, to].map(|[i, j]| self.name(upper, i, j)));
            [[high[1], high[0], low[0]], [high[1], low[0], low[1]]]
        };
        pairs.flat_map(wall).collect()
    }
}

impl Solid {
    /// The body over `outline`, which reaches as far to both sides of x = 0, cut into `size` cells along x (an even number) and
    /// y. `heights` gives the lower and the upper z over (x, y), in mm. The places where they are taken are passed on to it
    /// in the end: the error is the first place where the lower is not below the upper, or where there is none.
    ///
    /// # Errors
    /// That place.
    pub fn between(
        outline: Rect,
        size: [usize; 2],
        heights: impl Fn(DVec2) -> Option<[f64; 2]>,
    ) -> Result<Self, DVec2> {
        let cells = Cells { outline, size };
        let [columns, rows] = size;
        let count = (columns + 1) * (rows + 1);
        let mut points_mm = vec![DVec3::ZERO; 2 * count];
        for (i, j) in (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j))) {
            let at = cells.place(i, j);
            let [low, high] = heights(at).filter(|[low, high]| low < high).ok_or(at)?;
            points_mm[cells.name(false, i, j) as usize] = at.extend(low);
            points_mm[cells.name(true, i, j) as usize] = at.extend(high);
        }
        let triangles = cells.sheet(false).chain(cells.sheet(true)).chain(cells.walls()).collect();
        Ok(Self { points_mm, triangles })
    }

    /// The volume within, in mm^3, by the divergence theorem.
    pub fn volume_mm3(&self) -> f64 {
        // About one of its points, so that little cancels.
        let origin = self.points_mm.first().copied().unwrap_or_default();
        let corner = |k: u32| self.points_mm[k as usize] - origin;
        self.triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn body(cells: usize) -> Solid {
        let outline = Rect { min: DVec2::new(-2.0, -1.0), max: DVec2::new(2.0, 3.0) };
        Solid::between(outline, [2 * cells, cells], |at| Some([0.1 * at.x * at.x, 3.0 + 0.2 * at.y * at.y]))
            .expect("it is one")
    }

    #[test]
    fn every_edge_is_shared_by_two_triangles_of_opposite_sense() {
        let solid = body(7);
        let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
        for &[a, b, c] in &solid.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *edges.entry([from, to]).or_default() += 1;
            }
        }
        assert!(edges.iter().all(|(&[from, to], count)| *count == 1 && edges.get(&[to, from]) == Some(&1)));
        // Euler's characteristic of a sphere.
        let [v, e, f] = [solid.points_mm.len(), edges.len() / 2, solid.triangles.len()].map(|n| n as i64);
        assert_eq!(v - e + f, 2);
    }

    /// 48 + 0.2 y^2 - 0.1 x^2 over it: 4 x 4 x 3 + 0.2 x 4 x 28/3 - 0.1 x 4 x 16/3.
    #[test]
    fn the_volume_converges_with_the_square_of_the_cells() {
        let exact = 48.0 + 0.2 * 4.0 * 28.0 / 3.0 - 0.1 * 4.0 * 16.0 / 3.0;
        let off = |cells: usize| body(cells).volume_mm3() - exact;
        let (coarse, fine) = (off(8), off(16));
        assert!(body(8).volume_mm3() > 0.0 && coarse.abs() > 1e-3);
        assert!((coarse / fine - 4.0).abs() < 1e-6, "{coarse} {fine}");
    }

    #[test]
    fn a_body_that_pinches_to_nothing_is_refused_with_the_place() {
        let outline = Rect { min: DVec2::new(-1.0, 0.0), max: DVec2::new(1.0, 1.0) };
        let found = Solid::between(outline, [4, 1], |at| Some([at.x, 0.4]));
        assert_eq!(found, Err(DVec2::new(0.5, 0.0)));
    }
}
