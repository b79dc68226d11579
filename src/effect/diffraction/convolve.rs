//! A picture convolved with a kernel.

use super::Kernel;
use crate::num::simd::{self, widest};
use crate::raster::Raster;
use rayon::prelude::*;

/// Rows that one thread makes at a time.
const BAND_ROWS: usize = 64;
/// Pixels whose sums are kept in registers at a time.
const BLOCK: usize = 32;

/// The picture after diffraction. `fine` holds [`Kernel::samples`] samples a pixel along each side; the result has one
/// value a pixel.
///
/// Beyond its border the picture goes on as its mirror image, by half a sample: so no light is lost there, and none is
/// made. The bits are the same for any number of threads, and a mirrored picture has the mirrored bits.
///
/// # Panics
/// When a side of `fine` is not a multiple of the samples.
pub fn blur(fine: &Raster<f32>, kernel: &Kernel) -> Raster<f32> {
    let n = kernel.samples;
    assert!(fine.width().is_multiple_of(n) && fine.height().is_multiple_of(n), "{n} samples a pixel");
    let (width, height) = (fine.width() / n, fine.height() / n);
    let mut out = Raster::filled(width, height, 0.0);
    let stride = width.next_multiple_of(BLOCK) + 2 * kernel.radius;
    out.data_mut().par_chunks_mut(width * BAND_ROWS).enumerate().for_each(|(k, band)| {
        let rows = band.len() / width;
        let planes = Planes::of(fine, kernel, k * BAND_ROWS, rows, stride);
        let taps = planes.taps(kernel);
        for (j, row) in band.chunks_exact_mut(width).enumerate() {
            widest(Row { taps: &taps, planes: &planes.values, first: j * stride, out: row });
        }
    });
    out
}

/// The samples of a band and of the rows and columns around it that the kernel reaches: one plane for each place within a
/// pixel, and one of the pixels' means.
struct Planes {
    values: Vec<f32>,
    stride: usize,
    /// Values of a plane.
    size: usize,
}

impl Planes {
    fn of(fine: &Raster<f32>, kernel: &Kernel, first_row: usize, rows: usize, stride: usize) -> Self {
        let (n, reach) = (kernel.samples, kernel.radius);
        let size = (rows + 2 * reach) * stride;
        let planes = if kernel.core < reach { n * n + 1 } else { n * n };
        let mut values = vec![0.0; planes * size];
        let columns = fine.width() / n + 2 * reach;
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
            if planes > n * n {
                for at in j * stride..j * stride + columns {
                    let sample = |k: usize| f64::from(values[k * size + at]);
                    // Mirror images are summed in pairs.
                    let sum: f64 = (0..n * n).map(|k| sample(k) + sample(k / n * n + n - 1 - k % n)).sum();
                    values[n * n * size + at] = (0.5 * sum / (n * n) as f64) as f32;
                }
            }
        }
        Self { values, stride, size }
    }

    fn taps(&self, kernel: &Kernel) -> Vec<Tap> {
        let (n, core, reach) = (kernel.samples, kernel.core, kernel.radius);
        let sample = |u: usize, v: usize| {
            let (i, j) = (u / n + reach - core, v / n + reach - core);
            ((v % n) * n + u % n) * self.size + j * self.stride + i
        };
        let pixel = |u: usize, v: usize| n * n * self.size + v * self.stride + u;
        let mut taps = orbits(&kernel.fine, (2 * core + 1) * n, sample);
        if core < reach {
            taps.extend(orbits(&kernel.far, 2 * reach + 1, pixel));
        }
        // Plane by plane, so that what is read next is near.
        taps.sort_by_key(|tap| tap.at[0]);
        taps
    }
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

/// A row of the result.
struct Row<'a> {
    taps: &'a [Tap],
    planes: &'a [f32],
    /// Where the first pixel of the row has its tap of offset 0.
    first: usize,
    out: &'a mut [f32],
}

impl simd::Kernel for Row<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { taps, planes, first, out } = self;
        for (k, out) in out.chunks_mut(BLOCK).enumerate() {
            let place = first + k * BLOCK;
            let mut sums = [0.0; BLOCK];
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
