//! A band: the part of a picture that one thread renders at a time.

use super::film::Class;
use super::region::Region;
use std::ops::Range;

/// The part of a picture that one thread renders at a time, mostly whole rows, written where it stays.
pub(super) struct Band<'a> {
    /// Columns of the band.
    pub(super) width: usize,
    /// The picture's column that is the band's first.
    pub(super) first_column: usize,
    /// The picture's row that is the band's first.
    pub(super) first_row: usize,
    pub(super) radiance: &'a mut [f32],
    pub(super) truth: Option<Truth<'a>>,
}

/// Ground truth of a band.
pub(super) struct Truth<'a> {
    pub(super) class: &'a mut [Class],
    pub(super) board_mm: &'a mut [[f32; 2]],
    /// Numbers of objects, where there are some.
    pub(super) object: Option<&'a mut [u32]>,
}

impl Band<'_> {
    pub(super) fn rows(&self) -> usize {
        self.radiance.len() / self.width
    }

    /// The part of `region` in the band.
    pub(super) fn part_of(&self, region: &Region) -> Region {
        let within = |range: &Range<usize>, first: usize, count: usize| {
            let start = range.start.max(first);
            start..range.end.min(first + count).max(start)
        };
        let columns = within(&region.columns, self.first_column, self.width);
        Region { columns, rows: within(&region.rows, self.first_row, self.rows()) }
    }

    /// Where the picture's column `x` in row `y` is kept.
    pub(super) fn at(&self, x: usize, y: usize) -> usize {
        (y - self.first_row) * self.width + x - self.first_column
    }

    /// Copies the right half of a band of whole rows over its left half, mirrored.
    pub(super) fn mirror(&mut self) {
        let half = self.width / 2;
        for row in self.radiance.chunks_exact_mut(self.width) {
            let (left, right) = row.split_at_mut(half);
            left.iter_mut().rev().zip(right).for_each(|(l, r)| *l = *r);
        }
        if let Some(truth) = &mut self.truth {
            for row in truth.class.chunks_exact_mut(self.width) {
                let (left, right) = row.split_at_mut(half);
                left.iter_mut().rev().zip(right).for_each(|(l, r)| *l = r.mirrored());
            }
            for row in truth.board_mm.chunks_exact_mut(self.width) {
                let (left, right) = row.split_at_mut(half);
                left.iter_mut().rev().zip(right).for_each(|(l, r)| *l = [-r[0], r[1]]);
            }
        }
    }
}
