//! A band: the rows of a picture that one thread renders at a time.

use super::film::Class;

/// The rows of a picture that one thread renders at a time, written where they stay.
pub(super) struct Band<'a> {
    /// Columns of the picture.
    pub(super) width: usize,
    /// The picture's row that is the band's first.
    pub(super) first_row: usize,
    pub(super) radiance: &'a mut [f32],
    pub(super) truth: Option<Truth<'a>>,
}

/// Ground truth of a band.
pub(super) struct Truth<'a> {
    pub(super) class: &'a mut [Class],
    pub(super) board_mm: &'a mut [[f32; 2]],
}

impl Band<'_> {
    pub(super) fn rows(&self) -> usize {
        self.radiance.len() / self.width
    }

    /// Copies the right half over the left half, mirrored.
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
