//! What is true of a stereo pair, as channels of an EXR and as records of an NPY.

use crate::analysis::stereo_truth::{StereoPoint, StereoTruth};
use crate::io::exr::Channel;
use crate::io::npy::NpyField;
use crate::optics::fate::Fate;
use crate::raster::Raster;
use crate::render::Class;
use crate::system::Side;
use crate::vision::half::{Half, columns_of};
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;

/// The fields of a record: those of the table without stereo, then those of the channels of [`channels`].
pub(super) const FIELDS: [NpyField; 7] = [
    NpyField::F64("board_mm", 2),
    NpyField::U32("class"),
    NpyField::F64("Z_mm", 1),
    NpyField::F64("distance_mm", 1),
    NpyField::F64("other_px", 2),
    NpyField::F64("disparity_px", 2),
    NpyField::U32("seen_by"),
];

/// A part of a picture, and what is true in it.
pub(super) struct StereoPart {
    columns: usize,
    /// The pixels row by row.
    points: Vec<Result<StereoPoint, Fate>>,
    /// The first column of the half that sees the other side of each, where a half is a picture of its own.
    other_column: f64,
    has_objects: bool,
}

impl StereoPart {
    /// Some rows of a picture of `width` columns, or of one half of it.
    pub(super) fn new(truth: &StereoTruth<'_>, width: usize, half: Option<Half>, rows: Range<usize>) -> Self {
        let columns = half.map_or(0..width, |half| columns_of(width, half));
        let points: Vec<Vec<_>> = rows.into_par_iter().map(|j| truth.row(j, columns.clone())).collect();
        // Seen from the left half the other one is the right one.
        let other_column = if half == Some(Half::Left) { columns_of(width, Half::Right).start as f64 } else { 0.0 };
        Self { columns: columns.len(), points: points.concat(), other_column, has_objects: truth.has_objects() }
    }

    fn other_px(&self, point: &StereoPoint) -> DVec2 {
        point.other_px.map_or(DVec2::NAN, |px| px - DVec2::new(self.other_column, 0.0))
    }

    /// The channels, of the EXR's table.
    pub(super) fn channels(&self) -> Vec<Channel> {
        let plane = |name: &str, value: &dyn Fn(&StereoPoint) -> f64| {
            let data = self.points.iter().map(|point| point.as_ref().map_or(f32::NAN, |point| value(point) as f32));
            Channel::f32(name, Raster::from_data(self.columns, self.rows(), data.collect()))
        };
        let seen_by = self.points.iter().map(seen_by).collect();
        vec![
            plane("Z", &|point| point.z_mm),
            plane("distance", &|point| point.distance_mm),
            plane("other.X", &|point| self.other_px(point).x),
            plane("other.Y", &|point| self.other_px(point).y),
            plane("disparity.X", &|point| point.disparity_px.map_or(f64::NAN, |px| px.x)),
            plane("disparity.Y", &|point| point.disparity_px.map_or(f64::NAN, |px| px.y)),
            Channel::u32("seen_by", Raster::from_data(self.columns, self.rows(), seen_by)),
        ]
    }

    fn rows(&self) -> usize {
        self.points.len() / self.columns.max(1)
    }

    /// The records, of [`FIELDS`].
    pub(super) fn records(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.points.len() * FIELDS.iter().map(|field| field.bytes()).sum::<usize>());
        for point in &self.points {
            let (mm, class) = match point {
                Ok(point) => (point.hit.board_mm, Class::from(point.hit.side)),
                Err(fate) => (DVec2::NAN, Class::from(*fate)),
            };
            let (z_mm, distance_mm, other, disparity) = match point {
                Ok(point) => {
                    let disparity = point.disparity_px.unwrap_or(DVec2::NAN);
                    (point.z_mm, point.distance_mm, self.other_px(point), disparity)
                }
                Err(_) => (f64::NAN, f64::NAN, DVec2::NAN, DVec2::NAN),
            };
            let mut add = |value: f64| bytes.extend(value.to_le_bytes());
            add(mm.x);
            add(mm.y);
            bytes.extend((class as u32).to_le_bytes());
            let mut add = |value: f64| bytes.extend(value.to_le_bytes());
            [z_mm, distance_mm, other.x, other.y, disparity.x, disparity.y].into_iter().for_each(&mut add);
            bytes.extend(seen_by(point).to_le_bytes());
            if self.has_objects {
                bytes.extend(point.as_ref().map_or(0, |point| point.object as u32).to_le_bytes());
            }
        }
        bytes
    }
}

/// Which halves see what a pixel sees: 0 none, 1 the left one alone, 2 the right one alone, 3 both.
fn seen_by(point: &Result<StereoPoint, Fate>) -> u32 {
    match point {
        Err(_) => 0,
        Ok(StereoPoint { other_px: Some(_), .. }) => 3,
        Ok(StereoPoint { hit, .. }) => {
            if hit.side == Side::Left {
                1
            } else {
                2
            }
        }
    }
}
