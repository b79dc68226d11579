//! A ray through a known sequence of surfaces.

use super::payload::Payload;
use super::surface_modifier::Relief;
use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::optics::snell::refract;
use crate::surface::hit::Hit;
use crate::surface::shape::Surface;

/// The ray behind `surface`, met at `meeting` and refracted by the normal of `relief`, with `eta` = n_in / n_out.
#[inline(always)]
pub fn pass<C: Payload>(
    ray: &Ray,
    surface: &Surface,
    relief: &impl Relief,
    meeting: &Hit,
    eta: f64,
    carry: &mut C,
) -> Result<Ray, Fate> {
    carry.reached(ray, meeting);
    let out = refract(ray.direction, relief.normal(meeting), eta).ok_or(Fate::TotalReflection)?;
    carry.refracted(ray, surface, relief, meeting, eta, &out);
    Ok(Ray { origin: ray.at(meeting.t_mm), direction: out.direction })
}
