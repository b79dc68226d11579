//! Refraction of a ray at one surface.

use super::payload::{Payload, RefractionEvent};
use super::surface_modifier::SurfaceModifier;
use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::optics::snell::refract;
use crate::surface::hit::Hit;
use crate::surface::shape::Surface;

/// The ray behind `surface`, met at `hit` and refracted by the normal of `modifier`, with `eta` = n_in / n_out; `payload`
/// goes on with it.
///
/// # Errors
/// [`Fate::TotalReflection`] beyond the critical angle.
#[inline(always)]
pub fn pass<C: Payload>(
    ray: &Ray,
    surface: &Surface,
    modifier: &impl SurfaceModifier,
    hit: &Hit,
    eta: f64,
    payload: &mut C,
) -> Result<Ray, Fate> {
    payload.reached(ray, hit);
    let out = refract(ray.direction, modifier.normal(hit), eta).ok_or(Fate::TotalReflection)?;
    payload.refracted(&RefractionEvent { ray, surface, modifier, hit, eta, out: &out });
    Ok(Ray { origin: ray.at(hit.t_mm), direction: out.direction })
}
