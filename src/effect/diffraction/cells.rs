//! How the cells of a pixel that is not evenly lit share its light.

use super::airy::mtf;
use super::cosines::Cosines;
use super::transfer::Optics;
use crate::num::simd::{self, widest};

/// Cells reach as far as the fourth dark ring of the pattern, at 4.24 times its scale: beyond, it is below 1e-3 of its middle,
/// and what cells differ by is a share of that.
const REACH: f64 = 4.2;
/// The weights are taken from a pattern that repeats after this many times its reach, both ways.
const PERIOD: usize = 2;
/// Weights are kept in blocks of this many, the last of which ends with zeros.
const BLOCK: usize = 8;

/// How much of the light of each cell of a pixel reaches the pixels around it, less the mean over all its cells: what
/// [`super::PixelSpread`] leaves out.
#[derive(Debug, Clone)]
pub struct CellSpread {
    cells: usize,
    reach: usize,
    /// For each cell the weights of the pixels around, row by row, and zeros to whole blocks.
    weights: Vec<f32>,
    stride: usize,
}

impl CellSpread {
    /// For wavelength times f-number in px, an active square of side `active` px, and an even number of cells along each side
    /// of a pixel.
    ///
    /// # Panics
    /// When `cells` is odd.
    pub fn new(scale: f64, active: f64, cells: usize) -> Self {
        assert!(cells.is_multiple_of(2), "{cells} cells");
        let reach = 1 + (REACH * scale).ceil() as usize;

        // The weight of a cell, by its distance along each axis in steps of cells and a half.
        let step = 1.0 / cells as f64;
        let optics = Optics { scale, active, even: step, cell: step };
        let half = PERIOD * (reach + 1) * cells;
        let nu = |k: usize| k as f64 / (2 * half) as f64 * cells as f64;
        let along: Vec<f64> = (0..half).map(|k| optics.along(nu(k))).collect();
        let area = 1.0 / (half * half) as f64;
        let pattern = Cosines::new([half, half]).sum(|k, l| {
            let radius = (nu(k) * nu(k) + nu(l) * nu(l)).sqrt();
            area * mtf(scale * radius) * along[k] * along[l]
        });

        // Collect them cell by cell, and take off what they have in common.
        let side = 2 * reach + 1;
        let stride = (side * side).next_multiple_of(BLOCK);
        let away = |offset: usize, cell: usize| {
            // From the cell to the middle of the pixel, in half steps: an odd number.
            let from =
                2 * (offset as isize - reach as isize) * cells as isize - (2 * cell as isize + 1 - cells as isize);
            (from.unsigned_abs() - 1) / 2
        };
        let mut weights = vec![0.0f32; cells * cells * stride];
        for offset in 0..side * side {
            let of =
                |cell: usize| pattern[away(offset / side, cell / cells) * half + away(offset % side, cell % cells)];
            let mean = (0..cells * cells).map(of).sum::<f64>() * step * step;
            (0..cells * cells).for_each(|cell| weights[cell * stride + offset] = (of(cell) - mean) as f32);
        }
        Self { cells, reach, weights, stride }
    }

    /// Cells along each side of a pixel.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Pixels that a cell reaches, to each side.
    pub fn reach(&self) -> usize {
        self.reach
    }

    /// Writes to `out` what the cells of a pixel add to the pixels around it, from `reach` rows above and columns to the left
    /// on, row by row. `light(i, j)` is that of the cell in column i and row j; only differences from the first one count.
    pub(crate) fn add(&self, light: impl Fn(usize, usize) -> f32, out: &mut Vec<f32>) {
        out.clear();
        out.resize(self.stride, 0.0);
        let first = light(0, 0);
        for j in 0..self.cells {
            for i in 0..self.cells {
                let more = light(i, j) - first;
                if more != 0.0 {
                    let at = (j * self.cells + i) * self.stride;
                    widest(Add { weights: &self.weights[at..at + self.stride], more, out });
                }
            }
        }
    }
}

/// A kernel that adds multiples of weights.
struct Add<'a> {
    weights: &'a [f32],
    more: f32,
    out: &'a mut [f32],
}

impl simd::Kernel for Add<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { weights, more, out } = self;
        for (out, weights) in out.as_chunks_mut::<BLOCK>().0.iter_mut().zip(weights.as_chunks::<BLOCK>().0) {
            out.iter_mut().zip(weights).for_each(|(out, weight)| *out += more * weight);
        }
    }
}
