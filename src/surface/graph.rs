//! Triangles that are a graph z(x, y) over a convex region: a ray that is steeper than they are meets them once, so that what is
//! found by Newton's method, from triangle to triangle over a grid of cells, is what the ray first meets.
//!
//! Every triangle lies on one side of each edge that another shares, none stands upright, and the edges that belong to one
//! triangle alone run once round a convex polygon. A place within that is then under as many triangles as the border runs round
//! it (the degree of the projection, to which each adds one): under one.

use super::normals::{EdgeOf, by_edge};
use crate::geom::Ray;
use crate::num::simd::Lanes;
use glam::{DVec2, DVec3};

/// A grid of cells over the triangles of a graph.
#[derive(Debug)]
pub(super) struct Graph {
    low: DVec2,
    cells_per_mm: DVec2,
    columns: usize,
    rows: usize,
    /// Where the triangles of each cell begin in `ids`, row by row.
    starts: Vec<u32>,
    ids: Vec<u32>,
    /// The largest slope of a triangle.
    steepest: f64,
    /// The middle of their heights, in mm.
    level_mm: f64,
    /// Half of what they span.
    half_height_mm: f64,
}

/// Distance, the triangle, and the weights of its corners.
pub(super) type Met = (f64, usize, [f64; 3]);

/// A ray must be steeper than the triangles by this share.
const STEEPER: f64 = 1.01;
/// A corner of the border may be concave by such an angle, in rad, for the rounding of its places.
const ROUNDING_RAD: f64 = 1e-6;
/// Steps of Newton's method, after which a ray takes the hierarchy.
const MOST_STEPS: usize = 6;
/// The triangles of the first cell are asked where the mesh is met within so many cells of it.
const MOST_SPREAD: f64 = 0.5;
/// A triangle belongs to the cells within this share of a cell around it.
const RIM: f64 = 1e-6;

impl Graph {
    /// The grid over these triangles, given each edge with each of its triangles in order; `None` where they are no graph over a
    /// convex region.
    pub(super) fn new(points: &[DVec3], triangles: &[[u32; 3]], edges: &[EdgeOf]) -> Option<Self> {
        let at = |k: u32| points[k as usize];
        let steepest = steepest(points, triangles)?;
        let mut border = Vec::new();
        for group in by_edge(edges) {
            let ([p, q], _) = group[0];
            let side = |id: u32| {
                let opposite = triangles[id as usize].into_iter().find(|k| *k != p && *k != q)?;
                let edge = (at(q) - at(p)).truncate();
                Some(edge.perp_dot((at(opposite) - at(p)).truncate()))
            };
            match group {
                [_] => border.push([p, q]),
                [(_, a), (_, b)] if side(*a)? * side(*b)? < 0.0 => (),
                _ => return None,
            }
        }
        if !is_convex(points, &border) {
            return None;
        }

        // Lay a grid of about as many cells as triangles over them.
        let (low, high) =
            points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let size = (high - low).truncate();
        let cells_per_mm = (triangles.len() as f64 / (size.x * size.y)).sqrt();
        let [columns, rows] =
            [size.x, size.y].map(|mm| ((mm * cells_per_mm).ceil() as usize).clamp(1, triangles.len()));
        let mut grid = Self {
            low: low.truncate(),
            cells_per_mm: DVec2::new(columns as f64, rows as f64) / size,
            columns,
            rows,
            starts: vec![0; columns * rows + 1],
            ids: Vec::new(),
            steepest,
            level_mm: 0.5 * (low.z + high.z),
            half_height_mm: 0.5 * (high.z - low.z),
        };
        grid.fill(points, triangles);
        Some(grid)
    }

    /// Lists the triangles of each cell.
    fn fill(&mut self, points: &[DVec3], triangles: &[[u32; 3]]) {
        // Count them, then place them.
        let cells = |grid: &Self, triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|k| (points[k as usize].truncate() - grid.low) * grid.cells_per_mm);
            let [from, to] = [a.min(b).min(c) - RIM, a.max(b).max(c) + RIM];
            let columns = grid.column(from.x)..=grid.column(to.x);
            let width = grid.columns;
            (grid.row(from.y)..=grid.row(to.y)).flat_map(move |j| columns.clone().map(move |i| j * width + i))
        };
        for triangle in triangles {
            for cell in cells(self, triangle) {
                self.starts[cell + 1] += 1;
            }
        }
        for cell in 1..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
        let mut next = self.starts.clone();
        self.ids = vec![0; self.starts[self.starts.len() - 1] as usize];
        for (id, triangle) in triangles.iter().enumerate() {
            for cell in cells(self, triangle) {
                self.ids[next[cell] as usize] = id as u32;
                next[cell] += 1;
            }
        }
    }

    #[inline(always)]
    fn column(&self, x: f64) -> usize {
        (x.max(0.0) as usize).min(self.columns - 1)
    }

    #[inline(always)]
    fn row(&self, y: f64) -> usize {
        (y.max(0.0) as usize).min(self.rows - 1)
    }

    /// Where a ray that is steeper than the graph meets it, within a triangle: `within` intersects one, `plane` is a point of it and
    /// its normal. `None` of all other rays, and of those that Newton's method leads nowhere.
    #[inline(always)]
    pub(super) fn meet(
        &self,
        ray: &Ray,
        within: impl Fn(usize) -> Option<(f64, [f64; 3])>,
        plane: impl Fn(usize) -> (DVec3, DVec3),
    ) -> Option<Met> {
        let (origin, along) = (ray.origin.truncate(), ray.direction.truncate());
        if STEEPER * self.steepest * along.length() >= ray.direction.z.abs() {
            return None;
        }
        let cell_at = |t: f64| {
            let place = (origin + along * t - self.low) * self.cells_per_mm;
            self.row(place.y) * self.columns + self.column(place.x)
        };
        let met_in = |cell: usize| {
            self.of_cell(cell)
                .iter()
                .filter_map(|&id| within(id as usize).map(|(t, weights)| (t, id as usize, weights)))
        };

        // On an edge the nearest of those that have it is taken, of those at one distance the first.
        let nearest_of = |met: Met| {
            if met.2.iter().all(|weight| *weight != 0.0) {
                return Some(met);
            }
            met_in(cell_at(met.0)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
        };

        // The first plane leads near; of its cell's triangles none is asked unless all heights are met in it or beside it.
        let inverse = 1.0 / ray.direction.z;
        let mut cell = cell_at((self.level_mm - ray.origin.z) * inverse);
        let spread = (along * (inverse * self.half_height_mm) * self.cells_per_mm).abs().max_element();
        if spread < MOST_SPREAD
            && let Some(met) = met_in(cell).next()
        {
            return nearest_of(met);
        }
        for step in 0..MOST_STEPS {
            let (point, normal) = plane(*self.of_cell(cell).first()? as usize);
            let next = cell_at((point - ray.origin).dot(normal) / ray.direction.dot(normal));
            if step > 0 && next == cell {
                return None;
            }
            cell = next;
            if let Some(met) = met_in(cell).next() {
                return nearest_of(met);
            }
        }
        None
    }

    /// What the slope of rays must exceed, in every lane.
    #[inline(always)]
    pub(super) fn steepness(&self) -> Lanes {
        Lanes::splat(STEEPER * self.steepest)
    }

    /// [`MOST_SPREAD`] in every lane.
    #[inline(always)]
    pub(super) fn most_spread() -> Lanes {
        Lanes::splat(MOST_SPREAD)
    }

    /// The lowest corner and the cells in a mm along x and y; the middle of the heights and half of what they span.
    #[inline(always)]
    pub(super) fn frame(&self) -> ([[Lanes; 2]; 2], [Lanes; 2]) {
        let both = |v: DVec2| [Lanes::splat(v.x), Lanes::splat(v.y)];
        ([both(self.low), both(self.cells_per_mm)], [self.level_mm, self.half_height_mm].map(Lanes::splat))
    }

    /// The triangles of the cell at a place, in cells.
    #[inline(always)]
    pub(super) fn cell_of(&self, x: f64, y: f64) -> &[u32] {
        self.of_cell(self.row(y) * self.columns + self.column(x))
    }

    /// The triangles of a cell.
    #[inline(always)]
    fn of_cell(&self, cell: usize) -> &[u32] {
        &self.ids[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}

/// The largest slope of a triangle; `None` where one stands upright.
fn steepest(points: &[DVec3], triangles: &[[u32; 3]]) -> Option<f64> {
    triangles.iter().try_fold(0.0, |steepest: f64, triangle| {
        let [a, b, c] = triangle.map(|k| points[k as usize]);
        let normal = (b - a).cross(c - a);
        let slope = normal.truncate().length() / normal.z.abs();
        slope.is_finite().then_some(steepest.max(slope))
    })
}

/// Whether these edges run once round a convex polygon.
fn is_convex(points: &[DVec3], border: &[[u32; 2]]) -> bool {
    // Every corner of it has two edges.
    let mut by_corner: Vec<(u32, u32)> = border.iter().flat_map(|&[p, q]| [(p, q), (q, p)]).collect();
    by_corner.sort_unstable();
    let (pairs, rest) = by_corner.as_chunks::<2>();
    let twice = |pair: &[(u32, u32); 2]| pair[0].0 == pair[1].0;
    let alone = pairs.windows(2).all(|two| two[0][0].0 != two[1][0].0);
    if pairs.is_empty() || !rest.is_empty() || !pairs.iter().all(twice) || !alone {
        return false;
    }

    // Walk round it, and sum up its turns.
    let ends =
        |corner: u32| pairs.binary_search_by_key(&corner, |pair| pair[0].0).ok().map(|k| pairs[k].map(|(_, end)| end));
    let first = pairs[0][0].0;
    let (mut last, mut here) = (first, pairs[0][0].1);
    let (mut turned, mut least, mut most) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for passed in 1..=pairs.len() {
        let Some([a, b]) = ends(here) else { return false };
        let next = if a == last { b } else { a };
        let way = |from: u32, to: u32| (points[to as usize] - points[from as usize]).truncate();
        let (come, go) = (way(last, here), way(here, next));
        let turn = libm::atan2(come.perp_dot(go), come.dot(go));
        (turned, least, most) = (turned + turn, f64::min(least, turn), f64::max(most, turn));
        (last, here) = (here, next);
        // Back before all corners were passed: there are several borders.
        if (last == first) != (passed == pairs.len()) {
            return false;
        }
    }
    let one_way = least >= -ROUNDING_RAD || most <= ROUNDING_RAD;
    one_way && turned.abs() < 1.5 * std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::super::mesh::{Mesh, Triangles};
    use super::super::normals::{Normals, edges};
    use super::*;
    use crate::geom::Rect;

    /// A wavy sheet over a square of 20 mm, 80 mm away.
    fn sheet(cells: usize) -> Triangles {
        let square = Rect { min: DVec2::splat(-10.0), max: DVec2::splat(10.0) };
        Triangles::over(square, cells, |x, y| (80.0 + 0.3 * libm::sin(x) * libm::cos(y), DVec3::Z))
    }

    fn is_graph(own: &Triangles) -> bool {
        Graph::new(&own.points_mm, &own.triangles, &edges(&own.triangles)).is_some()
    }

    /// Rays of many inclinations meet the triangle that the hierarchy finds, with the same bits, and mostly without it.
    #[test]
    fn what_is_met_is_what_the_hierarchy_finds() {
        for cells in [1, 7, 40] {
            let mesh = Mesh::new(sheet(cells), Normals::Flat);
            let (mut alone, mut met) = (0, 0);
            for k in 0..20_000 {
                let at = |alpha: f64| 2.0 * (alpha * f64::from(k + 1)).fract() - 1.0;
                let origin = DVec3::new(30.0 * at(0.754_877_666), 30.0 * at(0.569_840_29), 60.0 * at(0.438_447_187));
                let target = DVec3::new(11.0 * at(0.3247), 11.0 * at(0.6823), 80.0);
                let ray = Ray { origin, direction: (target - origin).normalize() };
                let [by_graph, by_hierarchy] = mesh.met_both_ways(&ray);
                met += usize::from(by_hierarchy.is_some());
                if by_graph.is_some() {
                    alone += 1;
                    assert_eq!(by_graph, by_hierarchy, "{cells} {k}");
                }
            }
            assert!(met > 10_000 && alone as f64 > 0.9 * met as f64, "{cells}: {alone} of {met}");
        }
    }

    /// At corners and on edges, where several triangles are met, it is the same one.
    #[test]
    fn on_edges_the_same_triangle_is_met() {
        let mesh = Mesh::new(sheet(40), Normals::Flat);
        let own = mesh.own();
        let mut alone = 0;
        let mut meets = |target: DVec3| {
            for origin in [target - 30.0 * DVec3::Z, DVec3::new(0.5, -0.25, 16.0)] {
                let ray = Ray { origin, direction: (target - origin).normalize() };
                let [by_graph, by_hierarchy] = mesh.met_both_ways(&ray);
                assert!(by_graph.is_none() || by_graph == by_hierarchy, "{target}: {by_graph:?} {by_hierarchy:?}");
                alone += usize::from(by_graph.is_some_and(|(_, _, weights)| weights.contains(&0.0)));
            }
        };
        for triangle in &own.triangles {
            let [a, b, c] = triangle.map(|k| own.points_mm[k as usize]);
            [a, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)].into_iter().for_each(&mut meets);
        }
        assert!(alone > 5_000, "{alone}");
    }

    /// What a steep ray may meet twice, or what is no sheet, is none.
    #[test]
    fn only_graphs_over_convex_regions_are() {
        assert!(is_graph(&sheet(1)) && is_graph(&sheet(5)));
        let without = |id: usize| {
            let mut own = sheet(5);
            own.triangles.remove(id);
            own
        };
        // A hole, a notch, and a corner cut off, which leaves a convex border.
        assert!(!is_graph(&without(24)) && !is_graph(&without(4)));
        let mut cut = sheet(1);
        cut.triangles.truncate(1);
        assert!(is_graph(&cut));
        // Folded over, doubled, and with a second sheet behind it.
        let mut folded = sheet(5);
        folded.points_mm[14].x = -20.0;
        assert!(!is_graph(&folded));
        let mut doubled = sheet(5);
        doubled.triangles.extend(sheet(5).triangles);
        assert!(!is_graph(&doubled));
        let mut two = sheet(5);
        let behind = two.points_mm.len() as u32;
        two.points_mm.extend(sheet(5).points_mm.iter().map(|p| *p + DVec3::Z));
        two.triangles.extend(sheet(5).triangles.iter().map(|t| t.map(|k| k + behind)));
        assert!(!is_graph(&two));
    }
}
