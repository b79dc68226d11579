//! Single triangles of a surface: where a ray meets the plane of one, how far within its sides, and what lies beyond them.

use super::hit::Hit;
use super::normals::{EdgeOf, by_edge};
use crate::geom::Ray;
use glam::DVec3;

/// Where a ray meets the plane of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnTriangle {
    /// There, with the normal that the triangle continues to.
    pub hit: Hit,
    /// How far within the side opposite to each corner, above 0 inside: linear in the direction of rays from one place, and in the
    /// origin of rays of one direction.
    pub within: [f64; 3],
}

impl OnTriangle {
    /// The weights of the triangle's corners where the ray meets its plane, and how far within its sides that is: the volumes
    /// between the ray's direction and the sides. `None` of a ray along the plane.
    #[inline]
    pub(super) fn weights(ray: &Ray, corners: [DVec3; 3]) -> Option<[[f64; 3]; 2]> {
        let [a, b, c] = corners.map(|corner| corner - ray.origin);
        let volumes = [b.cross(c), c.cross(a), a.cross(b)].map(|area| ray.direction.dot(area));
        let sum = volumes[0] + volumes[1] + volumes[2];
        (sum != 0.0).then(|| [volumes.map(|volume| volume / sum), volumes.map(|volume| volume * sum.signum())])
    }
}

/// The triangle beyond each side of each triangle.
pub(super) struct Neighbours(Vec<[u32; 3]>);

/// No triangle, or several.
const NONE: u32 = u32::MAX;

impl Neighbours {
    /// Those of `triangles`, given every edge with each of its triangles in order.
    pub(super) fn new(triangles: &[[u32; 3]], edges: &[EdgeOf]) -> Self {
        let mut beyond = vec![[NONE; 3]; triangles.len()];
        for group in by_edge(edges) {
            if let [(edge, a), (_, b)] = *group {
                for (own, other) in [(a, b), (b, a)] {
                    if let Some(side) = triangles[own as usize].iter().position(|corner| !edge.contains(corner)) {
                        beyond[own as usize][side] = other;
                    }
                }
            }
        }
        Self(beyond)
    }

    pub(super) fn beyond(&self, triangle: u32, side: usize) -> Option<u32> {
        self.0.get(triangle as usize).map(|beyond| beyond[side]).filter(|other| *other != NONE)
    }
}
