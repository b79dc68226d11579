//! Normals of a triangle mesh, and its facets: the parts over which they change steadily, with creases between them.

use glam::DVec3;
use std::collections::BTreeMap;

/// Two triangles that make a smaller angle than this, in rad (1 deg), have no crease between them.
const LEAST_CREASE_RAD: f64 = 0.017_5;
/// The triangles at a crease make an angle so many times as large as others do beside it.
const STANDS_OUT: f64 = 3.0;
/// Where one side of an edge is even and the other is not, as a bevel between two facets, or nothing lies beside it, it is a
/// crease if its triangles make more than this, in rad (5 deg): on curved surfaces the angle varies too.
const LEAST_BEVEL_RAD: f64 = 0.087;
/// Where nothing lies beside an edge, its angle must also be so many times the root mean square of all others.
const STANDS_OUT_OF_ALL: f64 = 10.0;
/// A crease goes on along an edge that makes a smaller angle with it than this (cos 30 deg), if the triangles there make at
/// least half its angle.
const GOES_ON: f64 = 0.87;
/// Edges along which it goes on at most.
const LONGEST_WAY: usize = 64;

/// Which normal refracts a ray that meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Normals {
    /// The triangle's own.
    Flat,
    /// The normals of its corners, weighed by their nearness and brought to unit length.
    Smooth,
}

/// Unit normals at the corners of a surface that is a graph over (x, y), towards +z: those of the triangles around, weighed
/// by their angles there (Thürmer & Wüthrich, "Computing Vertex Normals from Polygonal Facets", 1998). The number of a
/// corner without one (no triangle has it, or the triangles stand upright) is the error.
pub(crate) fn corner_normals(points_mm: &[DVec3], triangles: &[[u32; 3]]) -> Result<Vec<DVec3>, usize> {
    let mut sums = vec![DVec3::ZERO; points_mm.len()];
    for triangle in triangles {
        let at = triangle.map(|k| k as usize);
        for k in 0..3 {
            let [here, next, last] = [at[k], at[(k + 1) % 3], at[(k + 2) % 3]];
            let (a, b) = (points_mm[next] - points_mm[here], points_mm[last] - points_mm[here]);
            let cross = a.cross(b);
            let Some(normal) = cross.try_normalize() else { continue };
            let angle = libm::atan2(cross.length(), a.dot(b));
            sums[here] += normal * (if normal.z < 0.0 { -angle } else { angle });
        }
    }
    let unit = |(k, sum): (usize, &DVec3)| sum.try_normalize().filter(|n| n.z > 0.0).ok_or(k);
    sums.iter().enumerate().map(unit).collect()
}

/// Sets of numbers, each named by its smallest.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    pub(super) fn of_one(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    pub(super) fn name(&mut self, mut k: u32) -> u32 {
        while self.0[k as usize] != k {
            let above = self.0[self.0[k as usize] as usize];
            self.0[k as usize] = above;
            k = above;
        }
        k
    }

    pub(super) fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.name(a), self.name(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// An edge, by its ends, and a triangle that has it.
pub(super) type EdgeOf = ([u32; 2], u32);

/// Every edge with each of its triangles, in order.
pub(super) fn edges(triangles: &[[u32; 3]]) -> Vec<EdgeOf> {
    let of = |(id, [a, b, c]): (usize, &[u32; 3])| {
        [(a, b), (b, c), (c, a)].map(|(p, q)| ([*p.min(q), *p.max(q)], id as u32))
    };
    let all = || triangles.iter().enumerate().flat_map(of);

    // Count those that begin at each corner, and place them by it; few begin at one.
    let corners = all().map(|([p, _], _)| p as usize + 1).max().unwrap_or(0);
    let mut next = vec![0; corners + 1];
    all().for_each(|([p, _], _)| next[p as usize + 1] += 1);
    for p in 0..corners {
        next[p + 1] += next[p];
    }
    let mut edges = vec![([0; 2], 0); 3 * triangles.len()];
    for edge in all() {
        let place = &mut next[edge.0[0] as usize];
        edges[*place] = edge;
        *place += 1;
    }
    edges.chunk_by_mut(|a, b| a.0[0] == b.0[0]).for_each(<[EdgeOf]>::sort_unstable);
    edges
}

/// The triangles at each edge.
pub(super) fn by_edge(edges: &[EdgeOf]) -> impl Iterator<Item = &[EdgeOf]> {
    edges.chunk_by(|a, b| a.0 == b.0)
}

/// Unit normals of the triangles, towards +z; 0 of those without area.
fn normals(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    triangles.iter().map(|triangle| normal(points, triangle)).collect()
}

/// The unit normal of a triangle, towards +z; 0 of one without area.
pub(super) fn normal(points: &[DVec3], triangle: &[u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|k| points[k as usize]);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    if normal.z < 0.0 { -normal } else { normal }
}

/// Whether two vectors surely make an angle of less than [`LEAST_CREASE_RAD`], by its sine, which is less: without an arc tangent.
fn surely_even(a: DVec3, b: DVec3) -> bool {
    const SINE: f64 = 0.99 * LEAST_CREASE_RAD;
    a.dot(b) > 0.0 && a.cross(b).length_squared() < SINE * SINE * a.length_squared() * b.length_squared()
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

/// [`corner_normals`] of a surface that is parted at its creases; the number of a corner without one is the error.
pub(crate) fn normals_with_creases(points: &mut Vec<DVec3>, triangles: &mut [[u32; 3]]) -> Result<Vec<DVec3>, usize> {
    let smooth = corner_normals(points, triangles)?;
    let creased = !is_even(points, triangles, &smooth) && part_at_creases(points, triangles);
    if creased { corner_normals(points, triangles) } else { Ok(smooth) }
}

/// Whether surely no two triangles that share a corner make an angle of [`LEAST_CREASE_RAD`], given unit normals at the corners: each
/// makes less than half of it with those of its own.
fn is_even(points: &[DVec3], triangles: &[[u32; 3]], at_corners: &[DVec3]) -> bool {
    const SINE: f64 = 0.99 * 0.5 * LEAST_CREASE_RAD;
    triangles.iter().all(|triangle| {
        let [a, b, c] = triangle.map(|k| points[k as usize]);
        let normal = (b - a).cross(c - a);
        let towards_z = if normal.z < 0.0 { -normal } else { normal };
        let least = (1.0 - SINE * SINE) * normal.length_squared();
        triangle.iter().all(|k| {
            let along = towards_z.dot(at_corners[*k as usize]);
            along > 0.0 && along * along > least
        })
    })
}

/// Parts a surface, a graph over (x, y), at its creases, so that no corner has a normal of both sides: a corner on a crease
/// becomes several, of which the first keeps its number and the others follow the last. Whether there is any.
pub(super) fn part_at_creases(points: &mut Vec<DVec3>, triangles: &mut [[u32; 3]]) -> bool {
    let edges = edges(triangles);
    let Some(creases) = creases(&edges, &normals(points, triangles), points, triangles) else { return false };

    // Unite what triangles hold of a corner across the edges that are no crease.
    let held =
        |id: u32, corner: u32| 3 * id + triangles[id as usize].iter().position(|k| *k == corner).unwrap_or(0) as u32;
    let mut sets = Sets::of_one(3 * triangles.len());
    for group in by_edge(&edges).filter(|group| creases.binary_search(&group[0].0).is_err()) {
        for (edge, id) in &group[1..] {
            edge.iter().for_each(|corner| sets.unite(held(group[0].1, *corner), held(*id, *corner)));
        }
    }

    // Give each set at a crease a corner of its own.
    let mut on_crease = vec![false; points.len()];
    creases.iter().flatten().for_each(|k| on_crease[*k as usize] = true);
    let mut owners: BTreeMap<u32, u32> = BTreeMap::new();
    let mut names: BTreeMap<u32, u32> = BTreeMap::new();
    for (id, triangle) in triangles.iter_mut().enumerate() {
        for (k, corner) in triangle.iter_mut().enumerate().filter(|(_, corner)| on_crease[**corner as usize]) {
            let set = sets.name(3 * id as u32 + k as u32);
            if *owners.entry(*corner).or_insert(set) != set {
                *corner = *names.entry(set).or_insert_with(|| {
                    points.push(points[*corner as usize]);
                    points.len() as u32 - 1
                });
            }
        }
    }
    true
}

/// An edge inside a surface.
#[derive(Debug, Clone, Copy)]
struct InnerEdge {
    edge: [u32; 2],
    /// Its triangles.
    both: [u32; 2],
    /// The angle that they make.
    rad: f64,
}

/// The edges, in order, whose angle stands out from those around the opposite corners of its two triangles, or, where these
/// corners lie on the surface's border, from all others; and those along which such a crease goes on. `None` where
/// there are none.
fn creases(
    edges: &[([u32; 2], u32)],
    normals: &[DVec3],
    points: &[DVec3],
    triangles: &[[u32; 3]],
) -> Option<Vec<[u32; 2]>> {
    // Measure the angle at every edge inside the surface.
    let inside = || {
        by_edge(edges).filter_map(|group| match *group {
            [(edge, a), (_, b)] => {
                Some(InnerEdge { edge, both: [a, b], rad: angle(normals[a as usize], normals[b as usize]) })
            }
            _ => None,
        })
    };
    let may_be = |group: &[EdgeOf]| match *group {
        [(_, a), (_, b)] => !surely_even(normals[a as usize], normals[b as usize]),
        _ => false,
    };
    if !(by_edge(edges).any(may_be) && inside().any(|bend| bend.rad > LEAST_CREASE_RAD)) {
        return None;
    }
    let (count, squares) = inside().fold((0.0, 0.0), |(count, sum), bend| (count + 1.0, sum + bend.rad * bend.rad));
    let others = |rad: f64| ((squares - rad * rad).max(0.0) / f64::max(count - 1.0, 1.0)).sqrt();

    // Measure the angle around every corner: twice the largest from the mean normal there.
    let mut on_border = vec![false; points.len()];
    for group in by_edge(edges).filter(|group| group.len() != 2) {
        group[0].0.iter().for_each(|k| on_border[*k as usize] = true);
    }
    let mut means = vec![DVec3::ZERO; points.len()];
    let held = || triangles.iter().zip(normals).flat_map(|(t, normal)| t.map(|k| (k as usize, *normal)));
    held().for_each(|(k, normal)| means[k] += normal);
    let mut around = vec![0.0f64; points.len()];
    held().for_each(|(k, normal)| around[k] = around[k].max(2.0 * angle(means[k], normal)));

    // Find the edges that stand out.
    let beside = |edge: [u32; 2], id: u32| {
        let apex = triangles[id as usize].into_iter().find(|k| !edge.contains(k))? as usize;
        (!on_border[apex]).then_some(STANDS_OUT * around[apex])
    };
    let bends = inside().filter(|bend| bend.rad > LEAST_CREASE_RAD);
    let (found, others): (Vec<InnerEdge>, Vec<InnerEdge>) = bends.partition(|bend| {
        let known = || bend.both.into_iter().filter_map(|id| beside(bend.edge, id));
        let bevel = bend.rad > LEAST_BEVEL_RAD;
        match known().reduce(f64::max) {
            Some(most) if bevel => bend.rad > known().fold(most, f64::min),
            Some(most) => known().count() == 2 && bend.rad > most,
            None => bend.rad > STANDS_OUT_OF_ALL * others(bend.rad),
        }
    });
    if found.is_empty() {
        return None;
    }

    let mut creases: Vec<[u32; 2]> = gone_on(found, others, points).into_iter().map(|bend| bend.edge).collect();
    creases.sort_unstable();
    Some(creases)
}

/// The edges of `found`, and those of `others` along which they go on.
fn gone_on(mut found: Vec<InnerEdge>, mut others: Vec<InnerEdge>, points: &[DVec3]) -> Vec<InnerEdge> {
    let way = |[a, b]: [u32; 2]| (points[b as usize] - points[a as usize]).normalize_or_zero();
    let mut last = found.clone();
    for _ in 0..LONGEST_WAY {
        let ends: BTreeMap<u32, InnerEdge> = last.iter().flat_map(|bend| bend.edge.map(|k| (k, *bend))).collect();
        let goes_on = |bend: &InnerEdge| {
            let from = |k: u32| {
                ends.get(&k)
                    .is_some_and(|end| way(bend.edge).dot(way(end.edge)).abs() > GOES_ON && 2.0 * bend.rad > end.rad)
            };
            bend.edge.into_iter().any(from)
        };
        (last, others) = others.into_iter().partition(goes_on);
        if last.is_empty() {
            break;
        }
        found.extend(&last);
    }
    found
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use glam::DVec2;

    pub(in super::super) type Own = (Vec<DVec3>, Vec<[u32; 3]>);

    /// A grid of `cells` x `cells` squares over 20 mm x 20 mm, turned by `turn`.
    pub(in super::super) fn grid(cells: u32, turn: f64, height: impl Fn(DVec2) -> f64) -> Own {
        let place = |k: u32| {
            20.0 * DVec2::new(f64::from(k % (cells + 1)), f64::from(k / (cells + 1))) / f64::from(cells) - 10.0
        };
        let turned = |p: DVec2| p.rotate(DVec2::from_angle(turn)).extend(80.0 + height(p));
        let corners = (0..(cells + 1) * (cells + 1)).map(|k| turned(place(k))).collect();
        let first = |k: u32| k / cells * (cells + 1) + k % cells;
        let square = |a: u32| [[a, a + 1, a + cells + 2], [a, a + cells + 2, a + cells + 1]];
        (corners, (0..cells * cells).flat_map(|k| square(first(k))).collect())
    }

    /// Corners of the parted surface, and its largest angle between a triangle and the normals of its corners, in rad.
    fn parted((mut points, mut triangles): Own) -> (u32, f64) {
        part_at_creases(&mut points, &mut triangles);
        let smooth = corner_normals(&points, &triangles).expect("it is a graph");
        let flat = normals(&points, &triangles);
        let leans = triangles.iter().zip(flat).flat_map(|(t, flat)| t.map(|k| angle(smooth[k as usize], flat)));
        (points.len() as u32, leans.fold(0.0, f64::max))
    }

    #[test]
    fn ridges_and_bevels_part_a_surface_wherever_they_lie() {
        for cells in [8, 10, 40] {
            let corners = (cells + 1) * (cells + 1);
            let column = -10.0 + 60.0 / f64::from(cells);
            for turn in [0.0, 0.3] {
                // A ridge of 17.7 deg and one of 2.3 deg, on planes and on a dome; a bevel of one column between two planes.
                for slope in [0.1558, 0.02] {
                    let (parts, leans) = parted(grid(cells, turn, |p| slope * (p.x - column).abs()));
                    assert!(parts == corners + cells + 1 && leans < 1e-6, "{cells} {slope}: {parts} {leans}");
                }
                let (parts, _) =
                    parted(grid(cells, turn, |p| 0.1558 * (p.x - column).abs() + 0.001 * p.length_squared()));
                assert_eq!(parts, corners + cells + 1, "{cells}");
                let bevel = |p: DVec2| 0.1558 * (p.x - column).max(column - 20.0 / f64::from(cells) - p.x).max(0.0);
                let (parts, leans) = parted(grid(cells, turn, bevel));
                assert!(parts == corners + 2 * (cells + 1) && leans < 1e-6, "bevel, {cells}: {parts} {leans}");
            }
        }
    }

    /// A number in -1..1 that looks random and belongs to `k`.
    fn shake(k: usize) -> f64 {
        2.0 * (k as f64 * 0.754_877_666_246_693 + 0.1 * libm::sin(12.9 * k as f64)).rem_euclid(1.0) - 1.0
    }

    /// The largest angle between two triangles that share an edge.
    fn sharpest(points: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
        let (edges, normals) = (edges(triangles), normals(points, triangles));
        let pairs = by_edge(&edges).filter(|group| group.len() == 2);
        pairs.map(|g| angle(normals[g[0].1 as usize], normals[g[1].1 as usize])).fold(0.0, f64::max)
    }

    /// What is told to be even without its edges has no crease: domes and ridges of every slope, of which some are.
    #[test]
    fn even_surfaces_have_no_angle_of_a_crease() {
        let mut told = [0, 0];
        for k in 0..60 {
            let bend = 1e-3 * f64::from(k);
            type Height<'a> = &'a dyn Fn(DVec2) -> f64;
            let heights: [Height<'_>; 2] = [&|p| 0.1 * bend * p.length_squared(), &|p| bend * p.x.abs()];
            for height in heights {
                let (points, triangles) = grid(10, 0.2, height);
                let smooth = corner_normals(&points, &triangles).expect("it is a graph");
                let even = is_even(&points, &triangles, &smooth);
                told[usize::from(even)] += 1;
                assert!(!even || sharpest(&points, &triangles) < LEAST_CREASE_RAD, "{bend}");
            }
        }
        assert!(told.iter().all(|told| *told > 10), "{told:?}");
    }

    /// Shapes of all kinds, over even grids and over some whose corners are shaken by a quarter of their distance.
    #[test]
    fn smooth_surfaces_stay_whole_however_coarse() {
        type Height = fn(DVec2) -> f64;
        let shapes: [(&str, Height); 8] = [
            ("plane", |p| 0.2 * p.x),
            ("dome", |p| 0.02 * (p.x * p.x + 0.5 * p.y * p.y)),
            ("faint dome", |p| 0.002 * p.length_squared()),
            ("cylinder", |p| 0.2 * p.x + 0.01 * p.x * p.x),
            ("saddle", |p| 0.02 * p.x * p.y),
            ("cubic", |p| 0.2 * p.x + 1e-3 * p.x * p.x * p.x),
            ("wave", |p| 0.3 * libm::sin(0.6 * p.x)),
            ("quartic", |p| 3e-5 * p.length_squared() * p.length_squared()),
        ];
        let mut judged = 0;
        for cells in [4, 5, 6, 10, 12, 40] {
            for (name, height) in shapes {
                for (turn, shaken) in [(0.0, 0.0), (0.2, 0.0), (0.2, 0.25)] {
                    let (mut points, triangles) = grid(cells, turn, |_| 0.0);
                    let step = shaken * 20.0 / f64::from(cells);
                    for (k, p) in points.iter_mut().enumerate() {
                        let at = p.truncate() + step * DVec2::new(shake(2 * k), shake(2 * k + 1));
                        *p = at.extend(80.0 + height(at));
                    }
                    // So coarse a mesh may as well be one of facets with bevels.
                    if sharpest(&points, &triangles) > LEAST_BEVEL_RAD {
                        continue;
                    }
                    judged += 1;
                    let whole = (cells + 1) * (cells + 1);
                    assert_eq!(parted((points, triangles)).0, whole, "{name} {cells} {turn} {shaken}");
                }
            }
        }
        assert!(judged > 60, "{judged}");
    }
}
