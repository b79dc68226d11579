//! Refracting shapes in the frame of the prism, and their common intersection and normal.

use super::figure_error::FigureError;
use super::hit::Hit;
use super::mesh::Mesh;
use super::polynomial::{turn, turned};
use super::triangle::OnTriangle;
use crate::geom::{Pose, Ray};
use crate::optics::fate::Fate;
use glam::DVec3;
use std::sync::Arc;

pub use super::polynomial::{FULL_WAYS_PER_MM, PolynomialPatch, PolynomialSurface};
pub use super::revolved::{RevolvedPatch, RevolvedSurface};

/// A refracting shape without its media.
#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    /// A whole plane.
    Plane {
        /// A point of it, in mm.
        point: DVec3,
        /// Its unit normal.
        normal: DVec3,
    },
    /// The graph of a polynomial z(x, y) over a rectangle.
    Freeform(PolynomialSurface),
    /// A part of a surface of revolution.
    Revolved(Box<RevolvedSurface>),
    /// Triangles, or their mirror image in x = 0.
    Mesh {
        /// The triangles.
        mesh: Arc<Mesh>,
        /// Whether the surface is the mirror image.
        mirrored: bool,
    },
    /// A plane or a sheet out of figure.
    Flawed {
        /// The surface as it should be.
        base: Box<Surface>,
        /// What is added to its height.
        flaw: Arc<FigureError>,
    },
    /// Any surface somewhere else.
    Moved {
        /// The surface in its own frame.
        base: Box<Surface>,
        /// From its own frame to this one, and back.
        poses: Box<[Pose; 2]>,
    },
}

// Planes and sheets are met in the ray's own loop; what else a surface can be stays out of their way.
impl Surface {
    /// Where `ray` first meets the surface at a positive distance.
    #[inline]
    pub fn intersect(&self, ray: &Ray, residual_mm: f64) -> Result<Hit, Fate> {
        match self {
            Self::Plane { point, normal } => {
                let t_mm = (*point - ray.origin).dot(*normal) / ray.direction.dot(*normal);
                if t_mm > 0.0 && t_mm.is_finite() {
                    Ok(Hit { t_mm, normal: *normal, part: 0 })
                } else {
                    Err(Fate::Missed)
                }
            }
            Self::Freeform(sheet) => sheet.intersect(ray, residual_mm),
            _ => self.intersect_other(ray, residual_mm),
        }
    }

    #[inline(never)]
    fn intersect_other(&self, ray: &Ray, residual_mm: f64) -> Result<Hit, Fate> {
        match self {
            Self::Plane { .. } | Self::Freeform(_) => self.intersect(ray, residual_mm),
            Self::Revolved(part) => part.intersect(ray, residual_mm),
            Self::Mesh { mesh, mirrored } => {
                let own = |v| turned(v, *mirrored);
                let met = mesh.intersect(&Ray { origin: own(ray.origin), direction: own(ray.direction) })?;
                Ok(Hit { normal: own(met.normal), ..met })
            }
            Self::Flawed { base, .. } => self.intersect_by_height(base, ray, residual_mm),
            Self::Moved { base, poses } => {
                let met = base.intersect(&ray.moved(&poses[1]), residual_mm)?;
                Ok(Hit { normal: poses[0].vector(met.normal), ..met })
            }
        }
    }

    /// Where the ray meets the plane of a triangle of a mesh, which is continued beyond its sides; of another surface where it
    /// meets that, which has no sides. `None` where it does not.
    #[inline]
    pub fn on_triangle(&self, ray: &Ray, triangle: u32, residual_mm: f64) -> Option<OnTriangle> {
        match self {
            Self::Mesh { mesh, mirrored } => {
                let own = |v| turned(v, *mirrored);
                let met =
                    mesh.on_triangle(&Ray { origin: own(ray.origin), direction: own(ray.direction) }, triangle)?;
                Some(OnTriangle { hit: Hit { normal: own(met.hit.normal), ..met.hit }, ..met })
            }
            Self::Moved { base, poses } => {
                let met = base.on_triangle(&ray.moved(&poses[1]), triangle, residual_mm)?;
                Some(OnTriangle { hit: Hit { normal: poses[0].vector(met.hit.normal), ..met.hit }, ..met })
            }
            _ => self.intersect(ray, residual_mm).ok().map(|hit| OnTriangle { hit, within: [1.0; 3] }),
        }
    }

    /// The triangle of a mesh beyond a side of one; `None` where there is not one.
    pub fn neighbour(&self, triangle: u32, side: usize) -> Option<u32> {
        match self {
            Self::Mesh { mesh, .. } => mesh.neighbour(triangle, side),
            Self::Moved { base, .. } => base.neighbour(triangle, side),
            _ => None,
        }
    }

    /// The same surface continued beyond where it was given, where its formula goes on there.
    #[must_use]
    pub fn continued(&self) -> Self {
        match self {
            Self::Freeform(sheet) => Self::Freeform(sheet.continued()),
            Self::Flawed { base, flaw } => Self::Flawed { base: Box::new(base.continued()), flaw: Arc::clone(flaw) },
            Self::Moved { base, poses } => Self::Moved { base: Box::new(base.continued()), poses: poses.clone() },
            Self::Plane { .. } | Self::Mesh { .. } | Self::Revolved(_) => self.clone(),
        }
    }

    /// The facet of a mesh that a hit is on, and the piece of it (see [`Mesh::parts`]); of a surface that is one, the number
    /// of the hit, and 0.
    pub fn parts(&self, hit: &Hit) -> [u32; 2] {
        match self {
            Self::Mesh { mesh, .. } => mesh.parts(hit),
            Self::Moved { base, .. } => base.parts(hit),
            Self::Plane { .. } | Self::Freeform(_) | Self::Revolved(_) | Self::Flawed { .. } => [hit.part, 0],
        }
    }

    /// Whether the surface is its own mirror image in x = 0, as far as its form tells.
    pub fn is_own_mirror_image(&self) -> bool {
        match self {
            Self::Plane { normal, .. } => normal.x == 0.0,
            Self::Freeform(sheet) => {
                sheet.sag().centre()[0] == 0.0 && sheet.sag().terms().all(|(m, _, c)| m % 2 == 0 || c == 0.0)
            }
            _ => false,
        }
    }

    /// How many facets and pieces the surface has.
    pub fn part_counts(&self) -> [usize; 2] {
        match self {
            Self::Mesh { mesh, .. } => mesh.part_counts(),
            Self::Moved { base, .. } => base.part_counts(),
            Self::Plane { .. } | Self::Freeform(_) | Self::Revolved(_) | Self::Flawed { .. } => [1; 2],
        }
    }

    /// The unit normal of the plane in which `meeting` moves when its ray does. Of a mesh that is the triangle's own,
    /// whichever normal refracts.
    #[inline(always)]
    pub fn tangent(&self, meeting: &Hit) -> DVec3 {
        match self {
            Self::Plane { .. } | Self::Freeform(_) | Self::Flawed { .. } => meeting.normal,
            _ => self.tangent_other(meeting),
        }
    }

    #[inline(never)]
    fn tangent_other(&self, meeting: &Hit) -> DVec3 {
        match self {
            Self::Plane { .. } | Self::Freeform(_) | Self::Revolved(_) | Self::Flawed { .. } => meeting.normal,
            Self::Mesh { mesh, mirrored } => turned(mesh.tangent(meeting), *mirrored),
            Self::Moved { base, poses } => {
                let own = Hit { normal: poses[1].vector(meeting.normal), ..*meeting };
                poses[0].vector(base.tangent(&own))
            }
        }
    }

    /// How the unit normal of `meeting`, taken as `normal` or its opposite, turns when its point moves by `step` along the
    /// surface.
    #[inline(always)]
    pub fn normal_change(&self, meeting: &Hit, point: DVec3, normal: DVec3, step: DVec3) -> DVec3 {
        match self {
            Self::Plane { .. } => DVec3::ZERO,
            _ => self.normal_change_other(meeting, point, normal, step),
        }
    }

    #[inline(never)]
    fn normal_change_other(&self, meeting: &Hit, point: DVec3, normal: DVec3, step: DVec3) -> DVec3 {
        match self {
            Self::Plane { .. } => DVec3::ZERO,
            Self::Freeform(sheet) => sheet.normal_change(point, normal, step),
            Self::Revolved(part) => part.normal_change(point, normal, step),
            Self::Mesh { mesh, mirrored } => {
                let own = |v| turned(v, *mirrored);
                own(mesh.normal_change(meeting, own(point), own(normal), own(step)))
            }
            Self::Flawed { .. } => self.jet(point.x, point.y).map_or(DVec3::ZERO, |jet| turn(&jet, normal, step)),
            Self::Moved { base, poses } => {
                let [_, own] = **poses;
                let met = Hit { normal: own.vector(meeting.normal), ..*meeting };
                poses[0].vector(base.normal_change(&met, own.point(point), own.vector(normal), own.vector(step)))
            }
        }
    }
}
