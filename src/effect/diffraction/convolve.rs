//! A picture convolved with a kernel.

use super::kernel::{Far, PointSpread};
use crate::num::simd::{self, widest};
use crate::raster::Raster;
use rayon::prelude::*;

/// Rows that one thread makes at a time.
const BAND_ROWS: usize = 64;
/// Pixels whose sums are kept in registers at a time.
const BLOCK: usize = 32;

/// The picture after diffraction. `fine` holds [`PointSpread::samples`] samples a pixel along each side; the result has one
/// value a pixel.
///
/// Beyond its border the picture goes on as its mirror image, by half a sample: so no light is lost there, and none is
/// made (to 1e-4: far light is interpolated between blocks of pixels). The bits are the same for any number of threads, and a mirrored picture has the mirrored bits.
///
/// # Panics
/// When a side of `fine` is not a multiple of the samples.
pub fn blur(fine: &Raster<f32>, kernel: &PointSpread) -> Raster<f32> {
    let n = kernel.samples;
    assert!(fine.width().is_multiple_of(n) && fine.height().is_multiple_of(n), "{n} samples a pixel");
    let (width, height) = (fine.width() / n, fine.height() / n);
    let far = PaddedField::of(fine, n, &kernel.far);
    let mut out = Raster::filled(width, height, 0.0);
    out.data_mut().par_chunks_mut(width * BAND_ROWS).enumerate().for_each(|(k, band)| {
        let planes = Planes::near(fine, kernel, k * BAND_ROWS, band.len() / width);
        let taps = planes.taps(kernel);
        for (j, row) in band.chunks_exact_mut(width).enumerate() {
            far.interpolate(k * BAND_ROWS + j, row);
            widest(RowConvolution { taps: &taps, planes: &planes.values, first: j * planes.stride, out: row });
        }
    });
    out
}

/// The samples of a band and of the rows and columns around it that the core reaches: one plane for each place within a
/// pixel.
struct Planes {
    values: Vec<f32>,
    stride: usize,
    /// Values of a plane.
    size: usize,
}

impl Planes {
    fn near(fine: &Raster<f32>, kernel: &PointSpread, first_row: usize, rows: usize) -> Self {
        let (n, reach) = (kernel.samples, kernel.core);
        let width = fine.width() / n;
        let stride = stride(width, reach);
        let size = (rows + 2 * reach) * stride;
        let mut values = vec![0.0; n * n * size];
        let columns = width + 2 * reach;
        let places = |side: usize, first: usize, count: usize| -> Vec<usize> {
            let start = (first * n) as isize - (reach * n) as isize;
            (0..(count * n) as isize).map(|k| mirrored(start + k, side)).collect()
        };
        let (x, y) = (places(fine.width(), 0, columns), places(fine.height(), first_row, rows + 2 * reach));
        for (j, y) in y.chunks_exact(n).enumerate() {
            for (k, &y) in y.iter().flat_map(|y| std::iter::repeat_n(y, n)).enumerate() {
                let row = fine.row(y);
                let line = &mut values[k * size + j * stride..][..columns];
                line.iter_mut().zip(x[k % n..].iter().step_by(n)).for_each(|(v, x)| *v = row[*x]);
            }
        }
        Self { values, stride, size }
    }

    fn taps(&self, kernel: &PointSpread) -> Vec<Tap> {
        let n = kernel.samples;
        orbits(&kernel.near, (2 * kernel.core + 1) * n, |u, v| {
            ((v % n) * n + u % n) * self.size + v / n * self.stride + u / n
        })
    }
}

/// Values of a row with room for `reach` more on both sides and for the last block.
fn stride(width: usize, reach: usize) -> usize {
    width.next_multiple_of(BLOCK) + 2 * reach
}

/// The far light at the middles of blocks, which lie symmetric about the middle of the picture and cover it with half a
/// block to spare.
struct PaddedField {
    values: Vec<f32>,
    /// Blocks along each axis.
    count: [usize; 2],
    /// Pixels from the middle of the first block to the first pixel.
    before: [usize; 2],
    block: usize,
}

impl PaddedField {
    fn of(fine: &Raster<f32>, n: usize, far: &Far) -> Self {
        let (block, reach) = (far.block, far.reach);
        let size = [fine.width() / n, fine.height() / n];
        // As many blocks as leave an even number of pixels over; the block is odd, so that is their parity.
        let count = size.map(|side| {
            let least = (side + block).div_ceil(block);
            least + usize::from(least % 2 != side % 2)
        });
        let over = [0, 1].map(|axis| (count[axis] * block - size[axis]) / 2);
        // Means of rows of samples over the blocks' columns first, then of these down the blocks.
        let places = |axis: usize, side: usize| -> Vec<usize> {
            let start = -((reach * block + over[axis]) as isize) * n as isize;
            let length = (count[axis] + 2 * reach) * block * n;
            (0..length as isize).map(|k| mirrored(start + k, side)).collect()
        };
        let (x, y) = (places(0, fine.width()), places(1, fine.height()));
        let columns = count[0] + 2 * reach;
        let across = |j: usize| -> Vec<f64> {
            let row = fine.row(j);
            let value = |x: &[usize]| symmetric_sum(x.len(), |k| f64::from(row[x[k]]));
            x.chunks_exact(block * n).map(value).collect()
        };
        let rows: Vec<Vec<f64>> = (0..fine.height()).into_par_iter().map(across).collect();
        let stride = stride(count[0], reach);
        let samples = (block * n * block * n) as f64;
        let mut means = vec![0.0f32; (count[1] + 2 * reach) * stride];
        for (line, y) in means.chunks_exact_mut(stride).zip(y.chunks_exact(block * n)) {
            for (i, mean) in line[..columns].iter_mut().enumerate() {
                *mean = (symmetric_sum(y.len(), |k| rows[y[k]][i]) / samples) as f32;
            }
        }
        let taps = orbits(&far.weights, 2 * reach + 1, |u, v| v * stride + u);
        let mut values = vec![0.0; count[0] * count[1]];
        values.par_chunks_mut(count[0]).enumerate().for_each(|(j, out)| {
            widest(RowConvolution { taps: &taps, planes: &means, first: j * stride, out });
        });
        // The middle of the first block is its pixel (block - 1) / 2, before the first of the picture or on it.
        let before = over.map(|over| over - (block - 1) / 2);
        Self { values, count, before, block }
    }

    /// Writes the far light of a row of the picture, linear between the middles of blocks.
    fn interpolate(&self, row: usize, out: &mut [f32]) {
        let block = self.block;
        let mixed = |a: f64, b: f64, k: usize| (a * (block - k) as f64 + b * k as f64) / block as f64;
        let (j, down) = ((row + self.before[1]) / block, (row + self.before[1]) % block);
        let line = |j: usize| &self.values[j.min(self.count[1] - 1) * self.count[0]..][..self.count[0]];
        let (above, below) = (line(j), line(j + 1));
        let at = |i: usize| {
            let i = i.min(self.count[0] - 1);
            mixed(f64::from(above[i]), f64::from(below[i]), down)
        };
        for (i, out) in out.iter_mut().enumerate() {
            let place = i + self.before[0];
            *out = mixed(at(place / block), at(place / block + 1), place % block) as f32;
        }
    }
}

/// The sum of n values that does not change a bit when their order is turned round.
fn symmetric_sum(n: usize, value: impl Fn(usize) -> f64) -> f64 {
    0.5 * (0..n).map(|k| value(k) + value(n - 1 - k)).sum::<f64>()
}

/// A weight and the four places, mirror images of each other, that have it.
struct Tap {
    weight: f64,
    at: [usize; 4],
}

/// The taps of a square of weights; those on an axis of symmetry are named twice, or four times, and weigh less.
fn orbits(weights: &[f64], side: usize, at: impl Fn(usize, usize) -> usize) -> Vec<Tap> {
    let mut taps = Vec::new();
    for v in 0..side.div_ceil(2) {
        for u in 0..side.div_ceil(2) {
            let (over, down) = (side - 1 - u, side - 1 - v);
            let named = if u == over { 0.5 } else { 1.0 } * if v == down { 0.5 } else { 1.0 };
            let weight = named * weights[v * side + u];
            if weight != 0.0 {
                taps.push(Tap { weight, at: [at(u, v), at(over, v), at(u, down), at(over, down)] });
            }
        }
    }
    taps
}

/// The place in 0..side that stands for place `k` of a row that goes on as its mirror image.
fn mirrored(k: isize, side: usize) -> usize {
    let place = k.rem_euclid(2 * side as isize) as usize;
    if place < side { place } else { 2 * side - 1 - place }
}

/// A row of the result, added to what `out` holds.
struct RowConvolution<'a> {
    taps: &'a [Tap],
    planes: &'a [f32],
    /// Where the first pixel of the row has its tap of offset 0.
    first: usize,
    out: &'a mut [f32],
}

impl simd::Kernel for RowConvolution<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { taps, planes, first, out } = self;
        for (k, out) in out.chunks_mut(BLOCK).enumerate() {
            let place = first + k * BLOCK;
            let mut sums = [0.0; BLOCK];
            out.iter().zip(&mut sums).for_each(|(out, sum)| *sum = f64::from(*out));
            for Tap { weight, at } in taps {
                let values = |at: usize| &planes[place + at..place + at + BLOCK];
                let (a, b, c, d) = (values(at[0]), values(at[1]), values(at[2]), values(at[3]));
                for i in 0..BLOCK {
                    sums[i] += weight * f64::from((a[i] + b[i]) + (c[i] + d[i]));
                }
            }
            out.iter_mut().zip(sums).for_each(|(out, sum)| *out = sum as f32);
        }
    }
}
