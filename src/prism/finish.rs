//! Surface finish: what the surfaces of a prism do to rays besides refracting them by their shapes.

use super::surface_modifier::{Relief, Slope};
use crate::effect::Clipping;
use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::surface::hit::Hit;
use glam::{DVec2, DVec3};

/// What the front (0) and the back (1) of a prism do to rays besides refracting them by their shapes; `()` is nothing, and
/// costs nothing.
pub(super) trait Finish {
    /// What tilts the normals of a surface.
    type Relief: Relief;
    /// Whether a ray (in the prism's frame) goes on where it is met.
    fn keep(&self, which: usize, ray: &Ray, meeting: &Hit) -> Result<(), Fate>;
    /// What lies on the front or the back.
    fn relief(&self, which: usize) -> Self::Relief;
}

impl Finish for () {
    type Relief = ();

    #[inline(always)]
    fn keep(&self, _: usize, _: &Ray, _: &Hit) -> Result<(), Fate> {
        Ok(())
    }

    #[inline(always)]
    fn relief(&self, _: usize) {}
}

/// Surfaces a part of which lets no light pass, or that are not smooth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Unideal {
    /// What lets no light pass.
    pub clip: Option<Clipping>,
    /// Slopes that are added to those of the front and the back where light is refracted, and nowhere else.
    pub slopes: [DVec2; 2],
}

impl Unideal {
    /// Whether light goes on from this place (in the prism's frame) of the front (0) or the back (1).
    pub(super) fn passes_at(&self, which: usize, at_mm: DVec3) -> bool {
        self.clip.is_none_or(|clip| clip.margin_mm(which, at_mm) >= 0.0)
    }
}

impl Finish for Unideal {
    type Relief = Slope;

    fn keep(&self, which: usize, ray: &Ray, meeting: &Hit) -> Result<(), Fate> {
        if self.passes_at(which, ray.at(meeting.t_mm)) { Ok(()) } else { Err(Fate::Clipped) }
    }

    fn relief(&self, which: usize) -> Slope {
        Slope(self.slopes[which])
    }
}
