//! Packets of rays through one triangle of a mesh, continued beyond its sides, with the bits of [`Prism::behind_front`] and
//! [`Prism::behind_back`].

use super::biprism::Prism;
use super::lanes::{Rays, Vectors};
use super::packet::{Hits, pass};
use super::side::{PrismFace, Side};
use crate::num::simd::{LANES, Lanes, Mask};
use crate::surface::face::Face;
use crate::surface::mesh::{Normals, Triangles};
use crate::surface::shape::Surface;

/// A packet of rays behind a triangle: each as [`super::triangles::BehindTriangle`].
#[derive(Debug, Clone, Copy)]
pub struct PacketBehindTriangle {
    /// The rays: in the glass in the prism's frame, behind the glass in the world.
    pub rays: Rays,
    /// How far within the sides of the triangle, then how far on the half that the surface bounds, they passed.
    pub within: [Lanes; 4],
}

/// A packet of rays behind the glass, all through one side.
#[derive(Debug, Clone, Copy)]
pub struct PacketThroughTriangles {
    /// The rays, in the world.
    pub rays: Rays,
    /// The side.
    pub side: Side,
    /// The triangles of the front and of the back that they passed.
    pub triangles: [[u32; LANES]; 2],
}

impl Prism {
    /// Rays of the world through a prism of meshes whose every ray meets each once, by triangles of front and back that may be known to
    /// be near theirs; `None` where the scalar code has to tell, as it has of rays of both sides and of those on a side of a triangle.
    #[inline(always)]
    pub fn packet_through_triangles(&self, rays: &Rays, close: Option<[u32; 2]>) -> Option<PacketThroughTriangles> {
        if self.is_solid() || !self.is_ideal() {
            return None;
        }
        let own = match &self.poses {
            None => *rays,
            Some([_, prism_from_world]) => rays.moved(prism_from_world),
        };
        let (x, dx, zero) = (own.origin.x, own.direction.x, Lanes::splat(0.0));
        let side = if (zero.le(x) & zero.le(dx)).all() {
            Side::Right
        } else if (x.le(zero) & dx.lt(zero)).all() {
            Side::Left
        } else {
            return None;
        };
        let (inside, on_front) = self.packet_met(&own, PrismFace { side, face: Face::Front }, close.map(|of| of[0]))?;
        let (out, on_back) = self.packet_met(&inside, PrismFace { side, face: Face::Back }, close.map(|of| of[1]))?;
        let rays = match &self.poses {
            None => out,
            Some([world_from_prism, _]) => out.moved(world_from_prism),
        };
        Some(PacketThroughTriangles { rays, side, triangles: [on_front, on_back] })
    }

    /// The rays behind a mesh, and the triangles that they met.
    #[inline(always)]
    fn packet_met(&self, rays: &Rays, at: PrismFace, close: Option<u32>) -> Option<(Rays, [u32; LANES])> {
        let [n_outer, n_glass] = self.indices();
        let eta = if at.face == Face::Front { n_outer / n_glass } else { n_glass / n_outer };
        let Surface::Mesh { mesh, mirrored } = self.surface(at.side, at.face) else { return None };
        let turned = |v: Vectors| [v.x.negated_where(Mask::splat(*mirrored)), v.y, v.z];
        let met = mesh.meet_all(turned(rays.origin), turned(rays.direction), close).filter(|_| eta != 1.0)?;
        let [x, y, z] = mesh.normals_at(&met);
        let normal = Vectors { x: x.negated_where(Mask::splat(*mirrored)), y, z };
        let (behind, clear) = pass(rays, &Hits { t_mm: met.t_mm, normal, met: Mask::splat(true) }, eta);
        clear.all().then_some((behind, met.triangles))
    }

    /// The rays of the world in the glass behind a triangle of the front; `None` where the front is no mesh or has no such triangle, and
    /// where a ray does not meet its plane or needs the care of the scalar code.
    #[inline(always)]
    pub fn packet_behind_front(&self, rays: &Rays, side: Side, triangle: u32) -> Option<PacketBehindTriangle> {
        let own = match &self.poses {
            None => *rays,
            Some([_, prism_from_world]) => rays.moved(prism_from_world),
        };
        self.packet_behind(&own, PrismFace { side, face: Face::Front }, triangle)
    }

    /// Rays of the glass behind a triangle of the back; `None` as of the front.
    #[inline(always)]
    pub fn packet_behind_back(&self, inside: &Rays, side: Side, triangle: u32) -> Option<PacketBehindTriangle> {
        let behind = self.packet_behind(inside, PrismFace { side, face: Face::Back }, triangle)?;
        let rays = match &self.poses {
            None => behind.rays,
            Some([world_from_prism, _]) => behind.rays.moved(world_from_prism),
        };
        Some(PacketBehindTriangle { rays, ..behind })
    }

    #[inline(always)]
    fn packet_behind(&self, rays: &Rays, at: PrismFace, triangle: u32) -> Option<PacketBehindTriangle> {
        // Where the media are alike nothing is refracted, which the packets leave to the scalar code.
        let [n_outer, n_glass] = self.indices();
        let eta = if at.face == Face::Front { n_outer / n_glass } else { n_glass / n_outer };
        let Surface::Mesh { mesh, mirrored } = self.surface(at.side, at.face) else { return None };
        let Triangles { points_mm, point_normals, triangles } = mesh.own();
        let corners = triangles.get(triangle as usize).filter(|_| eta != 1.0)?.map(|k| k as usize);

        // Move the rays to the mesh's own frame, and find the volumes between them and the sides.
        let turned = |v: Vectors| Vectors { x: v.x.negated_where(Mask::splat(*mirrored)), ..v };
        let (origin, direction) = (turned(rays.origin), turned(rays.direction));
        let places = corners.map(|k| points_mm[k]);
        let [a, b, c] = places.map(|place| Vectors::splat(place).minus(origin));
        let volumes = [b.cross(c), c.cross(a), a.cross(b)].map(|area| direction.dot(area));
        let sum = volumes[0] + volumes[1] + volumes[2];

        // Meet the plane, with the normal that refracts there.
        let plane = (places[1] - places[0]).cross(places[2] - places[0]);
        let t_mm = a.dot(Vectors::splat(plane)) / direction.dot(Vectors::splat(plane));
        let normal = match mesh.normals() {
            Normals::Flat => Vectors::splat(plane),
            Normals::Smooth => {
                let share = |k: usize| Vectors::splat(point_normals[corners[k]]).times(volumes[k] / sum);
                share(0).plus(share(1)).plus(share(2))
            }
        };
        let zero = Lanes::splat(0.0);
        let met = zero.lt(t_mm) & t_mm.lt(Lanes::splat(f64::INFINITY)) & zero.lt(sum.abs());
        let (behind, clear) = pass(rays, &Hits { t_mm, normal: turned(normal.normalize()), met }, eta);
        if !(met & clear).all() {
            return None;
        }

        // Tell how far within the sides and the half they passed.
        let [a, b, c] = volumes.map(|volume| volume.negated_where(sum.lt(zero)));
        let half = if at.face == Face::Front || self.is_solid() {
            (rays.origin.x / t_mm + rays.direction.x).negated_where(Mask::splat(at.side == Side::Left))
        } else {
            Lanes::splat(1.0)
        };
        Some(PacketBehindTriangle { rays: behind, within: [a, b, c, half] })
    }
}
