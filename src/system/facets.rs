//! Facets and pieces: which parts of a prism of triangles, and which back of a solid one, a ray passes.

use super::instrument::{BoardHit, System};
use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::prism::biprism::Prism;
use crate::prism::payload::PartsPassed;
use crate::prism::side::Side;
use crate::prism::triangles::{BehindTriangle, TrianglePair};
use crate::surface::face::Face;
use glam::DVec2;

/// A way through the glass: by the front of a side and the back of one, another only of a solid prism.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Way {
    pub(crate) front: Side,
    pub(crate) back: Side,
}

impl Way {
    /// The way through one side.
    pub(crate) const fn through(side: Side) -> Self {
        Self { front: side, back: side }
    }
}

impl System {
    /// The ray of `px` behind the prism when it takes a way, continued beyond the ridges as if both its surfaces went on; and where it
    /// meets the back of a solid prism, along x of the prism's frame, in mm: 0 of another.
    ///
    /// # Errors
    /// The fate of a ray that does not.
    pub(crate) fn exit_ray_by(&self, px: DVec2, way: Way) -> Result<(Ray, f64), Fate> {
        let Some(prism) = self.prism.as_ref().filter(|prism| prism.is_solid()) else {
            return self.exit_ray_through(px, way.front).map(|ray| (ray, 0.0));
        };
        let mut back_x_mm = 0.0;
        let ray = prism.pass_shapes(&self.camera.ray(px), way.front, |face, own| {
            let side = if face == Face::Front { way.front } else { way.back };
            let met = prism.surface(side, face).intersect(own, self.accuracy.surface_residual_mm)?;
            back_x_mm = own.at(met.t_mm).x;
            Ok(met)
        })?;
        Ok((ray, back_x_mm))
    }

    /// Whether the ray of `px`, which passes the front of that side, takes this way.
    pub(crate) fn takes(&self, px: DVec2, way: Way) -> bool {
        !self.prism.as_ref().is_some_and(Prism::is_solid) || self.leaves_by_back_of(px, way.back)
    }

    /// The facets and pieces of front and back that the ray of `px` passes: where the facets are others, what `px` sees may jump,
    /// and where the pieces are, it may have a kink.
    pub(crate) fn parts(&self, px: DVec2) -> PartsPassed {
        let mut parts = PartsPassed::default();
        // A ray that ends has passed what it has passed.
        let _ = self.exit(self.camera.ray(px), &mut parts);
        parts
    }

    /// What `px` sees, and [`System::parts`] of its ray.
    pub(crate) fn trace_with_parts(&self, px: DVec2) -> (Result<BoardHit, Fate>, PartsPassed) {
        let mut parts = PartsPassed::default();
        let seen = self
            .exit(self.camera.ray(px), &mut parts)
            .and_then(|(ray, side)| self.board.intersect(&ray).map(|(board_mm, _)| BoardHit { board_mm, side }));
        (seen, parts)
    }

    /// The triangles that the ray of `px` passes; `None` where it ends.
    pub(crate) fn triangles_at(&self, px: DVec2) -> Option<TrianglePair> {
        let mut parts = PartsPassed::default();
        let (_, side) = self.exit(self.camera.ray(px), &mut parts).ok()?;
        Some(TrianglePair { side, triangles: parts.triangles })
    }

    /// The ray of `px` in the glass behind a triangle of the front, which is continued beyond its sides, in the prism's frame; how far
    /// within its sides it passes is linear in `px` where the camera keeps lines.
    pub(crate) fn behind_front(&self, px: DVec2, side: Side, triangle: u32) -> Option<BehindTriangle> {
        let ray = self.camera.ray(px);
        let behind = self.prism.as_ref()?.behind_front(&ray, side, triangle, self.accuracy.surface_residual_mm)?;
        Some(BehindTriangle { within: behind.within.map(|value| value / ray.direction.z), ..behind })
    }

    /// What a ray of the glass sees behind a triangle of the back, in mm on the board, and how far within its sides it passes.
    pub(crate) fn seen_behind_back(&self, inside: &Ray, side: Side, triangle: u32) -> Option<(DVec2, [f64; 4])> {
        let behind = self.prism.as_ref()?.behind_back(inside, side, triangle, self.accuracy.surface_residual_mm)?;
        let (seen_mm, _) = self.board.intersect(&behind.ray).ok()?;
        Some((seen_mm, behind.within))
    }

    /// The triangle beyond a side of one of a face.
    pub(crate) fn beyond(&self, side: Side, face: Face, triangle: u32, of: usize) -> Option<u32> {
        self.prism.as_ref()?.surface(side, face).neighbour(triangle, of)
    }

    /// Whether triangles alone tell what is seen: of a prism with a mesh, that nothing clips and whose surfaces are ideal.
    pub(crate) fn is_told_by_triangles(&self) -> bool {
        let parted = self.most_parts() != [1; 2] && !self.is_creased_by_halves_alone();
        parted && self.stop.is_none() && self.prism.as_ref().is_some_and(Prism::is_ideal)
    }

    /// Whether the ray of `px` leaves a solid prism by the back of this side.
    pub(crate) fn leaves_by_back_of(&self, px: DVec2, side: Side) -> bool {
        self.parts(px).facets[Face::Back as usize] == side as u32
    }

    /// Whether the only crease of the prism is the one in which the backs of both halves meet.
    pub(crate) fn is_creased_by_halves_alone(&self) -> bool {
        self.prism.as_ref().is_some_and(|prism| {
            let mut surfaces = Side::ALL.into_iter().flat_map(|side| Face::ALL.map(|face| (side, face)));
            prism.is_solid() && surfaces.all(|(side, face)| prism.surface(side, face).part_counts() == [1; 2])
        })
    }

    /// How many facets, and how many pieces, the surface with the most of them has: 1 of one without creases or kinks, and
    /// without glass.
    pub(crate) fn most_parts(&self) -> [usize; 2] {
        let sides = [Side::Left, Side::Right].into_iter();
        let surfaces = sides.flat_map(|side| Face::ALL.map(|face| (side, face)));
        let counts = surfaces.filter_map(|(side, face)| Some(self.prism.as_ref()?.surface(side, face).part_counts()));
        // The two backs of a solid prism meet in a crease.
        let backs = if self.prism.as_ref().is_some_and(Prism::is_solid) { 2 } else { 1 };
        counts.fold([backs, 1], |[a, b], [c, d]| [a.max(c), b.max(d)])
    }
}
