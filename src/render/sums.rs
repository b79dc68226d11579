//! Weighted sums of pictures, band by band.

use super::plan::BAND_ROWS;
use crate::effect::Variant;
use crate::num::simd::{Kernel, widest};
use crate::raster::Raster;

/// Weighted sums over a band of rows.
pub(super) struct Sums<'a> {
    pub(super) first_row: usize,
    pub(super) width: usize,
    pub(super) grey: &'a mut [f64],
    colour: Option<&'a mut [[f64; 3]]>,
}

impl<'a> Sums<'a> {
    /// The bands of a picture.
    pub(super) fn bands(grey: &'a mut Raster<f64>, colour: &'a mut Option<Raster<[f64; 3]>>) -> Vec<Self> {
        let width = grey.width();
        let size = width * BAND_ROWS;
        let mut colours = colour.iter_mut().flat_map(|colour| colour.data_mut().chunks_mut(size));
        let bands = grey.data_mut().chunks_mut(size).enumerate();
        bands.map(|(k, grey)| Self { first_row: k * BAND_ROWS, width, grey, colour: colours.next() }).collect()
    }

    /// Adds the radiances of a variant by its weights, in the columns from `first` on.
    pub(super) fn add(&mut self, variant: &Variant, values: &[f32], first: usize) {
        let values = || values.chunks(self.width).map(|row| &row[first..]);
        for (sums, values) in self.grey.chunks_mut(self.width).zip(values()) {
            widest(WeightedRow { sums: &mut sums[first..], values, weight: variant.grey });
        }
        if let (Some(colour), Some(shares)) = (&mut self.colour, variant.colour) {
            for (sums, values) in colour.chunks_mut(self.width).zip(values()) {
                sums[first..].iter_mut().zip(values).for_each(|(sums, value)| {
                    sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share * f64::from(*value));
                });
            }
        }
    }

    /// Makes the left half the mirror image of the right one.
    pub(super) fn mirror(&mut self) {
        mirror_rows(self.grey, self.width);
        if let Some(colour) = &mut self.colour {
            mirror_rows(colour, self.width);
        }
    }
}

/// A kernel that adds the values of a row by their weight.
struct WeightedRow<'a> {
    sums: &'a mut [f64],
    values: &'a [f32],
    weight: f64,
}

impl Kernel for WeightedRow<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        self.sums.iter_mut().zip(self.values).for_each(|(sum, value)| *sum += self.weight * f64::from(*value));
    }
}

/// Makes the left half of each row the mirror image of its right one.
fn mirror_rows<T: Copy>(rows: &mut [T], width: usize) {
    for row in rows.chunks_mut(width) {
        let (left, right) = row.split_at_mut(width / 2);
        left.iter_mut().zip(right.iter().rev()).for_each(|(to, from)| *to = *from);
    }
}
