//! The truth of a picture as a table: what the centre of every pixel sees, at full f64, traced for the table alone.

use crate::io::npy::NpyField;
use crate::render::Class;
use crate::system::InLight;
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;

/// The fields of a record: the position on the board in mm, in the board's frame, and the class. Both positions are NaN where
/// the class is no side, as in the EXR; the class tells which these are.
pub(super) const FIELDS: [NpyField; 2] = [NpyField::F64("board_mm", 2), NpyField::U32("class")];

/// The records of some rows and `columns` of a picture, as `biprism trace` has them at pixel centres.
pub(super) fn records(light: &InLight<'_>, columns: Range<usize>, rows: Range<usize>) -> Vec<u8> {
    let row = |j: usize| {
        let mut bytes = Vec::with_capacity(columns.len() * FIELDS.iter().map(|field| field.bytes()).sum::<usize>());
        for i in columns.clone() {
            let (board_mm, class) = match light.trace(DVec2::new(i as f64 + 0.5, j as f64 + 0.5)) {
                Ok(hit) => (hit.board_mm, Class::from(hit.side)),
                Err(fate) => (DVec2::NAN, Class::from(fate)),
            };
            bytes.extend(board_mm.x.to_le_bytes());
            bytes.extend(board_mm.y.to_le_bytes());
            bytes.extend((class as u32).to_le_bytes());
        }
        bytes
    };
    let rows: Vec<Vec<u8>> = rows.into_par_iter().map(row).collect();
    rows.concat()
}
