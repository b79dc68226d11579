//! Points of the surfaces that least squares found, on the grid of the march.

use super::merit::HalfCamera;
use super::passage::{GlassRay, meet};
use super::refusals;
use crate::design::designed_law::DesignedLaw;
use crate::design::march::GridLayout;
use crate::design::point_grid::{PointGrid, TargetLaw};
use crate::design::virtual_camera::VirtualCamera;
use crate::error::Error;
use crate::scene::{CameraSpec, DesignSettings, MarchOrder};
use crate::surface::shape::PolynomialPatch;
use rayon::prelude::*;

/// Where the rays of pixels meet the front, and the rays of the law's camera the back.
///
/// # Errors
/// An [`Error`] when the grid is refused, or a ray does not meet its surface.
pub(in crate::design) fn cloud(
    camera: &CameraSpec,
    target: &VirtualCamera,
    settings: &DesignSettings,
    patches: [&PolynomialPatch; 2],
    law: DesignedLaw,
) -> Result<PointGrid, Error> {
    let GridLayout { u_px, v_px, .. } = GridLayout::new(camera, settings)?;
    let half = HalfCamera::of(camera, target);
    let [front, back] = patches.map(|patch| &patch.sag);
    let heights = |u_px: f64, v_px: f64| {
        let [u_mm, v_mm] = [u_px, v_px].map(|px| px * camera.pitch_mm);
        let [x, y] = law.direction(target.half_centre_mm, [u_mm, v_mm]);
        let seen = GlassRay { origin: law.eye_mm, direction: [x, y, 1.0] };
        Some([meet(&half.ray::<f64>(u_mm, v_mm), front)?.0[2], meet(&seen, back)?.0[2]])
    };
    let z_mm = u_px
        .par_iter()
        .map(|&u| v_px.iter().map(|&v| heights(u, v)).collect::<Option<Vec<_>>>())
        .collect::<Option<Vec<_>>>()
        .ok_or_else(|| refusals::no_start(settings))?
        .concat();
    let (order, law) = (MarchOrder::XThenY, TargetLaw::Designed(law));
    Ok(PointGrid { camera: *target, pitch_mm: camera.pitch_mm, order, law, u_px, v_px, z_mm })
}
