//! The maps: where in the picture stands what a pixel of a rectified image sees.

use super::rectifier::Rectifier;
use super::residual::seen_px;
use crate::metrics::pinhole::OPENCV_CENTRE_PX;
use crate::progress::Observer;
use crate::raster::Raster;
use crate::system::aim::Aimer;
use glam::DVec2;
use rayon::prelude::*;

/// Stands in both maps for a pixel that the half does not see: `cv2.remap` then takes its border's value.
pub const NOT_SEEN: f32 = -1.0;

/// The maps of one half, as `cv2.remap` takes them.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceMap {
    /// Columns of the picture, in px, pixel centres at whole numbers.
    pub x: Raster<f32>,
    /// Rows of the picture, alike.
    pub y: Raster<f32>,
    /// Pixels that the half sees.
    pub seen: usize,
    /// How far the map is from one shift a row: the largest of half the range of the shifts along x within a row, and of the
    /// shifts along y, in px; before it was rounded to f32.
    pub off_row_shift_px: f64,
}

/// Exact positions of the picture by those of the rectified images.
#[derive(Debug)]
pub struct Sources<'a> {
    rectifier: &'a Rectifier,
    aimer: Aimer<'a>,
}

impl<'a> Sources<'a> {
    /// Traces what the search starts from.
    pub fn new(rectifier: &'a Rectifier) -> Self {
        Self { rectifier, aimer: Aimer::new(&rectifier.at_plane) }
    }

    /// The position in the whole picture, in px, that sees what `image_px` of the rectified image `k` (0 left, 1 right) sees in the
    /// plane; `None` where the half does not see it.
    pub fn at(&self, k: usize, image_px: DVec2) -> Option<DVec2> {
        let Rectifier { pair, frames, at_plane, depth_mm, .. } = self.rectifier;
        let camera = &pair.cameras()[k];
        let point = camera.at_depth(image_px, depth_mm - self.rectifier.centres_ahead_mm());
        let board_mm = at_plane.board().local(camera.camera_from_world.inverse().point(point)).truncate();
        seen_px(&frames[k], &self.aimer, board_mm)
    }

    /// The maps of half `k`, of the size of a half; `observer` hears of the pixels.
    pub fn map(&self, k: usize, observer: &dyn Observer) -> SourceMap {
        let size = self.rectifier.frames[k].size_px;
        let (width, height) = (size.x as usize, size.y as usize);
        let rows: Vec<MapRow> = (0..height)
            .into_par_iter()
            .map(|j| {
                observer.pixels(width);
                self.row(k, j, width)
            })
            .collect();
        let plane = |axis: usize| {
            Raster::from_data(width, height, rows.iter().flat_map(|row| row.values[axis].iter().copied()).collect())
        };
        SourceMap {
            x: plane(0),
            y: plane(1),
            seen: rows.iter().map(|row| row.seen).sum(),
            off_row_shift_px: rows.iter().fold(0.0, |most: f64, row| most.max(row.from_shift_px)),
        }
    }

    fn row(&self, k: usize, j: usize, width: usize) -> MapRow {
        let mut row = MapRow { values: [vec![NOT_SEEN; width], vec![NOT_SEEN; width]], seen: 0, from_shift_px: 0.0 };
        let (mut low, mut high, mut across) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
        for i in 0..width {
            let image_px = DVec2::new(i as f64, j as f64) + OPENCV_CENTRE_PX;
            let Some(full_px) = self.at(k, image_px) else { continue };
            let source = full_px - OPENCV_CENTRE_PX;
            (row.values[0][i], row.values[1][i]) = (source.x as f32, source.y as f32);
            row.seen += 1;
            let shift = full_px - image_px;
            (low, high, across) = (low.min(shift.x), high.max(shift.x), across.max(shift.y.abs()));
        }
        if row.seen > 0 {
            row.from_shift_px = across.max(0.5 * (high - low));
        }
        row
    }
}

/// A row of both maps.
struct MapRow {
    values: [Vec<f32>; 2],
    seen: usize,
    from_shift_px: f64,
}
