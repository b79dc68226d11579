//! Light through one triangle of the front and one of the back of a prism of meshes, each continued beyond its sides.

use super::biprism::Prism;
use super::side::{PrismFace, Side};
use crate::geom::Ray;
use crate::optics::snell::refract;
use crate::surface::face::Face;

/// A ray behind a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BehindTriangle {
    /// The ray: in the glass in the prism's frame, behind the glass in the world.
    pub ray: Ray,
    /// How far within the sides of the triangle, then how far on the half that the surface bounds, it passed, above 0 inside; each
    /// linear in the directions of rays from one place.
    pub within: [f64; 4],
}

/// The triangles that light passes; 0 of a surface that is no mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TrianglePair {
    /// The side of the prism.
    pub side: Side,
    /// Numbers of triangles of the front and of the back.
    pub triangles: [u32; 2],
}

impl Prism {
    /// The ray of the world in the glass behind a triangle of the front; `None` where it does not meet its plane, or there is no such
    /// triangle.
    pub fn behind_front(&self, ray: &Ray, side: Side, triangle: u32, residual_mm: f64) -> Option<BehindTriangle> {
        let own = self.poses.map_or(*ray, |[_, prism_from_world]| ray.moved(&prism_from_world));
        self.behind(&own, PrismFace { side, face: Face::Front }, triangle, residual_mm)
    }

    /// A ray of the glass behind a triangle of the back; `None` also where it is totally reflected.
    pub fn behind_back(&self, inside: &Ray, side: Side, triangle: u32, residual_mm: f64) -> Option<BehindTriangle> {
        let behind = self.behind(inside, PrismFace { side, face: Face::Back }, triangle, residual_mm)?;
        let ray = self.poses.map_or(behind.ray, |[world_from_prism, _]| behind.ray.moved(&world_from_prism));
        Some(BehindTriangle { ray, ..behind })
    }

    #[inline]
    fn behind(&self, ray: &Ray, at: PrismFace, triangle: u32, residual_mm: f64) -> Option<BehindTriangle> {
        let met = self.surface(at.side, at.face).on_triangle(ray, triangle, residual_mm)?;
        let [n_outer, n_glass] = self.indices();
        let eta = if at.face == Face::Front { n_outer / n_glass } else { n_glass / n_outer };
        let direction = refract(ray.direction, met.hit.normal, eta)?.direction;
        let outward = if at.side == Side::Right { 1.0 } else { -1.0 };
        let half = if at.face == Face::Front || self.is_solid() {
            outward * (ray.origin.x / met.hit.t_mm + ray.direction.x)
        } else {
            1.0
        };
        let [a, b, c] = met.within;
        Some(BehindTriangle { ray: Ray { origin: ray.at(met.hit.t_mm), direction }, within: [a, b, c, half] })
    }
}
