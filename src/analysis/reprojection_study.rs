//! The design paper's Table 1 and Fig. 5: where the rays behind the prism pierce a plane, less where the virtual camera's would.

use super::half_image::{HalfFrame, row_shift, virtual_camera};
use super::judge::grid_sightings;
use crate::error::Error;
use crate::metrics::ray_bundle::{PixelRay, PlaneDeviation, on_plane};
use crate::scene::Scene;
use crate::system::System;
use crate::vision::half::Half;
use glam::DVec2;

/// The errors of one half on one plane.
#[derive(Debug, Clone, PartialEq)]
pub struct ReprojectionErrors {
    /// z of the plane in the virtual camera's frame, in mm; that of the inverted image is -f.
    pub plane_mm: f64,
    /// Places of the rays in the half image, in px of it.
    pub places_px: Vec<DVec2>,
    /// The errors at these, with their sizes.
    pub deviation: PlaneDeviation,
}

/// The errors of `half` over a uniform grid of `grid` x `grid` rays, borders included: in the plane of the inverted virtual image,
/// where the paper's Table 1 is taken, and in those `depths_mm` from the virtual camera.
///
/// # Errors
/// When the half has no virtual camera, or no ray of the grid passes.
pub fn errors(
    scene: &Scene,
    system: &System,
    half: Half,
    grid: usize,
    depths_mm: &[f64],
) -> Result<Vec<ReprojectionErrors>, Error> {
    let frame = HalfFrame::new(system, half);
    let help = "use a pinhole camera whose half images look through the prism";
    let camera = virtual_camera(system, &frame)
        .map_err(|why| Error::new("the half image", format!("it has no virtual camera: {}", why.reason()), help))?;
    let sightings = grid_sightings(system, &frame, grid);
    let places_px: Vec<DVec2> = sightings.iter().map(|s| s.image_px).collect();

    // Undo the shift of each row that the prism's law knows.
    let rows = row_shift(system, &frame);
    let undone = |s: PixelRay| PixelRay { image_px: rows.map_or(s.image_px, |rows| rows.undone(s.image_px)), ..s };
    let sightings: Vec<PixelRay> = sightings.into_iter().map(undone).collect();
    let planes = std::iter::once(-scene.camera.focal_length_mm).chain(depths_mm.iter().copied());
    planes
        .map(|plane_mm| {
            let deviation = on_plane(&camera, &sightings, plane_mm)
                .map_err(|why| Error::new("the rays behind the prism", why.to_string(), help))?;
            Ok(ReprojectionErrors { plane_mm, places_px: places_px.clone(), deviation })
        })
        .collect()
}
