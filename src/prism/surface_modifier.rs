//! Surface modifiers: structure on a surface that is too fine to be intersected, and tilts the normal by which it
//! refracts; `()` is none, and costs nothing.

use crate::surface::hit::Hit;
use crate::surface::shape::Surface;
use glam::{DVec2, DVec3};

/// What lies on a surface.
pub trait Relief {
    /// The unit normal by which a ray is refracted where it meets the surface.
    fn normal(&self, meeting: &Hit) -> DVec3;
    /// How `normal`, which is that of [`Relief::normal`] or its opposite, turns when `point`, where the ray meets `surface`,
    /// moves by `step` along it.
    fn normal_change(&self, surface: &Surface, meeting: &Hit, point: DVec3, normal: DVec3, step: DVec3) -> DVec3;
}

impl Relief for () {
    #[inline(always)]
    fn normal(&self, meeting: &Hit) -> DVec3 {
        meeting.normal
    }

    #[inline(always)]
    fn normal_change(&self, surface: &Surface, meeting: &Hit, point: DVec3, normal: DVec3, step: DVec3) -> DVec3 {
        surface.normal_change(meeting, point, normal, step)
    }
}

/// A slope, dz/dx and dz/dy, that is added to that of the surface as a height z(x, y) in the frame of the prism.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope(pub DVec2);

impl Relief for Slope {
    fn normal(&self, meeting: &Hit) -> DVec3 {
        if self.0 == DVec2::ZERO {
            return meeting.normal;
        }
        let slope = self.0 - meeting.normal.truncate() / meeting.normal.z;
        DVec3::new(-slope.x, -slope.y, 1.0).normalize()
    }

    fn normal_change(&self, surface: &Surface, meeting: &Hit, point: DVec3, normal: DVec3, step: DVec3) -> DVec3 {
        if self.0 == DVec2::ZERO {
            return surface.normal_change(meeting, point, normal, step);
        }
        let smooth = meeting.normal;
        let turn = surface.normal_change(meeting, point, smooth, step);
        // Both slopes change alike: of a normal n the slope is -n.xy / n.z, and n / n.z has the length 1 / |n.z|.
        let change = ((turn.truncate() - smooth.truncate() * (turn.z / smooth.z)) / smooth.z).extend(0.0);
        (change - normal * normal.dot(change)) * normal.z
    }
}
