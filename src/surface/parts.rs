//! Parts of a surface of triangles: facets, between which the normal that refracts may jump, and their pieces, between which
//! it may have a kink.

use super::normals::{EdgeOf, Normals, Sets, by_edge, normal};
use glam::DVec3;

/// Triangles whose unit normals differ by less than this lie in one plane.
const SAME_PLANE: f64 = 1e-12;

/// Which of several parts each triangle belongs to: nothing where all are one.
#[derive(Debug, Clone, Default)]
pub(super) struct Parts {
    names: Vec<u32>,
    count: usize,
}

impl Parts {
    fn of(names: Vec<u32>) -> Self {
        let most = names.iter().max().map_or(0, |name| *name as usize);
        let mut found = vec![false; most + 1];
        names.iter().for_each(|name| found[*name as usize] = true);
        let count = found.into_iter().filter(|found| *found).count();
        if count > 1 { Self { names, count } } else { Self::default() }
    }

    /// The part that a triangle belongs to.
    pub(super) fn name(&self, triangle: u32) -> u32 {
        self.names.get(triangle as usize).copied().unwrap_or(0)
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.count.max(1)
    }
}

/// The pieces of a surface by smooth normals, given its edges and the normals of its corners: what lies in one plane and refracts by one normal,
/// and each other triangle by itself. At its sides the normal that refracts has a kink.
pub(super) fn pieces(points: &[DVec3], triangles: &[[u32; 3]], edges: &[EdgeOf], at_corners: &[DVec3]) -> Parts {
    let mut sets = Sets::of_one(triangles.len());
    let same = |a: DVec3, b: DVec3| (a - b).length() < SAME_PLANE;
    let corners = |id: u32| triangles[id as usize].map(|k| at_corners[k as usize]);
    let own = |id: u32| normal(points, &triangles[id as usize]);
    for group in by_edge(edges) {
        for pair in group.windows(2) {
            let [a, b] = [pair[0].1, pair[1].1];
            let alike = corners(a).into_iter().chain(corners(b)).all(|normal| same(normal, corners(a)[0]));
            if alike && same(own(a), own(b)) {
                sets.unite(a, b);
            }
        }
    }
    Parts::of((0..triangles.len() as u32).map(|id| sets.name(id)).collect())
}

/// The facets of a surface, given its edges: of smooth normals what shares corners, of flat ones what lies in one plane. At their sides the
/// normal that refracts may jump.
pub(super) fn facets(points: &[DVec3], triangles: &[[u32; 3]], edges: &[EdgeOf], refracting: Normals) -> Parts {
    let facets: Vec<u32> = match refracting {
        Normals::Smooth => {
            let mut sets = Sets::of_one(points.len());
            for [a, b, c] in triangles {
                sets.unite(*a, *b);
                sets.unite(*a, *c);
            }
            triangles.iter().map(|t| sets.name(t[0])).collect()
        }
        Normals::Flat => {
            let mut sets = Sets::of_one(triangles.len());
            let normals: Vec<DVec3> = triangles.iter().map(|triangle| normal(points, triangle)).collect();
            for group in by_edge(edges) {
                for pair in group.windows(2) {
                    let [a, b] = [pair[0].1, pair[1].1];
                    if (normals[a as usize] - normals[b as usize]).length() < SAME_PLANE {
                        sets.unite(a, b);
                    }
                }
            }
            (0..triangles.len() as u32).map(|id| sets.name(id)).collect()
        }
    };
    Parts::of(facets)
}

#[cfg(test)]
mod tests {
    use super::super::normals::tests::{Own, grid};
    use super::super::normals::{corner_normals, edges, part_at_creases};
    use super::*;

    #[test]
    fn facets_are_planes_of_flat_normals_and_connected_parts_of_smooth_ones() {
        let (mut points, mut triangles) = grid(10, 0.0, |p| 0.1 * p.x.abs());
        let count = |points: &[DVec3], triangles: &[[u32; 3]], normals| {
            facets(points, triangles, &edges(triangles), normals).count()
        };
        assert_eq!([count(&points, &triangles, Normals::Flat), count(&points, &triangles, Normals::Smooth)], [2, 1]);
        assert!(part_at_creases(&mut points, &mut triangles));
        assert_eq!([count(&points, &triangles, Normals::Flat), count(&points, &triangles, Normals::Smooth)], [2, 2]);
        let (points, triangles) = grid(10, 0.0, |p| 0.01 * p.length_squared());
        // The two triangles of a square lie in one plane there.
        assert_eq!(count(&points, &triangles, Normals::Flat), 100);
        // By smooth normals each triangle bends on its own, but for those of a plane.
        let smooth = |own: &Own| corner_normals(&own.0, &own.1).expect("it is a graph");
        let dome = (points, triangles);
        let pieces = |own: &Own| pieces(&own.0, &own.1, &edges(&own.1), &smooth(own)).count();
        assert_eq!(pieces(&dome), 200);
        let plane = grid(10, 0.3, |p| 0.1 * p.x);
        assert_eq!(pieces(&plane), 1);
        let mut ridge = grid(10, 0.0, |p| 0.1 * p.x.abs());
        part_at_creases(&mut ridge.0, &mut ridge.1);
        assert_eq!(pieces(&ridge), 2);
    }
}
