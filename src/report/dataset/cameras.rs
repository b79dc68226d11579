//! `cameras.yml` of a set.

use super::super::cameras::{RECTIFIED, column, pose};
use crate::analysis::dataset::{CameraResidual, SetCameras};
use crate::io::file_storage::{YamlMap, number};
use crate::metrics::pinhole::OPENCV_CENTRE_PX;
use crate::metrics::{Deviation, Unmeasurable};

/// How far a half is from its camera.
type Found = Result<Deviation, Unmeasurable>;

/// What the cameras are.
const FROM: &str = "the virtual cameras that the halves are meant to be; nothing was fitted";

/// The two cameras by the names of OpenCV's `stereoCalibrate`: `M1`, `D1` of the left half, `M2`, `D2` of the right one, each in px
/// of its own, `R` and `T` from the left to the right camera; each camera in the world; and how far the halves are from them.
pub fn cameras_text(cameras: &SetCameras) -> String {
    let mut file = YamlMap::default();
    let size = cameras.frames[0].size_px;
    file.string("pixel_centre", "(i, j)");
    file.string("lengths", "mm");
    file.string("from", FROM);
    file.scalar("image_width", &(size.x as u64).to_string());
    file.scalar("image_height", &(size.y as u64).to_string());
    file.string("positions", if cameras.rectified { RECTIFIED } else { "as in the picture" });
    file.scalar("right_half_first_column", &cameras.frames[1].first_column.to_string());

    // The cameras, and one against the other.
    for (k, (half, pinhole)) in ["left", "right"].into_iter().zip(&cameras.pinholes).enumerate() {
        let (f, c) = (pinhole.focal_px, pinhole.principal_px - OPENCV_CENTRE_PX);
        let place = pose(&pinhole.camera_from_world);
        matrix(&mut file, &format!("M{}", k + 1), &[[f.x, 0.0, c.x], [0.0, f.y, c.y], [0.0, 0.0, 1.0]]);
        file.doubles(&format!("D{}", k + 1), &[&[0.0; 5]]);
        matrix(&mut file, &format!("R_{half}"), &place.r);
        column(&mut file, &format!("T_{half}"), &place.t_mm);
    }
    let [left, right] = cameras.pinholes.each_ref().map(|pinhole| &pinhole.camera_from_world);
    let right_from_left = pose(&right.after(&left.inverse()));
    matrix(&mut file, "R", &right_from_left.r);
    column(&mut file, "T", &right_from_left.t_mm);

    // How far the halves are from them.
    file.string("deviation_columns", "distance_mm left_rms_px left_max_px right_rms_px right_max_px");
    deviations(&mut file, "deviation", cameras, |residual| &residual.raw);
    if let [Some(left), Some(right)] = &cameras.row_shifts {
        deviations(&mut file, "deviation_with_rows_shifted_back", cameras, |residual| &residual.undone);
        for (half, shift) in [("left", left), ("right", right)] {
            let values = [shift.amplitude_px, shift.focal_px, shift.middle_px - OPENCV_CENTRE_PX];
            file.doubles(&format!("row_shift_{half}"), &[&values]);
        }
    }
    file.scalar("baseline_mm", &number(cameras.baseline_mm()));
    file.file()
}

/// A row of sizes for each distance at which both halves see something.
fn deviations(file: &mut YamlMap, key: &str, cameras: &SetCameras, of: fn(&CameraResidual) -> &[Found; 2]) {
    let row = |residual: &CameraResidual| {
        let [Ok(left), Ok(right)] = of(residual) else { return None };
        Some([residual.distance_mm, left.rms, left.max, right.rms, right.max])
    };
    let rows: Vec<[f64; 5]> = cameras.residuals.iter().filter_map(row).collect();
    if !rows.is_empty() {
        matrix(file, key, &rows);
    }
}

fn matrix<const N: usize>(map: &mut YamlMap, key: &str, rows: &[[f64; N]]) {
    map.doubles(key, &rows.iter().map(<[f64; N]>::as_slice).collect::<Vec<_>>());
}
