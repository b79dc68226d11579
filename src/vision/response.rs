//! The saddle response: its local maxima on the smoothed picture are where two edges may cross.
//!
//! The response is S = Ixy^2 - Ixx Iyy - (Ixx + Iyy)^2 / 8 on a Gaussian of 1.5 px: minus the determinant of the
//! Hessian, less a share of its trace, which vanishes at the crossing of two edges and not at blobs and ends of lines.

use crate::num::simd::{Kernel, widest};
use crate::raster::Raster;
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;

/// Half width of the smoothing kernel, in px.
const TAPS: usize = 5;
/// Standard deviation of the smoothing kernel, in px.
const SIGMA_PX: f64 = 1.5;
/// A maximum is the largest of the (2 REACH + 1)^2 values around it.
const REACH: usize = 3;
/// Rows that one thread works on; its neighbours work on some of them again.
const BAND: usize = 128;
/// Below this the response of a picture scaled to 0..1 is rounding.
const FLOOR: f32 = 1e-12;

/// A local maximum of the saddle response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Peak {
    /// The stationary point of the smoothed picture nearest to the maximum, in px.
    pub(super) position: DVec2,
    /// The response.
    pub(super) strength: f32,
}

/// The maxima of the saddle response, strongest first. The picture must be finite and about 0..1.
pub(super) fn peaks(image: &Raster<f32>) -> Vec<Peak> {
    let (width, height) = (image.width(), image.height());
    if width < 2 * REACH + 1 || height < 2 * REACH + 1 {
        return Vec::new();
    }
    let kernel = half_kernel();
    let starts: Vec<usize> = (0..height).step_by(BAND).collect();
    let band = |first: usize| BandPeaks { image, kernel: &kernel, rows: first..(first + BAND).min(height) };
    let bands: Vec<Vec<Peak>> = starts.par_iter().map(|&first| widest(band(first))).collect();
    let mut peaks: Vec<Peak> = bands.into_iter().flatten().collect();
    peaks.sort_by(|a, b| b.strength.total_cmp(&a.strength));
    peaks
}

/// The centre tap and the taps to one side of a normalised Gaussian.
fn half_kernel() -> [f32; TAPS + 1] {
    let raw: [f64; TAPS + 1] = std::array::from_fn(|i| libm::exp(-0.5 * (i * i) as f64 / (SIGMA_PX * SIGMA_PX)));
    let sum = raw[0] + 2.0 * raw[1..].iter().sum::<f64>();
    raw.map(|v| (v / sum) as f32)
}

/// The peaks in some rows.
struct BandPeaks<'a> {
    image: &'a Raster<f32>,
    kernel: &'a [f32; TAPS + 1],
    rows: Range<usize>,
}

impl Kernel for BandPeaks<'_> {
    type Out = Vec<Peak>;

    #[inline(always)]
    fn run(self) -> Vec<Peak> {
        band_peaks(self.image, self.kernel, self.rows)
    }
}

/// Finds the peaks row by row: what is needed of the rows before is kept in rings, small enough for the cache.
#[inline(always)]
fn band_peaks(
    image: &Raster<f32>,
    kernel: &[f32; TAPS + 1],
    Range { start: first, end: last }: Range<usize>,
) -> Vec<Peak> {
    // Find the rows that the band needs: the response REACH rows further than the band, the smoothed picture one row further still.
    let (width, height) = (image.width(), image.height());
    let from = first.saturating_sub(REACH).max(1);
    let to = (last + REACH).min(height - 1);
    let mut smooth = Smoothing::new(image, kernel);
    (from - 1..=from).for_each(|row| smooth.add(row));

    // Keep rows of the response with zeros to both sides for what lies outside: no peak is beaten by them.
    let (mut response, mut along) = (RowRing::new(width + 2 * REACH), RowRing::new(width));
    let (mut twos, mut fours) = (RowRing::new(width), RowRing::new(width));
    let mut pairs = vec![0.0f32; 2 * (width + 2 * REACH)];
    let mut peaks = Vec::new();
    for row in from..last + REACH {
        // Compute the response of a row, and the largest of seven along it; beyond the picture there is none.
        if row < to {
            smooth.add(row + 1);
            let [above, here, below] = smooth.around(row);
            saddle(above, here, below, &mut response.row_mut(row)[REACH + 1..REACH + width - 1]);
            largest_of_seven(response.row(row), &mut pairs, along.row_mut(row));
        } else {
            response.row_mut(row).fill(0.0);
            along.row_mut(row).fill(0.0);
        }

        // Take the largest of it and the row before, and of these and the two before.
        larger_of(twos.row_mut(row), along.row(row), along.before(row, 1));
        larger_of(fours.row_mut(row), twos.row(row), twos.before(row, 2));

        // Find the maxima of the row in the middle of the last seven, and refine their positions.
        let Some(middle) =
            row.checked_sub(REACH).filter(|middle| (first.max(1)..last.min(height - 1)).contains(middle))
        else {
            continue;
        };
        let here = &response.row(middle)[REACH..REACH + width];
        let limits = [fours.row(middle), fours.row(row)].map(|limits| &limits[1..width - 1]);
        for column in maxima(&here[1..width - 1], limits).map(|x| x + 1) {
            let value = here[column];
            // Of equal values the first in reading order is the maximum.
            let span = column..column + 2 * REACH + 1;
            let tied = here[column.saturating_sub(REACH)..column].contains(&value)
                || (1..=REACH).any(|up| response.before(middle, up)[span.clone()].contains(&value));
            if !tied {
                let [above, here, below] = smooth.around(middle);
                let position =
                    stationary(above, here, below, column) + DVec2::new(column as f64 + 0.5, middle as f64 + 0.5);
                peaks.push(Peak { position, strength: value });
            }
        }
    }
    peaks
}

/// Rows that a [`RowRing`] holds: seven about a row, and one more, so that their number is a power of two.
const RING: usize = 2 * REACH + 2;

/// The last rows of a picture that is made row by row, zeros before the first.
struct RowRing {
    width: usize,
    rows: Vec<f32>,
}

impl RowRing {
    fn new(width: usize) -> Self {
        Self { width, rows: vec![0.0; RING * width] }
    }

    #[inline(always)]
    fn row(&self, row: usize) -> &[f32] {
        &self.rows[row % RING * self.width..][..self.width]
    }

    /// The row so many rows above another; there may be none.
    #[inline(always)]
    fn before(&self, row: usize, up: usize) -> &[f32] {
        self.row(row + RING - up)
    }

    #[inline(always)]
    fn row_mut(&mut self, row: usize) -> &mut [f32] {
        &mut self.rows[row % RING * self.width..][..self.width]
    }
}

/// Where a value is not below its limits, nor rounding. Whole runs are compared first, in lanes: a branch at each value would be
/// guessed wrong at every other pixel of a noisy picture.
#[inline(always)]
fn maxima<'a>(values: &'a [f32], [a, b]: [&'a [f32]; 2]) -> impl Iterator<Item = usize> + 'a {
    const RUN: usize = 8;
    let reaches = |v: f32, a: f32, b: f32| (v >= a) & (v >= b) & (v >= FLOOR);
    let runs = values.chunks(RUN).zip(a.chunks(RUN).zip(b.chunks(RUN))).enumerate();
    let some = runs.filter(move |(_, (v, (a, b)))| {
        v.iter().zip(a.iter().zip(*b)).map(|(v, (a, b))| u32::from(reaches(*v, *a, *b))).sum::<u32>() > 0
    });
    some.flat_map(move |(k, (v, (a, b)))| {
        (0..v.len()).filter(move |&i| reaches(v[i], a[i], b[i])).map(move |i| k * RUN + i)
    })
}

/// `out[x]` = the largest of the seven values from x on, by pairs of pairs.
#[inline(always)]
fn largest_of_seven(values: &[f32], scratch: &mut [f32], out: &mut [f32]) {
    let (twos, fours) = scratch.split_at_mut(values.len());
    larger_of(twos, values, &values[1..]);
    larger_of(fours, twos, &twos[2..]);
    larger_of(out, fours, &fours[3..]);
}

/// The larger of each two values, as far as both go.
#[inline(always)]
fn larger_of(out: &mut [f32], a: &[f32], b: &[f32]) {
    for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
        *out = if a > b { a } else { b };
    }
}

/// The picture smoothed by a separable Gaussian, its border repeated outside, row by row.
struct Smoothing<'a> {
    image: &'a Raster<f32>,
    kernel: &'a [f32; TAPS + 1],
    /// A row smoothed across the rows, with its border pixels repeated [`TAPS`] times at either end.
    padded: Vec<f32>,
    smooth: RowRing,
}

impl<'a> Smoothing<'a> {
    fn new(image: &'a Raster<f32>, kernel: &'a [f32; TAPS + 1]) -> Self {
        let width = image.width();
        Self { image, kernel, padded: vec![0.0; width + 2 * TAPS], smooth: RowRing::new(width) }
    }

    /// Smooths one row.
    #[inline(always)]
    fn add(&mut self, row: usize) {
        // Smooth it across the rows, the border row repeated outside.
        let (width, last) = (self.image.width(), self.image.height() - 1);
        let image = self.image;
        let beside = |tap: usize| [image.row(row.saturating_sub(tap)), image.row((row + tap).min(last))];
        let pairs = std::array::from_fn(|k| beside(k + 1));
        weighted(self.kernel, image.row(row), pairs, &mut self.padded[TAPS..TAPS + width]);

        // Smooth it along itself.
        let padded = &mut self.padded;
        let (left, right) = (padded[TAPS], padded[TAPS + width - 1]);
        padded[..TAPS].fill(left);
        padded[TAPS + width..].fill(right);
        let pairs = std::array::from_fn(|k| [&padded[TAPS - k - 1..], &padded[TAPS + k + 1..]]);
        weighted(self.kernel, &padded[TAPS..], pairs, self.smooth.row_mut(row));
    }

    /// The row above one, the row and the one below it.
    #[inline(always)]
    fn around(&self, row: usize) -> [&[f32]; 3] {
        [row - 1, row, row + 1].map(|row| self.smooth.row(row))
    }
}

/// `out` = the values of `centre` and the sums of each pair by the weights of a kernel.
#[inline(always)]
fn weighted(kernel: &[f32; TAPS + 1], centre: &[f32], pairs: [[&[f32]; 2]; TAPS], out: &mut [f32]) {
    let count = out.len();
    let (centre, pairs) = (&centre[..count], pairs.map(|pair| pair.map(|row| &row[..count])));
    for x in 0..count {
        let mut sum = kernel[0] * centre[x];
        for (weight, [a, b]) in kernel[1..].iter().zip(&pairs) {
            sum += weight * (a[x] + b[x]);
        }
        out[x] = sum;
    }
}

/// The response of the inner pixels of a row.
#[inline(always)]
fn saddle(above: &[f32], here: &[f32], below: &[f32], out: &mut [f32]) {
    let n = out.len();
    let (a0, a1, a2) = (&above[..n], &above[1..n + 1], &above[2..n + 2]);
    let (h0, h1, h2) = (&here[..n], &here[1..n + 1], &here[2..n + 2]);
    let (b0, b1, b2) = (&below[..n], &below[1..n + 1], &below[2..n + 2]);
    for x in 0..n {
        let twice = 2.0 * h1[x];
        let xx = h0[x] + h2[x] - twice;
        let yy = a1[x] + b1[x] - twice;
        let xy = 0.25 * ((a0[x] + b2[x]) - (a2[x] + b0[x]));
        let trace = xx + yy;
        out[x] = xy * xy - xx * yy - 0.125 * trace * trace;
    }
}

/// One Newton step from a pixel's centre to where the gradient vanishes, at most 1.5 px long.
fn stationary(above: &[f32], here: &[f32], below: &[f32], x: usize) -> DVec2 {
    let at = |row: &[f32], i: usize| f64::from(row[i]);
    let gx = 0.5 * (at(here, x + 1) - at(here, x - 1));
    let gy = 0.5 * (at(below, x) - at(above, x));
    let xx = at(here, x + 1) + at(here, x - 1) - 2.0 * at(here, x);
    let yy = at(below, x) + at(above, x) - 2.0 * at(here, x);
    let xy = 0.25 * (at(above, x - 1) + at(below, x + 1) - at(above, x + 1) - at(below, x - 1));
    // Negative at every peak, because the response is positive there.
    let determinant = xx * yy - xy * xy;
    let step = DVec2::new(xy * gy - yy * gx, xy * gx - xx * gy) / determinant;
    if step.is_finite() { step.clamp_length_max(1.5) } else { DVec2::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_agrees_with_imageproc() {
        let image = Raster::from_data(40, 30, (0..1200).map(|i| ((i * 7919) % 101) as f32 / 101.0).collect());
        let kernel = half_kernel();
        let row = 13;
        let mut smoothing = Smoothing::new(&image, &kernel);
        smoothing.add(row);
        let out = smoothing.smooth.row(row);
        let theirs = imageproc::filter::gaussian_blur_f32(
            &image::ImageBuffer::<image::Luma<f32>, _>::from_raw(40, 30, image.data().to_vec()).unwrap(),
            SIGMA_PX as f32,
        );
        // Their kernel ends at 2 sigma; the tails beyond hold 5 % of the weight, which a picture of such short waves
        // averages to less than 2 %.
        for (x, value) in out.iter().enumerate().skip(8).take(24) {
            assert!((value - theirs.get_pixel(x as u32, row as u32).0[0]).abs() < 0.02);
        }
    }

    #[test]
    fn peaks_are_the_strict_maxima_of_their_neighbourhoods() {
        let image = Raster::from_data(90, 150, (0..90 * 150).map(|i| ((i * 7919) % 1009) as f32 / 1009.0).collect());
        let found = peaks(&image);
        assert!(found.len() > 50);
        // The same answer whatever the bands, here found in one piece from a flipped picture.
        let flipped = Raster::from_data(90, 150, image.data().iter().rev().copied().collect());
        let mut back: Vec<Peak> = peaks(&flipped);
        back.iter_mut().for_each(|p| p.position = DVec2::new(90.0, 150.0) - p.position);
        assert_eq!(found.len(), back.len());
        for peak in &found {
            assert!(
                back.iter()
                    .any(|p| p.position.distance(peak.position) < 1e-3
                        && (p.strength / peak.strength - 1.0).abs() < 1e-3)
            );
            let apart = found.iter().filter(|p| p.position != peak.position);
            // Maxima are more than REACH apart; each may step by 1.5 px.
            assert!(apart.map(|p| (p.position - peak.position).abs().max_element()).fold(99.0, f64::min) > 0.9);
        }
    }

    #[test]
    fn a_single_crossing_is_the_strongest_peak() {
        let image = Raster::from_data(
            31,
            31,
            (0..31 * 31).map(|k| if (k % 31 < 16) == (k / 31 < 14) { 0.9 } else { 0.1 }).collect(),
        );
        let found = peaks(&image);
        // One Newton step by central differences from half a pixel away: rough, and enough for a start.
        assert!((found[0].position - DVec2::new(16.0, 14.0)).length() < 0.3, "{:?}", found[0]);
    }

    #[test]
    fn an_edge_a_line_and_a_blob_are_no_peaks() {
        let shapes: [fn(f32, f32) -> bool; 3] =
            [|x, y| x + 0.3 * y > 16.0, |x, y| (x - y).abs() < 3.0, |x, y| (x - 15.0).hypot(y - 15.0) < 4.0];
        for shape in shapes {
            let image = Raster::from_data(
                31,
                31,
                (0..31 * 31).map(|k| f32::from(u8::from(shape((k % 31) as f32, (k / 31) as f32)))).collect(),
            );
            // A crossing of this contrast responds with (1 / (2 pi 1.5^2 + ..))^2, about 0.01; what is left here comes
            // from the staircase of edges drawn without smoothing.
            let strongest = peaks(&image).first().map_or(0.0, |p| p.strength);
            assert!(strongest < 0.004, "{strongest}");
        }
    }
}
