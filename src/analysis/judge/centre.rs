//! The rays of a half against one centre of projection.

use super::rays::pixel_rays;
use crate::analysis::view::BoardView;
use crate::geom::Ray;
use crate::metrics::MeasuredAndTrue;
use crate::metrics::ray_bundle::{CommonPoint, RayMisses, common_point, misses};
use crate::scene::Scene;
use crate::system::System;
use glam::DVec3;

/// The rays of one half against one centre of projection.
#[derive(Debug, Clone, PartialEq)]
pub struct CentreFigures {
    /// The designed centre, in mm.
    pub designed_mm: DVec3,
    /// Best common point of the rays behind the prism.
    pub common: MeasuredAndTrue<CommonPoint>,
    /// Distances of the rays from the designed centre.
    pub misses: MeasuredAndTrue<RayMisses>,
}

/// The centre of a half; `None` where its virtual camera is unknown.
pub(super) fn centre_figures(
    scene: &Scene,
    system: &System,
    k: usize,
    own: &BoardView,
    asked: &[&BoardView],
) -> Option<CentreFigures> {
    let designed_mm = own.halves[k].camera.ok()?.centre_mm();
    let rays = pixel_rays(scene, system, k, own, asked).then(|s| Ok(s.iter().map(|s| s.ray).collect::<Vec<Ray>>()));
    Some(CentreFigures {
        designed_mm,
        common: rays.then(|rays| common_point(rays)),
        misses: rays.then(|rays| misses(rays, designed_mm)),
    })
}
