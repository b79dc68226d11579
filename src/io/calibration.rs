//! The calibration of a camera from a file of OpenCV: what `cv2.FileStorage` writes of the results of `cv2.calibrateCamera`.
//!
//! YAML and JSON are read. The camera matrix goes by `camera_matrix`, `cameraMatrix` or `K`, the distortion by
//! `distortion_coefficients`, `distCoeffs`, `dist_coeffs` or `D`, in OpenCV's order k1, k2, p1, p2[, k3, ...]; `image_width` and
//! `image_height` may be there. All else is passed over.

use super::corners::{PixelCentre, move_centre};
use super::file_storage::{Entries, Fault, RawMatrix};
use super::inputs::read_text;
use crate::error::Error;
use glam::DVec2;
use serde_json::Value;
use std::path::Path;

/// Bytes in a file at most: a calibration may hold the corners of its pictures.
pub const MOST_BYTES: u64 = 1 << 26;
/// Values of a matrix that is asked for, at most: OpenCV's models have up to 14 coefficients.
const MOST_VALUES: usize = 64;
/// Coefficients of the model that is taken: k1, k2, p1, p2, k3.
const COEFFICIENTS: usize = 5;

const MATRIX_KEYS: [&str; 3] = ["camera_matrix", "cameraMatrix", "K"];
const DISTORTION_KEYS: [&str; 4] = ["distortion_coefficients", "distCoeffs", "dist_coeffs", "D"];
const SIZE_KEYS: [&str; 2] = ["image_width", "image_height"];
/// What OpenCV's samples call a calibration by another model.
const FISHEYE_KEY: &str = "fisheye_model";

const HELP: &str = "write it with cv2.FileStorage, with the camera matrix as `camera_matrix` and the distortion as \
                    `distortion_coefficients`";

/// What a file says of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenCvCalibration {
    /// fx and fy, in px.
    pub focal_px: DVec2,
    /// The principal point, in px, the middle of the upper left pixel at (0.5, 0.5): half a pixel more than in the file.
    pub principal_px: DVec2,
    /// k1, k2, p1, p2, k3.
    pub distortion: [f64; COEFFICIENTS],
    /// Width and height of the pictures, where they are said.
    pub size_px: [Option<f64>; 2],
}

/// Reads a calibration.
///
/// # Errors
/// A file that cannot be read, is larger than [`MOST_BYTES`], is no UTF-8, or says what [`parse`] refuses.
pub fn read(path: &Path) -> Result<OpenCvCalibration, Error> {
    let text = read_text(path, MOST_BYTES, "a calibration", HELP)?;
    parse(&text, &path.display().to_string())
}

/// The calibration of a text, of the file `place`.
///
/// # Errors
/// A text that is neither YAML nor JSON as OpenCV writes them, without a camera matrix, with skew, with focal lengths that are
/// not above 0, with numbers that are not finite, or of a model with other coefficients than k1, k2, p1, p2, k3.
pub fn parse(text: &str, place: &str) -> Result<OpenCvCalibration, Error> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let broken = |rule: String| Error::new(place, rule, HELP);
    let found = match text.trim_start().chars().next() {
        Some('<') => {
            let help = "write it as YAML, by a name that ends with .yml, or as JSON";
            return Err(Error::new(place, "the file is XML, which is not read", help));
        }
        Some('{') => {
            FileStorageValues::of_json(&serde_json::from_str(text).map_err(|error| broken(format!("{error}")))?)
        }
        _ => Entries::of(text)
            .and_then(|entries| FileStorageValues::of_yaml(&entries))
            .map_err(|fault| fault.told(place, HELP))?,
    };
    found.calibration().map_err(broken)
}

/// The matrices and values that are asked for.
#[derive(Debug, Default)]
struct FileStorageValues {
    matrix: Option<Vec<f64>>,
    distortion: Option<Vec<f64>>,
    size_px: [Option<f64>; 2],
    fisheye: bool,
}

impl FileStorageValues {
    fn of_yaml(entries: &Entries<'_>) -> Result<Self, Fault> {
        let values = |keys: &[&str]| -> Result<Option<Vec<f64>>, Fault> {
            let named = |matrix: &&RawMatrix| keys.contains(&matrix.key.as_str());
            let Some(matrix) = entries.matrices.iter().find(named) else { return Ok(None) };
            let size = matrix.size()?;
            if size.rows.saturating_mul(size.channels()) > MOST_VALUES {
                return Err(matrix.fault(format!("`{}` has more than {MOST_VALUES} values", matrix.key)));
            }
            matrix.values(&size).map(Some)
        };
        let number = |key: &str| entries.scalars.get(key).and_then(|word| word.parse().ok());
        Ok(Self {
            matrix: values(&MATRIX_KEYS)?,
            distortion: values(&DISTORTION_KEYS)?,
            size_px: SIZE_KEYS.map(number),
            fisheye: number(FISHEYE_KEY).is_some_and(|word| word != 0.0),
        })
    }

    fn of_json(whole: &Value) -> Self {
        let values = |keys: &[&str]| {
            let matrix = keys.iter().find_map(|key| whole.get(key))?;
            let data = matrix["data"].as_array()?;
            // What is no number leaves a count that no matrix has.
            (data.len() <= MOST_VALUES).then(|| data.iter().map_while(Value::as_f64).collect())
        };
        let number = |key: &str| whole[key].as_f64();
        Self {
            matrix: values(&MATRIX_KEYS),
            distortion: values(&DISTORTION_KEYS),
            size_px: SIZE_KEYS.map(number),
            fisheye: number(FISHEYE_KEY).is_some_and(|word| word != 0.0),
        }
    }

    fn calibration(&self) -> Result<OpenCvCalibration, String> {
        if self.fisheye {
            return Err(format!(
                "`{FISHEYE_KEY}` is set, and a fisheye has other coefficients than k1, k2, p1, p2, k3"
            ));
        }

        // Take the camera matrix apart.
        let Some(matrix) = &self.matrix else {
            return Err("no camera matrix is there: `camera_matrix` or `K`".to_owned());
        };
        let &[fx, skew, cx, a, fy, cy, b, c, one] = &matrix[..] else {
            return Err(format!("the camera matrix has {} values, and must have 3 rows of 3", matrix.len()));
        };
        if [a, b, c] != [0.0; 3] || one != 1.0 || skew != 0.0 {
            return Err(format!(
                "the camera matrix is {matrix:?}, and must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]: skew is not simulated"
            ));
        }
        let (focal_px, centre_px) = (DVec2::new(fx, fy), DVec2::new(cx, cy));
        if !(focal_px.is_finite() && focal_px.cmpgt(DVec2::ZERO).all() && centre_px.is_finite()) {
            return Err(format!("fx, fy, cx, cy are {fx}, {fy}, {cx}, {cy}, and must be finite, fx and fy above 0"));
        }

        // Take the coefficients that are known, and no others.
        let Some(given) = &self.distortion else {
            return Err(
                "no distortion is there: `distortion_coefficients` or `D`, zeros where there is none".to_owned()
            );
        };
        if given.iter().any(|k| !k.is_finite()) {
            return Err(format!("the distortion is {given:?}, and must be finite"));
        }
        if ![4, 5, 8, 12, 14].contains(&given.len()) {
            return Err(format!("the distortion has {} coefficients, and must have 4, 5, 8, 12 or 14", given.len()));
        }
        let (known, others) = given.split_at(given.len().min(COEFFICIENTS));
        if others.iter().any(|k| *k != 0.0) {
            return Err(format!(
                "the distortion is {given:?}, and only k1, k2, p1, p2, k3 may differ from 0: calibrate without \
                 CALIB_RATIONAL_MODEL, CALIB_THIN_PRISM_MODEL and CALIB_TILTED_MODEL"
            ));
        }
        let mut distortion = [0.0; COEFFICIENTS];
        distortion[..known.len()].copy_from_slice(known);
        let principal_px = move_centre(centre_px, PixelCentre::Whole, PixelCentre::Half);
        Ok(OpenCvCalibration { focal_px, principal_px, distortion, size_px: self.size_px })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As OpenCV 4 writes it, and the same of OpenCV 5 with other things beside it.
    const OLD: &str = "%YAML:1.0\n---\nK: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1200.25, 0., 959.5, 0.,\n       \
                       1201.5, 540.125, 0., 0., 1. ]\nD: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ -0.31, 0.12, \
                       1.0000000000000000e-03, -2e-04, -0.02 ]\n";
    const NEW: &str = "%YAML 1.2\n---\ncalibration_time: \"Thu 10:00\"\nimage_width: 1920\nimage_height: 1080\n# flags: +fix\n\
                       camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1200.25, 0., 959.5, 0., 1201.5, \
                       540.125, 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 8\n   dt: d\n   data: [ \
                       -0.31, 0.12, 0.001, -0.0002, -0.02, 0., 0., 0. ]\nfiles:\n   - \"a.png\"\nimage_points: !!opencv-matrix\n   \
                       rows: 2\n   cols: 900\n   dt: \"2f\"\n   data: [ 1. ]\n";
    const JSON: &str = r#"{"camera_matrix": {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d",
        "data": [1200.25, 0.0, 959.5, 0.0, 1201.5, 540.125, 0.0, 0.0, 1.0]}, "image_width": 1920, "image_height": 1080,
        "distortion_coefficients": {"rows": 1, "cols": 5, "dt": "d", "data": [-0.31, 0.12, 0.001, -0.0002, -0.02]}}"#;

    #[test]
    fn what_opencv_writes_is_read() {
        let told = OpenCvCalibration {
            focal_px: DVec2::new(1200.25, 1201.5),
            principal_px: DVec2::new(960.0, 540.625),
            distortion: [-0.31, 0.12, 0.001, -0.0002, -0.02],
            size_px: [Some(1920.0), Some(1080.0)],
        };
        assert_eq!(parse(OLD, "a").unwrap(), OpenCvCalibration { size_px: [None; 2], ..told });
        assert_eq!([NEW, JSON].map(|text| parse(text, "a").unwrap()), [told; 2]);
        let four = NEW.replace("cols: 8", "cols: 4").replace(", -0.02, 0., 0., 0. ]", " ]");
        assert_eq!(parse(&four, "a").unwrap().distortion, [-0.31, 0.12, 0.001, -0.0002, 0.0]);
    }

    #[test]
    fn what_is_no_calibration_is_told() {
        let json = |from: &str, to: &str| JSON.replacen(from, to, 1);
        let new = |from: &str, to: &str| NEW.replacen(from, to, 1);
        let cases = [
            (String::new(), "the first line is \"\""),
            ("<?xml version=\"1.0\"?>".to_owned(), "is XML"),
            ("{".to_owned(), "EOF"),
            ("{}".to_owned(), "no camera matrix is there"),
            (new("camera_matrix", "kamera"), "no camera matrix is there"),
            (new("distortion_coefficients", "kappa"), "no distortion is there"),
            (new("1200.25, 0.,", "1200.25, 0.5,"), "skew is not simulated"),
            (new("1200.25", "-1200.25"), "fx and fy above 0"),
            (new("1200.25", "1e999"), "must be finite"),
            (new("1200.25", ".Nan"), "must hold numbers"),
            (new("rows: 3", "rows: 2"), "holds 9 numbers"),
            (new("rows: 3", "rows: 99999999999"), "more than 64 values"),
            (new("-0.31", "inf"), "the distortion is [inf"),
            (new("cols: 8", "cols: 7").replace("-0.02, ", ""), "has 7 coefficients"),
            (new("-0.02, 0.", "-0.02, 0.1"), "only k1, k2, p1, p2, k3"),
            (new("# flags", "fisheye_model: 1\n# flags"), "a fisheye has other coefficients"),
            (json("959.5", "\"959.5\""), "the camera matrix has 2 values"),
            (json("-0.31, ", ""), ""),
        ];
        for (text, rule) in cases {
            match parse(&text, "a") {
                Err(problem) => {
                    assert!(problem.rule.contains(rule) && !problem.help.is_empty(), "{}: {rule}", problem.rule)
                }
                // Four coefficients are a model of their own.
                Ok(found) => assert!(rule.is_empty() && found.distortion[4] == 0.0, "{rule}"),
            }
        }
        for text in [OLD, NEW, JSON] {
            for end in 0..text.find("files").unwrap_or(text.trim_end().len()) {
                let cut = &text[..end];
                assert!(parse(cut, "a").is_err() || cut.trim_end().ends_with(']'), "{cut:?}");
            }
        }
    }
}
