//! The truth of a picture as a table: what the centre of every pixel sees, at full f64, traced for the table alone.

use crate::analysis::stereo_truth::StereoTruth;
use crate::io::npy::NpyField;
use crate::render::Class;
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;

/// The fields of a record: the position on the board in mm, in the board's frame, and the class. Both positions are NaN where
/// the class is no side, as in the EXR; the class tells which these are.
pub(super) const FIELDS: [NpyField; 2] = [NpyField::F64("board_mm", 2), NpyField::U32("class")];

/// The last field of a record where the scene has objects besides the board: the number of what is seen.
pub(super) const OBJECT: NpyField = NpyField::U32("object");

/// The records of some rows and `columns` of a picture, as `biprism trace` has them at pixel centres.
pub(super) fn records(truth: &StereoTruth<'_>, columns: Range<usize>, rows: Range<usize>) -> Vec<u8> {
    let row = |j: usize| {
        let mut bytes = Vec::with_capacity(columns.len() * FIELDS.iter().map(|field| field.bytes()).sum::<usize>());
        for i in columns.clone() {
            let seen = truth.seen(DVec2::new(i as f64 + 0.5, j as f64 + 0.5));
            let (object, board_mm, class) = match seen {
                Ok((object, hit)) => (object, hit.board_mm, Class::from(hit.side)),
                Err(fate) => (0, DVec2::NAN, Class::from(fate)),
            };
            bytes.extend(board_mm.x.to_le_bytes());
            bytes.extend(board_mm.y.to_le_bytes());
            bytes.extend((class as u32).to_le_bytes());
            if truth.has_objects() {
                bytes.extend((object as u32).to_le_bytes());
            }
        }
        bytes
    };
    let rows: Vec<Vec<u8>> = rows.into_par_iter().map(row).collect();
    rows.concat()
}
