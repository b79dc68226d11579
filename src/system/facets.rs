//! Facets: which parts of a prism of triangles a ray passes.

use super::instrument::System;
use crate::prism::payload::Facets;
use crate::prism::side::Side;
use crate::surface::face::Face;
use glam::DVec2;

impl System {
    /// The facets of front and back that the ray of `px` passes: where they are others, what `px` sees may jump.
    pub(crate) fn facets(&self, px: DVec2) -> [u32; 2] {
        let mut facets = Facets::default();
        // A ray that ends has passed what it has passed.
        let _ = self.exit(self.camera.ray(px), &mut facets);
        facets.crossed()
    }

    /// How many facets the surface with the most of them has: 1 without creases, and without glass.
    pub(crate) fn most_facets(&self) -> usize {
        let sides = [Side::Left, Side::Right].into_iter();
        let surfaces = sides.flat_map(|side| Face::ALL.map(|face| (side, face)));
        surfaces.filter_map(|(side, face)| Some(self.prism.as_ref()?.surface(side, face).facets())).fold(1, usize::max)
    }
}
