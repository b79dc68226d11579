//! Triangle meshes: a surface as triangles, as renderers and modellers have it.
//!
//! The boxes of an f32 hierarchy only propose triangles; each is met in f64 by a watertight test (Woop, Benthin & Wald,
//! "Watertight Ray/Triangle Intersection", 2013), so that no ray slips between two triangles that share an edge.

use super::graph::{Graph, Met};
use super::hit::Hit;
use super::normals::edges;
use super::parts::{Parts, facets, pieces};
use super::shear::ShearAxes;
use super::triangle::{Neighbours, OnTriangle};
use crate::geom::{Ray, Rect};
use crate::optics::fate::Fate;
use glam::{DVec2, DVec3};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::ploc::PlocBuilder;
use obvhs::ray::RayHit;
use std::sync::OnceLock;

pub use super::normals::Normals;

/// A surface of triangles as data: what a file of a mesh holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Triangles {
    /// Corners, in mm.
    pub points_mm: Vec<DVec3>,
    /// A unit normal at every corner, all towards the same side of the surface.
    pub point_normals: Vec<DVec3>,
    /// The corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Triangles {
    /// Tessellates z(x, y) over `domain` by `cells` x `cells` squares of two triangles each; `surface` gives z in mm and
    /// the unit normal.
    pub fn over(domain: Rect, cells: usize, surface: impl Fn(f64, f64) -> (f64, DVec3)) -> Self {
        let cells = cells.max(1);
        let place = |i: usize, j: usize| domain.min + domain.size() * DVec2::new(i as f64, j as f64) / cells as f64;
        let grid = (0..=cells).flat_map(|j| (0..=cells).map(move |i| (i, j)));
        let (points_mm, point_normals): (Vec<DVec3>, Vec<DVec3>) = grid
            .map(|(i, j)| {
                let p = place(i, j);
                let (z, normal) = surface(p.x, p.y);
                (p.extend(z), normal)
            })
            .unzip();
        let at = |i: usize, j: usize| (j * (cells + 1) + i) as u32;
        let triangles: Vec<[u32; 3]> = (0..cells)
            .flat_map(|j| (0..cells).map(move |i| (i, j)))
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        Self { points_mm, point_normals, triangles }
    }
}

/// Triangles that rays can meet.
pub struct Mesh {
    own: Triangles,
    normals: Normals,
    /// Made once a ray asks for it.
    hierarchy: OnceLock<Bvh2>,
    neighbours: Neighbours,
    /// Where a steep ray meets it once, and how it is found there without the hierarchy.
    graph: Option<Graph>,
    /// Between which the normal that refracts may jump.
    facets: Parts,
    /// Between which it may have a kink: the facets, or parts of them.
    pieces: Parts,
    /// Smallest z less some slack: rays are followed from there on.
    first_z: f64,
}

impl std::fmt::Debug for Mesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Mesh of {} triangles with {:?} normals", self.triangles(), self.normals)
    }
}

impl PartialEq for Mesh {
    fn eq(&self, other: &Self) -> bool {
        (&self.own, self.normals) == (&other.own, other.normals)
    }
}

/// Boxes grow by this many roundings of f32 of their largest coordinate, so that rounding never hides a triangle.
const BOX_ROUNDINGS: f64 = 8.0;

/// Triangles of a leaf of the hierarchy, at most.
const TRIANGLES_PER_LEAF: u32 = 2;

/// The boxes in order for rays. The crate's own `build_bvh2` moves nodes about afterwards, which can make the tree deeper than
/// the depth it notes for the stacks of rays.
fn hierarchy(Triangles { points_mm: points, triangles, .. }: &Triangles) -> Bvh2 {
    let largest = points.iter().fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
    let pad = DVec3::splat(BOX_ROUNDINGS * largest * f64::from(f32::EPSILON));
    let of = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|k| points[k as usize]);
        Aabb::new((a.min(b).min(c) - pad).as_vec3a(), (a.max(b).max(c) + pad).as_vec3a())
    };
    let boxes: Vec<Aabb> = triangles.iter().map(of).collect();
    let parameters = BvhBuildParams::medium_build();
    let mut hierarchy = PlocBuilder::with_capacity(boxes.len()).build(
        parameters.ploc_search_distance,
        &boxes,
        (0..boxes.len() as u32).collect(),
        parameters.sort_precision,
        parameters.search_depth_threshold,
    );
    collapse(&mut hierarchy, TRIANGLES_PER_LEAF, parameters.collapse_traversal_cost);
    hierarchy
}

impl Mesh {
    /// Orders `triangles` for rays; `normals` says which refract.
    pub fn new(own: Triangles, normals: Normals) -> Self {
        let points = &own.points_mm;
        let first_z = points.iter().fold(f64::INFINITY, |z, p| z.min(p.z)) - 1.0;
        let edges = edges(&own.triangles);
        let neighbours = Neighbours::new(&own.triangles, &edges);
        let graph = Graph::new(&own.points_mm, &own.triangles, &edges);
        let facets = facets(&own.points_mm, &own.triangles, &edges, normals);
        let pieces = match normals {
            Normals::Flat => facets.clone(),
            Normals::Smooth => pieces(&own.points_mm, &own.triangles, &edges, &own.point_normals),
        };
        Self { own, normals, hierarchy: OnceLock::new(), neighbours, graph, facets, pieces, first_z }
    }

    /// The triangles as they were given.
    pub fn own(&self) -> &Triangles {
        &self.own
    }

    /// Which normals refract.
    pub fn normals(&self) -> Normals {
        self.normals
    }

    /// The numbers of the facet that a hit is on, over which the normal that refracts does not jump, and of the piece of it, over
    /// which it has no kink.
    pub fn parts(&self, hit: &Hit) -> [u32; 2] {
        [&self.facets, &self.pieces].map(|parts| parts.name(hit.part))
    }

    /// Counts of facets and of pieces.
    pub fn part_counts(&self) -> [usize; 2] {
        [self.facets.count(), self.pieces.count()]
    }

    /// Count of triangles.
    pub fn triangles(&self) -> usize {
        self.own.triangles.len()
    }

    /// The smallest rectangle over x and y that holds all corners, in mm.
    pub fn extent(&self) -> Rect {
        let nothing = Rect { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
        let places = self.own.points_mm.iter().map(|p| p.truncate());
        places.fold(nothing, |all, p| Rect { min: all.min.min(p), max: all.max.max(p) })
    }

    /// The lowest z over (x, y), in mm; `None` beside the mesh.
    pub fn height_mm(&self, x: f64, y: f64) -> Option<f64> {
        let below = Ray { origin: DVec3::new(x, y, self.first_z), direction: DVec3::Z };
        self.intersect(&below).ok().map(|hit| below.at(hit.t_mm).z)
    }

    /// Where the ray first meets the mesh at a positive distance; of two triangles at one distance, the first.
    ///
    /// # Errors
    /// [`Fate::Missed`].
    pub fn intersect(&self, ray: &Ray) -> Result<Hit, Fate> {
        // Start near the mesh: the f32 of the hierarchy is finest near its own origin. A ray that runs back towards -z
        // starts where it is.
        let ahead = ((self.first_z - ray.origin.z) / ray.direction.z).max(0.0);
        let ahead = if ahead.is_finite() && ray.direction.z > 0.0 { ahead } else { 0.0 };
        let near = Ray { origin: ray.at(ahead), direction: ray.direction };

        let axes = ShearAxes::new(near.direction);
        let (t, id, weights) =
            self.at_once(&near, ahead, &axes).or_else(|| self.nearest(&near, ahead, &axes)).ok_or(Fate::Missed)?;

        Ok(Hit { t_mm: t + ahead, normal: self.normal(id, weights), part: id as u32 })
    }

    /// The unit normal that refracts at these weights of a triangle's corners.
    #[inline]
    fn normal(&self, id: usize, weights: [f64; 3]) -> DVec3 {
        let normal = match self.normals {
            Normals::Flat => self.plane(id),
            Normals::Smooth => self.blend(id, weights),
        };
        normal.normalize()
    }

    /// Where the ray meets the plane of a triangle, which is continued beyond its sides; `None` where it does not, or there is no such triangle.
    #[inline]
    pub fn on_triangle(&self, ray: &Ray, triangle: u32) -> Option<OnTriangle> {
        let id = triangle as usize;
        self.own.triangles.get(id)?;
        let [weights, within] = OnTriangle::weights(ray, self.corners(id))?;
        let plane = self.plane(id);
        let t_mm = (self.corners(id)[0] - ray.origin).dot(plane) / ray.direction.dot(plane);
        let hit = Hit { t_mm, normal: self.normal(id, weights), part: triangle };
        (t_mm > 0.0 && t_mm.is_finite()).then_some(OnTriangle { hit, within })
    }

    /// The triangle beyond a side of a triangle, which lies opposite to the corner of the same number; `None` where there is not one.
    pub fn neighbour(&self, triangle: u32, side: usize) -> Option<u32> {
        self.neighbours.beyond(triangle, side)
    }

    /// What a steep ray meets, where the mesh is a graph, but for edges.
    #[inline(always)]
    fn at_once(&self, near: &Ray, ahead: f64, axes: &ShearAxes) -> Option<Met> {
        let within = |id: usize| axes.intersect(near.origin, self.corners(id)).filter(|(t, _)| t + ahead > 0.0);
        self.graph.as_ref()?.meet(near, within, |id| (self.corners(id)[0], self.plane(id)))
    }

    #[cfg(test)]
    pub(super) fn met_both_ways(&self, ray: &Ray) -> [Option<Met>; 2] {
        let axes = ShearAxes::new(ray.direction);
        [self.at_once(ray, 0.0, &axes), self.nearest(ray, 0.0, &axes)]
    }

    /// Which triangle the ray meets first, of those farther than `-ahead`, where, and with which weights of its corners.
    fn nearest(&self, near: &Ray, ahead: f64, axes: &ShearAxes) -> Option<Met> {
        // Traverse the hierarchy, and intersect the triangles that it proposes.
        let mut best: Option<Met> = None;
        let proposal = obvhs::ray::Ray::new_inf(near.origin.as_vec3a(), near.direction.as_vec3a());
        let hierarchy = self.hierarchy();
        hierarchy.ray_traverse(proposal, &mut RayHit::none(), |_, i| {
            let id = hierarchy.primitive_indices[i] as usize;
            let corners = self.corners(id);
            match axes.intersect(near.origin, corners) {
                Some((t, weights)) if t + ahead > 0.0 => {
                    if best.is_none_or(|b| (t, id) < (b.0, b.1)) {
                        best = Some((t, id, weights));
                    }
                    // Never less than the true distance, so that no nearer triangle is passed over.
                    (t as f32).next_up().next_up()
                }
                _ => f32::INFINITY,
            }
        });

        best
    }

    fn hierarchy(&self) -> &Bvh2 {
        self.hierarchy.get_or_init(|| hierarchy(&self.own))
    }

    fn corners(&self, id: usize) -> [DVec3; 3] {
        self.own.triangles[id].map(|k| self.own.points_mm[k as usize])
    }

    /// Smallest z less some slack.
    #[inline(always)]
    pub(super) fn first_z(&self) -> f64 {
        self.first_z
    }

    /// Where a steep ray meets it once.
    #[inline(always)]
    pub(super) fn graph(&self) -> Option<&Graph> {
        self.graph.as_ref()
    }

    /// A normal of the triangle itself, of no certain length.
    pub(super) fn plane(&self, id: usize) -> DVec3 {
        let [a, b, c] = self.corners(id);
        (b - a).cross(c - a)
    }

    fn blend(&self, id: usize, weights: [f64; 3]) -> DVec3 {
        let [a, b, c] = self.own.triangles[id].map(|k| self.own.point_normals[k as usize]);
        a * weights[0] + b * weights[1] + c * weights[2]
    }

    /// The unit normal of the plane in which a meeting moves when its ray does.
    pub fn tangent(&self, meeting: &Hit) -> DVec3 {
        self.plane(meeting.part as usize).normalize()
    }

    /// How the unit normal of a meeting at `point` turns when the point moves by `step` within its triangle.
    pub fn normal_change(&self, meeting: &Hit, point: DVec3, normal: DVec3, step: DVec3) -> DVec3 {
        if self.normals == Normals::Flat {
            return DVec3::ZERO;
        }
        let id = meeting.part as usize;
        let [a, b, c] = self.corners(id);
        let plane = self.plane(id);
        // Weights are areas opposite the corners over the whole, linear in the point.
        let share = |from: DVec3, to: DVec3, v: DVec3| (to - from).cross(v).dot(plane) / plane.length_squared();
        let weights = [share(b, c, point - b), share(c, a, point - c), share(a, b, point - a)];
        let change = [share(b, c, step), share(c, a, step), share(a, b, step)];
        let blend = self.blend(id, weights);
        let turn = (self.blend(id, change) - normal * normal.dot(self.blend(id, change))) / blend.length();
        if normal.dot(blend) < 0.0 { -turn } else { turn }
    }
}

#[cfg(test)]
#[path = "mesh_tests.rs"]
mod tests;
