//! Facets and pieces: which parts of a prism of triangles, and which back of a solid one, a ray passes.

use super::instrument::{BoardHit, System};
use crate::optics::fate::Fate;
use crate::prism::biprism::Prism;
use crate::prism::payload::PartsPassed;
use crate::prism::side::Side;
use crate::surface::face::Face;
use glam::DVec2;

impl System {
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
