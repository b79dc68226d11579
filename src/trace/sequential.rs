//! A ray through a known sequence of surfaces.

use super::carry::Carry;
use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::optics::snell::refract;
use crate::optics::surface::{Meeting, Surface};
use glam::DVec3;

/// The ray behind `surface`, met at `meeting` and refracted by `normal` (that of the meeting, but for a rough surface), with
/// `eta` = n_in / n_out.
#[inline(always)]
pub fn pass<C: Carry>(
    ray: &Ray,
    surface: &Surface,
    meeting: &Meeting,
    normal: DVec3,
    eta: f64,
    carry: &mut C,
) -> Result<Ray, Fate> {
    let out = refract(ray.direction, normal, eta).ok_or(Fate::TotalReflection)?;
    carry.refracted(ray, surface, meeting, eta, &out);
    Ok(Ray { origin: ray.at(meeting.t_mm), direction: out.direction })
}
