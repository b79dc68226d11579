//! The cameras that the halves of a picture are used as, for a report and for OpenCV.

use super::json::{CameraEntry, Cameras, Geometry, PairPose, judgement as to};
use crate::analysis::judge::{CameraFigures, Judgement};
use crate::geom::Pose;
use crate::io::file_storage::{YamlMap, number};
use crate::metrics::pinhole::{OPENCV_CENTRE_PX, Pinhole};
use crate::metrics::reprojection::PinholeFit;
use glam::DMat3;

/// What positions the cameras are for where the real camera has a lens or a turn of its own.
pub(super) const RECTIFIED: &str = "where a plain camera of the same focal length in pixels would see them";

/// The geometry of the pair.
pub fn geometry(judgement: &Judgement) -> Geometry {
    to::geometry(&judgement.cameras.geometry, judgement.depths_mm)
}

/// The cameras by true corners where these are known, else by those that were found; `None` where they could not be fitted.
pub fn entry(judgement: &Judgement) -> Option<Cameras> {
    let CameraFigures { free, fits, .. } = &judgement.cameras;
    let of = |side: usize| {
        let fit = |k: usize| [&fits[k].exact, &fits[k].measured][side].as_ref()?.as_ref().ok();
        Some([fit(0)?, fit(1)?])
    };
    let (from, [left, right]) = of(0).map(|fits| ("true corners", fits)).or(Some(("found corners", of(1)?)))?;
    let size = judgement.view.halves[0].frame.size_px;
    let second = &judgement.view.halves[1].frame;
    let right_from_left = right.pinhole.camera_from_world.after(&left.pinhole.camera_from_world.inverse());
    Some(Cameras {
        from: from.to_owned(),
        free: free.iter().map(|parameter| parameter.name().to_owned()).collect(),
        depths_mm: judgement.depths_mm,
        size_px: [size.x as u64, size.y as u64],
        right_half_first_column: second.first_column as u64,
        rectified: !judgement.view.halves[0].taken_by.is_plain(),
        left: camera(left),
        right: camera(right),
        right_from_left: pose(&right_from_left),
    })
}

fn camera(fit: &PinholeFit) -> CameraEntry {
    let Pinhole { focal_px, principal_px, camera_from_world } = fit.pinhole;
    let centre = principal_px - OPENCV_CENTRE_PX;
    CameraEntry {
        k: [[focal_px.x, 0.0, centre.x], [0.0, focal_px.y, centre.y], [0.0, 0.0, 1.0]],
        camera_from_world: pose(&camera_from_world),
        rms_px: fit.deviation.rms,
        n: fit.deviation.n as u64,
    }
}

/// A motion, row by row.
pub(super) fn pose(pose: &Pose) -> PairPose {
    PairPose { r: rows(&pose.rotation), t_mm: pose.translation_mm.to_array() }
}

fn rows(m: &DMat3) -> [[f64; 3]; 3] {
    m.transpose().to_cols_array_2d()
}

/// `cameras.yml`: for each judged prism a map by its name, with the names of OpenCV's `stereoCalibrate`: `M1`, `D1` of the left
/// half, `M2`, `D2` of the right one, `R`, `T` from the left to the right camera; and what they came from.
pub(crate) fn opencv_text(designs: &[(String, Cameras)]) -> String {
    let mut file = YamlMap::default();
    file.string("pixel_centre", "(i, j)");
    file.string("lengths", "mm");
    for (name, cameras) in designs {
        file.map(name, &opencv_map(cameras));
    }
    file.file()
}

fn opencv_map(cameras: &Cameras) -> YamlMap {
    let mut map = YamlMap::default();
    let words = |list: &[String]| list.join(" ");
    map.string("from", &cameras.from);
    map.string("free", &words(&cameras.free));
    map.scalar("image_width", &cameras.size_px[0].to_string());
    map.scalar("image_height", &cameras.size_px[1].to_string());
    map.string("positions", if cameras.rectified { RECTIFIED } else { "as in the picture" });
    map.scalar("right_half_first_column", &cameras.right_half_first_column.to_string());
    for (k, half, camera) in [(1, "left", &cameras.left), (2, "right", &cameras.right)] {
        let matrix = |map: &mut YamlMap, key: &str, m: &[[f64; 3]; 3]| {
            map.doubles(key, &m.each_ref().map(|row| row.as_slice()));
        };
        matrix(&mut map, &format!("M{k}"), &camera.k);
        map.doubles(&format!("D{k}"), &[&[0.0; 5]]);
        matrix(&mut map, &format!("R_{half}"), &camera.camera_from_world.r);
        column(&mut map, &format!("T_{half}"), &camera.camera_from_world.t_mm);
        map.scalar(&format!("rms_px_{half}"), &number(camera.rms_px));
    }
    map.doubles("R", &cameras.right_from_left.r.each_ref().map(|row| row.as_slice()));
    column(&mut map, "T", &cameras.right_from_left.t_mm);
    map
}

/// A column of numbers.
pub(super) fn column(map: &mut YamlMap, key: &str, values: &[f64; 3]) {
    map.doubles(key, &values.each_ref().map(std::slice::from_ref));
}
