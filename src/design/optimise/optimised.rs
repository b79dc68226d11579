//! The prism that the search finds, as polynomials.

use super::passage::Fixed;
use super::refusals;
use super::search::search;
use super::start::Start;
use crate::design::designed_law::DesignedLaw;
use crate::design::virtual_camera::VirtualCamera;
use crate::error::Error;
use crate::geom::Rect;
use crate::scene::{CameraSpec, DesignSettings, Rear};
use crate::surface::shape::PolynomialPatch;
use glam::DVec2;

/// What least squares found.
#[derive(Debug, Clone)]
pub(in crate::design) struct Optimised {
    pub(in crate::design) front: PolynomialPatch,
    pub(in crate::design) back: PolynomialPatch,
    pub(in crate::design) law: DesignedLaw,
    pub(in crate::design) floor_reached: bool,
}

/// The prism of least squares for the right half of `camera`, from the flat one whose virtual camera is `target`.
///
/// # Errors
/// An [`Error`] when a ray does not pass the flat prism, or what is asked for cannot be had: then it names the residual that is
/// left.
pub(in crate::design) fn optimised(
    camera: &CameraSpec,
    target: &VirtualCamera,
    settings: &DesignSettings,
) -> Result<Optimised, Error> {
    let start = Start::new(camera, target, settings).ok_or_else(|| refusals::no_start(settings))?;
    let found = search(&start).ok_or_else(|| refusals::no_start(settings))?;
    refusals::check(settings, &found)?;
    let candidate = found.merit.layout.candidate(&found.x);
    let [front, back] = candidate.sheets();
    let [over_front, over_back] = start.met([&front, &back]).ok_or_else(|| refusals::no_start(settings))?;
    let over_back = if settings.goal.rear == Rear::Own { over_back } else { over_both_halves(over_back) };
    let patch = |sheet: Fixed<'_>, domain| PolynomialPatch { sag: sheet.basis.polynomial(sheet.c), domain };
    Ok(Optimised {
        front: patch(front, over_front),
        back: patch(back, over_back),
        law: candidate.law(),
        floor_reached: found.floor_reached,
    })
}

/// One surface for both halves reaches as far to the left as to the right.
fn over_both_halves(domain: Rect) -> Rect {
    let reach = domain.min.x.abs().max(domain.max.x.abs());
    Rect { min: DVec2::new(-reach, domain.min.y), max: DVec2::new(reach, domain.max.y) }
}
