//! The rectified pair of a scene: what was made and what it leaves, as JSON and as a table, and for OpenCV.

use super::cameras::{column, pose};
use super::sheet::{Cell, StudySheet};
use crate::analysis::rectify::{DepthResidual, NOT_SEEN, Rectifier, SourceMap};
use crate::io::exr::Channel;
use crate::io::file_storage::{YamlMap, number};
use crate::metrics::pair_residual::PairResidual;
use crate::metrics::pinhole::{OPENCV_CENTRE_PX, Pinhole};
use crate::metrics::rectified_pair::RectifiedPair;
use crate::scene::Scene;
use serde_json::{Value, json};

/// A map counts as exact where no point is farther off than this, in px: the spacing of f32 at columns beyond 1024, which no file
/// of maps is finer than.
pub(crate) const EXACT_PX: f64 = 1e-4;

/// What was made of a scene.
#[derive(Debug)]
pub struct RectifiedScene<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its pair.
    pub rectifier: &'a Rectifier,
    /// The maps, left and right.
    pub maps: &'a [SourceMap; 2],
    /// What they leave: at the depths that are asked for, and at infinity.
    pub residuals: &'a [DepthResidual],
}

impl RectifiedScene<'_> {
    /// Whether the maps are exact at every depth from the nearest of the residuals on.
    pub(crate) fn is_exact(&self) -> bool {
        let exact = |r: &DepthResidual| r.deviation.as_ref().is_ok_and(|deviation| deviation.max <= EXACT_PX);
        self.residuals.iter().all(exact)
    }

    /// How far the maps are from one shift a row, in px.
    fn off_row_shift_px(&self) -> f64 {
        self.maps.iter().fold(0.0, |most: f64, map| most.max(map.off_row_shift_px))
    }

    /// What is left at each depth.
    fn sheet(&self) -> StudySheet {
        let mut sheet = StudySheet::new(
            "residuals",
            "What the maps leave, by depth from the camera",
            &[
                ("depth_mm", "depth from the camera; none at infinity"),
                ("deviation_rms_px", "both halves from their pinholes, root mean square"),
                ("deviation_max_px", "both halves from their pinholes, largest"),
                ("pairs", "points that both halves see"),
                ("vertical_rms_px", "vertical disparity, root mean square"),
                ("vertical_max_px", "vertical disparity, largest"),
                ("disparity_max_px", "disparity from f b/Z, largest"),
                ("depth_error_rms_mm", "depth of a perfect matcher less the true one, root mean square"),
                ("depth_error_max_mm", "depth of a perfect matcher less the true one, largest"),
                ("depth_error_max_percent", "the same of the depth from the pair's centres"),
            ],
        );
        for DepthResidual { depth_mm, deviation, pairs } in self.residuals {
            let deviation = deviation.as_ref().ok();
            let of = |figure: fn(&PairResidual) -> f64| Cell::from(pairs.as_ref().map(figure));
            sheet.push(vec![
                Cell::from(*depth_mm),
                Cell::from(deviation.map(|d| d.rms)),
                Cell::from(deviation.map(|d| d.max)),
                Cell::from(pairs.map_or(0, |p| p.n)),
                of(|p| p.vertical_rms_px),
                of(|p| p.vertical_max_px),
                of(|p| p.disparity_max_px),
                of(|p| p.depth_error.rms_mm),
                of(|p| p.depth_error.max_mm),
                of(|p| p.depth_error.max_percent),
            ]);
        }
        sheet
    }

    /// As JSON.
    pub fn json(&self) -> Value {
        let (pair, frames) = (self.rectifier.pair(), self.rectifier.frames());
        let half = |k: usize| {
            let (camera, misses) = (&pair.cameras()[k], &self.rectifier.misses()[k]);
            json!({
                "centre_mm": camera.centre_mm().to_array(),
                "principal_px": (camera.principal_px - OPENCV_CENTRE_PX).to_array(),
                "miss_rms_mm": misses.rms_mm,
                "miss_max_mm": misses.max_mm,
                "seen_px": self.maps[k].seen,
            })
        };
        json!({
            "schema": "biprism-rectify/1",
            "scene": self.scene.name,
            "prism": self.scene.prism.kind(),
            "pixel_centre": "(i, j)",
            "not_seen": NOT_SEEN,
            "size_px": frames[0].size_px.to_array().map(|n| n as u64),
            "map_depth_mm": self.rectifier.depth_mm(),
            "centres_ahead_mm": self.rectifier.centres_ahead_mm(),
            "baseline_mm": pair.baseline_mm(),
            "focal_px": pair.focal_px().to_array(),
            "halves": { "left": half(0), "right": half(1) },
            "off_row_shift_px": self.off_row_shift_px(),
            "exact": self.is_exact(),
            "residuals": self.sheet().json()["rows"],
        })
    }

    /// As a table for a person.
    pub fn table(&self) -> String {
        let pair = self.rectifier.pair();
        let nearest_mm = self.residuals.iter().fold(f64::INFINITY, |least, r| least.min(r.depth_mm));
        let mut text = self.sheet().table();
        text += &format!(
            "\nbaseline {:.4} mm, focal lengths {:.3} and {:.3} px; maps right {} mm from the camera\n",
            pair.baseline_mm(),
            pair.focal_px().x,
            pair.focal_px().y,
            self.rectifier.depth_mm()
        );
        text += &if self.is_exact() {
            format!("exact at every depth from {nearest_mm} mm on, to {EXACT_PX:.0e} px\n")
        } else {
            "exact at that depth alone: the rays of a half do not meet in one point\n".to_owned()
        };
        let shift_px = self.off_row_shift_px();
        if shift_px <= EXACT_PX {
            text += &format!("each map is one shift a row, to {shift_px:.1e} px\n");
        }
        text
    }
}

/// The maps as channels of one EXR.
pub fn channels(maps: [SourceMap; 2]) -> Vec<Channel> {
    let named = |(half, map): (&str, SourceMap)| {
        [Channel::f32(format!("{half}.x"), map.x), Channel::f32(format!("{half}.y"), map.y)]
    };
    ["left", "right"].into_iter().zip(maps).flat_map(named).collect()
}

/// `stereo.yml`: the rectified images as `stereoCalibrate` and `stereoRectify` name cameras: `M1` and `M2` without distortion, `R`
/// and `T` from the left to the right one; nothing left to rectify, so that `R1` and `R2` turn nothing, `P1` and `P2`; `Q` from
/// disparity to depth. `R_left`, `T_left`, `R_right`, `T_right` are the cameras in the world.
pub fn stereo_text(rectifier: &Rectifier) -> String {
    let (pair, size) = (rectifier.pair(), rectifier.frames()[0].size_px);
    let mut file = YamlMap::default();
    file.string("pixel_centre", "(i, j)");
    file.string("lengths", "mm");
    file.scalar("image_width", &(size.x as u64).to_string());
    file.scalar("image_height", &(size.y as u64).to_string());
    file.scalar("map_depth_mm", &number(rectifier.depth_mm()));
    for (k, half, camera) in [(1, "left", &pair.cameras()[0]), (2, "right", &pair.cameras()[1])] {
        let place = pose(&camera.camera_from_world);
        matrix(&mut file, &format!("M{k}"), &inner(camera));
        file.doubles(&format!("D{k}"), &[&[0.0; 5]]);
        matrix(&mut file, &format!("R_{half}"), &place.r);
        column(&mut file, &format!("T_{half}"), &place.t_mm);
    }
    matrix(&mut file, "R", &UNTURNED);
    column(&mut file, "T", &[-pair.baseline_mm(), 0.0, 0.0]);
    matrix(&mut file, "R1", &UNTURNED);
    matrix(&mut file, "R2", &UNTURNED);
    let [left, right] = projections(pair);
    matrix(&mut file, "P1", &left);
    matrix(&mut file, "P2", &right);
    matrix(&mut file, "Q", &reprojection(pair));
    file.file()
}

/// The rotation that turns nothing.
const UNTURNED: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The camera matrix, in OpenCV's px.
fn inner(camera: &Pinhole) -> [[f64; 3]; 3] {
    let (f, c) = (camera.focal_px, camera.principal_px - OPENCV_CENTRE_PX);
    [[f.x, 0.0, c.x], [0.0, f.y, c.y], [0.0, 0.0, 1.0]]
}

/// P1 and P2: from points in the left camera's frame, in mm, to both images.
fn projections(pair: &RectifiedPair) -> [[[f64; 4]; 3]; 2] {
    [(0, 0.0), (1, -pair.focal_px().x * pair.baseline_mm())].map(|(k, shift)| {
        let [x, y, z] = inner(&pair.cameras()[k]);
        [[x[0], x[1], x[2], shift], [y[0], y[1], y[2], 0.0], [z[0], z[1], z[2], 0.0]]
    })
}

/// Q: from (x_L, y, x_L - x_R, 1) to the point in the left camera's frame, but for a factor.
fn reprojection(pair: &RectifiedPair) -> [[f64; 4]; 4] {
    let (centre, baseline_mm) = (pair.cameras()[0].principal_px - OPENCV_CENTRE_PX, pair.baseline_mm());
    // OpenCV's own has square pixels, and 1 here.
    let aspect = pair.focal_px().x / pair.focal_px().y;
    [
        [1.0, 0.0, 0.0, -centre.x],
        [0.0, aspect, 0.0, -aspect * centre.y],
        [0.0, 0.0, 0.0, pair.focal_px().x],
        [0.0, 0.0, baseline_mm.recip(), -pair.offset_px() / baseline_mm],
    ]
}

fn matrix<const N: usize>(map: &mut YamlMap, key: &str, rows: &[[f64; N]]) {
    map.doubles(key, &rows.iter().map(<[f64; N]>::as_slice).collect::<Vec<_>>());
}
