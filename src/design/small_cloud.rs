//! A small design for tests.

use super::freeform::{DesignInput, freeform};
use super::point_grid::PointGrid;
use crate::scene::{BiprismSpec, CameraSpec, DesignSettings, GlassSpec, MarchOrder, Method};
use glam::DVec3;

/// The paper's design on a sensor of few, large pixels.
pub(super) fn small_cloud() -> PointGrid {
    let camera = CameraSpec {
        position_mm: DVec3::ZERO,
        focal_length_mm: 35.0,
        width_px: 48,
        height_px: 30,
        pitch_mm: 0.0055 * 40.0,
    };
    let prism = BiprismSpec {
        body: GlassSpec::new(1.48, 1.0),
        ridge_distance_mm: 78.472,
        thickness_mm: 8.545,
        facet_angle_rad: None,
    };
    let settings = DesignSettings { order: MarchOrder::XThenY, degree: 5, method: Method::Rk4, step_px: 1.0 };
    freeform(&DesignInput { camera, prism, settings, virtual_camera_z_mm: 0.0 }).unwrap().cloud
}
