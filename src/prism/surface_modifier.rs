//! What a surface of a prism does to rays besides refracting them by its shape: it clips them, or its finest structure tilts
//! the normal by which it refracts.

use crate::effect::Clipping;
use crate::optics::fate::Fate;
use crate::surface::face::Face;
use crate::surface::hit::Hit;
use crate::surface::shape::Surface;
use glam::{DVec2, DVec3};

/// What one surface does to rays besides refracting them by its shape; `()` is nothing, and costs nothing.
pub trait SurfaceModifier {
    /// Whether light goes on from this place of the surface, in the prism's frame.
    ///
    /// # Errors
    /// The fate of a ray that does not.
    fn pass(&self, at_mm: impl FnOnce() -> DVec3) -> Result<(), Fate>;
    /// The unit normal by which a ray is refracted where it meets the surface.
    fn normal(&self, hit: &Hit) -> DVec3;
    /// How `normal`, which is that of [`SurfaceModifier::normal`] or its opposite, turns when `point`, where the ray meets
    /// `surface`, moves by `step` along it.
    fn normal_change(&self, surface: &Surface, hit: &Hit, point: DVec3, normal: DVec3, step: DVec3) -> DVec3;
}

impl SurfaceModifier for () {
    #[inline(always)]
    fn pass(&self, _: impl FnOnce() -> DVec3) -> Result<(), Fate> {
        Ok(())
    }

    #[inline(always)]
    fn normal(&self, hit: &Hit) -> DVec3 {
        hit.normal
    }

    #[inline(always)]
    fn normal_change(&self, surface: &Surface, hit: &Hit, point: DVec3, normal: DVec3, step: DVec3) -> DVec3 {
        surface.normal_change(hit, point, normal, step)
    }
}

/// A surface a part of which lets no light pass, or that is not smooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Imperfections {
    /// Which of the two surfaces it is.
    pub face: Face,
    /// What lets no light pass.
    pub clip: Option<Clipping>,
    /// A slope, dz/dx and dz/dy, that is added to that of the surface as a height z(x, y) in the frame of the prism where
    /// light is refracted, and nowhere else.
    pub slope: DVec2,
}

impl Imperfections {
    /// Whether the surface is smooth and lets all light pass.
    pub(super) fn is_nothing(&self) -> bool {
        self.clip.is_none() && self.slope == DVec2::ZERO
    }

    /// Whether light goes on from this place, in the prism's frame.
    pub(super) fn passes_at(&self, at_mm: DVec3) -> bool {
        self.clip.is_none_or(|clip| clip.margin_mm(self.face, at_mm) >= 0.0)
    }
}

impl SurfaceModifier for Imperfections {
    fn pass(&self, at_mm: impl FnOnce() -> DVec3) -> Result<(), Fate> {
        if self.passes_at(at_mm()) { Ok(()) } else { Err(Fate::Clipped) }
    }

    fn normal(&self, hit: &Hit) -> DVec3 {
        if self.slope == DVec2::ZERO {
            return hit.normal;
        }
        let slope = self.slope - hit.normal.truncate() / hit.normal.z;
        DVec3::new(-slope.x, -slope.y, 1.0).normalize()
    }

    fn normal_change(&self, surface: &Surface, hit: &Hit, point: DVec3, normal: DVec3, step: DVec3) -> DVec3 {
        if self.slope == DVec2::ZERO {
            return surface.normal_change(hit, point, normal, step);
        }
        let smooth = hit.normal;
        let turn = surface.normal_change(hit, point, smooth, step);
        // Both slopes change alike: of a normal n the slope is -n.xy / n.z, and n / n.z has the length 1 / |n.z|.
        let change = ((turn.truncate() - smooth.truncate() * (turn.z / smooth.z)) / smooth.z).extend(0.0);
        (change - normal * normal.dot(change)) * normal.z
    }
}
