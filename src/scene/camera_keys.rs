//! The keys of the camera as they are written, and what they come to.

use super::document::Document;
use super::limits::*;
use super::model::{CalibrationSpec, CameraSpec};
use super::rules;
use super::source::ValueSource;
use super::surface_files::find;
use crate::error::Error;
use crate::geom::{Distortion, Pose};
use crate::io::calibration::{self, OpenCvCalibration};
use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraFile {
    /// Distance from the pinhole to the sensor, in mm. Required where `calibration` does not give it.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) focal_length_mm: Option<f64>,
    /// Columns of the sensor.
    #[schemars(range(min = 1, max = SIDE_PX))]
    pub(super) width_px: usize,
    /// Rows of the sensor.
    #[schemars(range(min = 1, max = SIDE_PX))]
    pub(super) height_px: usize,
    /// Side of a square pixel, in um.
    #[schemars(range(min = SMALLEST_PITCH_UM, max = LARGEST_PITCH_UM))]
    pub(super) pixel_pitch_um: f64,
    /// Position [x, y, z] of the pinhole, in mm.
    #[serde(default)]
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) position_mm: [f64; 3],
    /// Principal point [cx, cy], where the axis of the lens meets the sensor, in px. Pixel (i, j) covers [i, i + 1) x [j, j + 1),
    /// so that the middle of the upper left pixel is at (0.5, 0.5); OpenCV's cx and cy are 0.5 less. Left out, it is the middle of
    /// the sensor.
    #[schemars(inner(range(min = -PRINCIPAL_PX, max = PRINCIPAL_PX)))]
    pub(super) principal_point_px: Option<[f64; 2]>,
    /// Rotation [rx, ry, rz] of the camera with its lens about its pinhole, about the fixed x, then y, then z axis, in deg: as
    /// `tilt_deg` of prism and board, which stay where they are.
    #[serde(default)]
    #[schemars(inner(range(min = -TILT_DEG, max = TILT_DEG)))]
    pub(super) rotation_deg: [f64; 3],
    /// Distortion of the lens as OpenCV's [k1, k2, p1, p2, k3]. They map undistorted to distorted coordinates: a direction with
    /// the tangents x, y to the camera's axis, r^2 = x^2 + y^2, is seen at cx + fx (x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y +
    /// p2 (r^2 + 2 x^2)), with fx the focal length in px, and likewise along y. The inverse, a pixel's ray, is exact. It must not fold the picture over inside the
    /// sensor or up to a twentieth of its size around. Neither it nor the two keys above stand beside `effect.telecentric`.
    #[serde(default)]
    #[schemars(inner(range(min = -DISTORTION, max = DISTORTION)))]
    pub(super) distortion: [f64; 5],
    /// File of a calibration by OpenCV, relative to the scene file, YAML or JSON as cv2.FileStorage writes it: `camera_matrix` (or
    /// K) and `distortion_coefficients` (or D), not those of cv2.fisheye; `image_width` and `image_height` are compared with the
    /// sensor where they are there. It takes the place of `focal_length_mm` (fx times the pixel pitch), `principal_point_px` and
    /// `distortion`; where fy is not fx, the scale of the picture along y is its own.
    #[schemars(length(min = 1, max = PATH_CHARS))]
    pub(super) calibration: Option<String>,
}

/// The camera that `file` describes; a calibration is looked for in `folder`.
pub(super) fn camera(document: &Document, file: &CameraFile, folder: Option<&Path>) -> Result<CameraSpec, Error> {
    let pitch_mm = file.pixel_pitch_um / 1000.0;
    let rotation = Pose::new(DVec3::ZERO, DVec3::from_array(file.rotation_deg.map(f64::to_radians))).rotation;
    let (focal_length_mm, calibration) = match (&file.calibration, file.focal_length_mm) {
        (Some(name), _) => {
            let found = calibrated(document, file, name, folder)?;
            let own = CalibrationSpec {
                principal_px: Some(found.principal_px),
                rotation,
                distortion: Distortion::new(found.distortion),
                focal_ratio: found.focal_px.y / found.focal_px.x,
            };
            (found.focal_px.x * pitch_mm, own)
        }
        (None, Some(focal_length_mm)) => {
            let own = CalibrationSpec {
                principal_px: file.principal_point_px.map(DVec2::from_array),
                rotation,
                distortion: Distortion::new(file.distortion),
                focal_ratio: 1.0,
            };
            (focal_length_mm, own)
        }
        (None, None) => {
            let rule = "`camera.focal_length_mm` is missing".to_owned();
            let help = "add `focal_length_mm = ...` to `[camera]`: distance from the pinhole to the sensor, in mm; or \
                        `calibration = \"camera.yml\"`";
            return Err(document.refuse("camera", rule, help));
        }
    };
    let camera = CameraSpec {
        position_mm: DVec3::from_array(file.position_mm),
        focal_length_mm,
        width_px: file.width_px,
        height_px: file.height_px,
        pitch_mm,
        calibration,
    };
    let key = if file.calibration.is_some() { "camera.calibration" } else { "camera.distortion" };
    rules::picture_is_not_folded(document, key, &camera).map(|()| camera)
}

/// What the calibration file `name` says, where no key beside it says the same and its numbers may stand in a scene.
fn calibrated(
    document: &Document,
    file: &CameraFile,
    name: &str,
    folder: Option<&Path>,
) -> Result<OpenCvCalibration, Error> {
    const KEY: &str = "camera.calibration";
    for key in ["focal_length_mm", "principal_point_px", "distortion"] {
        if document.has("camera", key) {
            let rule = format!("`camera.{key}` stands beside `{KEY}`, which gives it");
            return Err(document.refuse(&format!("camera.{key}"), rule, "keep one of the two"));
        }
    }
    let found = calibration::read(&find(document, KEY, name, folder)?)?;
    for (what, said, own) in
        [("image_width", found.size_px[0], file.width_px), ("image_height", found.size_px[1], file.height_px)]
    {
        if let Some(said) = said.filter(|said| *said != own as f64) {
            let key = what.replace("image_", "");
            let rule = format!("`{KEY}` is {name:?}, whose `{what}` is {said}, and `camera.{key}_px` is {own}");
            let help = "give the sensor that was calibrated: a calibration holds for its own pictures";
            return Err(document.refuse(&format!("camera.{key}_px"), rule, help));
        }
    }
    let focal_mm = found.focal_px.x * file.pixel_pitch_um / 1000.0;
    let largest = found.distortion.iter().fold(0.0f64, |most, k| most.max(k.abs()));
    let numbers = [
        ("a focal length in mm", focal_mm, SHORTEST_MM, LONGEST_MM),
        ("a ratio fy / fx", found.focal_px.y / found.focal_px.x, 1.0 / FOCAL_RATIO, FOCAL_RATIO),
        ("a principal point in px", found.principal_px.abs().max_element(), 0.0, PRINCIPAL_PX),
        ("a coefficient of distortion", largest, 0.0, DISTORTION),
    ];
    // NaN is in no range.
    match numbers.into_iter().find(|(_, value, low, high)| !(low..=high).contains(&value)) {
        None => Ok(found),
        Some((what, value, low, high)) => {
            let rule = format!("`{KEY}` is {name:?}, which gives {what} of {value}, and it must be {low} to {high}");
            Err(document.refuse(KEY, rule, "check the calibration and `pixel_pitch_um`"))
        }
    }
}
