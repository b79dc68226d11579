//! The rays of a half image beyond the prism: traced, and measured from corners at several depths.

use crate::analysis::half_image::HalfFrame;
use crate::analysis::view::BoardView;
use crate::metrics::MeasuredAndTrue;
use crate::metrics::pixel_map::DEGREE;
use crate::metrics::ray_bundle::{PixelRay, rays_from_depths};
use crate::scene::Scene;
use crate::system::{InLight, System};
use glam::DVec2;

/// The rays of a uniform grid of pixels of a half: measured from the corners at several depths, and traced.
pub(super) fn pixel_rays(
    scene: &Scene,
    system: &System,
    k: usize,
    own: &BoardView,
    asked: &[&BoardView],
) -> MeasuredAndTrue<Vec<PixelRay>> {
    let half = &own.halves[k];
    let traced = grid_sightings(system, &half.frame, scene.analysis.grid);
    let places: Vec<DVec2> = traced.iter().map(|s| s.image_px).collect();
    let found: Option<Vec<_>> = asked.iter().map(|v| v.halves[k].observations(&v.board)[0].clone()).collect();
    MeasuredAndTrue {
        measured: found.map(|depths| rays_from_depths(&depths, &places, DEGREE)),
        exact: half.truth.is_some().then_some(Ok(traced)),
    }
}

/// The exit rays of a uniform `n` x `n` grid over the half image, borders included, where they pass, with their rectified
/// positions.
pub fn grid_sightings(system: &System, frame: &HalfFrame, n: usize) -> Vec<PixelRay> {
    let light = InLight::new(system);
    let centre = frame.own(frame.centre_px(system));
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let along = |k: usize| if n < 2 { 0.0 } else { k as f64 / (n - 1) as f64 - 0.5 };
    let places = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    places
        .filter_map(|(i, j)| {
            let image_px = centre + DVec2::new(along(i) * 0.5 * width, along(j) * height);
            // Rays of the seam itself are taken through this half's own side.
            let ray = light.exit_ray_through(frame.full(image_px), frame.side()).ok()?;
            Some(PixelRay { image_px: frame.rectified(system.camera(), image_px), ray })
        })
        .collect()
}
