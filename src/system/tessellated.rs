//! Tessellation: an instrument whose prism is replaced by triangle meshes.

use super::instrument::System;
use crate::geom::Rect;
use crate::optics::fate::Fate;
use crate::prism::side::Side;
use crate::scene::{GlassSpec, MeshSpec};
use crate::surface::face::Face;
use crate::surface::mesh::{Mesh, Normals, Triangles};
use crate::surface::shape::Surface;
use glam::{DVec2, DVec3};

/// The right side of an instrument's prism as triangles.
#[derive(Debug)]
pub(crate) struct Tessellated<'a> {
    system: &'a System,
    /// Front and back.
    meshes: [Mesh; 2],
}

/// Rays along each edge of the right half by which the used part of a surface is found.
const PROBES: usize = 9;
/// The mesh reaches this much beyond the used part, as a share of it.
const MARGIN: f64 = 0.02;

impl<'a> Tessellated<'a> {
    /// Tessellates the part of the right side that the right half of the sensor sees, with about `triangles` on front and
    /// back together. `None` without a prism, of one that is a mesh already or out of shape, or where a ray on the way of
    /// the right half ends.
    pub(crate) fn new(system: &'a System, triangles: usize, normals: Normals) -> Option<Self> {
        let prism = system.prism()?;
        let cells = ((triangles as f64 / 4.0).sqrt().round() as usize).max(1);
        let used = used_part(system)?;
        let mesh = |face: Face| {
            let used = used[face as usize];
            match prism.surface(Side::Right, face) {
                Surface::Plane { point, normal } => {
                    let slope = normal.truncate() / normal.z;
                    let height = |x, y| (point.z - slope.dot(DVec2::new(x, y) - point.truncate()), *normal);
                    Some(Mesh::new(Triangles::over(used, cells, height), normals))
                }
                Surface::Freeform(sheet) => {
                    // A polynomial means nothing beyond the region where it is given.
                    let given = sheet.domain();
                    let domain = Rect { min: used.min.max(given.min), max: used.max.min(given.max) };
                    let height = |x, y| {
                        let (z, zx, zy) = sheet.sag().gradient(x, y);
                        (z, DVec3::new(-zx, -zy, 1.0).normalize())
                    };
                    Some(Mesh::new(Triangles::over(domain, cells, height), normals))
                }
                surface @ Surface::Revolved(_) => {
                    // Beside the part there is nothing to cut.
                    let probe = |k: usize| used.min + used.size() * DVec2::new((k % 2) as f64, (k / 2) as f64);
                    (0..4).map(probe).all(|at| surface.jet(at.x, at.y).is_some()).then(|| {
                        let height = |x, y| {
                            surface.jet(x, y).map_or((0.0, DVec3::Z), |jet| {
                                (jet.value, DVec3::new(-jet.dx, -jet.dy, 1.0).normalize())
                            })
                        };
                        Mesh::new(Triangles::over(used, cells, height), normals)
                    })
                }
                Surface::Mesh { .. } | Surface::Flawed { .. } | Surface::Moved { .. } => None,
            }
        };
        Some(Self { system, meshes: [mesh(Face::Front)?, mesh(Face::Back)?] })
    }

    /// The prism of these triangles as a scene gives it, of the glass and in the place of `body`.
    pub(crate) fn spec(&self, body: &GlassSpec) -> MeshSpec {
        let [front, back] = self.meshes.each_ref().map(|mesh| mesh.own().clone());
        MeshSpec { body: *body, front, back, normals: self.meshes[0].normals(), left: None, told: None }
    }

    /// Count of triangles on front and back together.
    pub(crate) fn triangles(&self) -> usize {
        self.meshes.iter().map(Mesh::triangles).sum()
    }

    /// The board position that an image position sees through the right side, in mm.
    ///
    /// # Errors
    /// The fate of a ray that never reaches the board.
    pub(crate) fn trace(&self, px: DVec2) -> Result<DVec2, Fate> {
        let ray = self.system.camera().ray(px);
        let prism = self.system.prism().ok_or(Fate::Missed)?;
        let out = prism.pass_shapes(&ray, Side::Right, |face, ray| self.meshes[face as usize].intersect(ray))?;
        self.system.board().intersect(&out).map(|(board_mm, _)| board_mm)
    }
}

/// The rectangles that hold where the rays of the right half's outline meet front and back, in the prism's frame, and a little more;
/// `None` without a prism, or where one of these rays ends.
pub fn used_part(system: &System) -> Option<[Rect; 2]> {
    let prism = system.prism()?;
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let place = |k: usize| k as f64 / (PROBES - 1) as f64;
    let nothing = Rect { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
    let mut used = [nothing; 2];
    for (i, j) in (0..PROBES).flat_map(|j| (0..PROBES).map(move |i| (i, j))) {
        let px = DVec2::new(0.5 * width * (1.0 + place(i)), height * place(j));
        let mut met = [DVec2::ZERO; 2];
        let out = prism.pass_shapes(&system.camera().ray(px), Side::Right, |face, ray| {
            let meeting = prism.surface(Side::Right, face).intersect(ray, system.accuracy().surface_residual_mm)?;
            met[face as usize] = ray.at(meeting.t_mm).truncate();
            Ok(meeting)
        });
        out.ok()?;
        for (part, p) in used.iter_mut().zip(met) {
            *part = Rect { min: part.min.min(p), max: part.max.max(p) };
        }
    }
    Some(used.map(|part| Rect { min: part.min - MARGIN * part.size(), max: part.max + MARGIN * part.size() }))
}

/// A rectangle of [`used_part`] without what it holds besides.
pub(super) fn within_margin(part: &Rect) -> Rect {
    let margin = part.size() * (MARGIN / (1.0 + 2.0 * MARGIN));
    Rect { min: part.min + margin, max: part.max - margin }
}
