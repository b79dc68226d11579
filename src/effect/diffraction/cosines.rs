//! Cosine transforms of pictures, which go on beyond their border as their mirror images, by half a pixel.

use rayon::prelude::*;
use rustdct::TransformType2And3;
use rustdct::algorithm::Type2And3ConvertToFft;
use rustdct::rustfft::FftPlannerScalar;
use std::sync::Arc;

/// The transforms of pictures of one size.
pub(super) struct Cosines {
    size: [usize; 2],
    along: [Arc<dyn TransformType2And3<f64>>; 2],
}

impl Cosines {
    /// For pictures of `size` columns and rows.
    pub(super) fn new(size: [usize; 2]) -> Self {
        // Without fused multiply-adds, so that the bits do not depend on the processor.
        let mut planner = FftPlannerScalar::new();
        let along = size.map(|n| Arc::new(Type2And3ConvertToFft::new(planner.plan_fft_forward(n))) as Arc<_>);
        Self { size, along }
    }

    /// `values`, row by row, as a sum of cosines of k/2 and l/2 waves over the picture, each multiplied by `factor(k, l)`.
    pub(super) fn filtered(&self, mut values: Vec<f64>, factor: impl Fn(usize, usize) -> f64 + Sync) -> Vec<f64> {
        let [width, height] = self.size;
        let [along_x, along_y] = &self.along;
        values.par_chunks_mut(width).for_each(|row| along_x.process_dct2(row));
        let mut columns = transposed(&values, self.size);
        // Both ways together multiply by half the number of values.
        let share = 4.0 / (width * height) as f64;
        columns.par_chunks_mut(height).enumerate().for_each(|(k, column)| {
            along_y.process_dct2(column);
            column.iter_mut().enumerate().for_each(|(l, c)| *c *= share * factor(k, l));
            along_y.process_dct3(column);
        });
        self.rows_of(&columns)
    }

    /// The sum over k and l of `factor(k, l)` times the cosines of k/2 and l/2 waves over the picture; those of 0 count half,
    /// a quarter where both are.
    pub(super) fn sum(&self, factor: impl Fn(usize, usize) -> f64 + Sync) -> Vec<f64> {
        let [width, height] = self.size;
        let along_y = &self.along[1];
        let mut columns = vec![0.0; width * height];
        columns.par_chunks_mut(height).enumerate().for_each(|(k, column)| {
            column.iter_mut().enumerate().for_each(|(l, c)| *c = factor(k, l));
            along_y.process_dct3(column);
        });
        self.rows_of(&columns)
    }

    /// The picture, row by row, whose columns are summed up already.
    fn rows_of(&self, columns: &[f64]) -> Vec<f64> {
        let [width, height] = self.size;
        let mut values = transposed(columns, [height, width]);
        values.par_chunks_mut(width).for_each(|row| self.along[0].process_dct3(row));
        values
    }
}

/// A picture of `width` columns with its axes exchanged.
fn transposed(values: &[f64], [width, height]: [usize; 2]) -> Vec<f64> {
    let mut out = vec![0.0; values.len()];
    transpose::transpose(values, &mut out, width, height);
    out
}
