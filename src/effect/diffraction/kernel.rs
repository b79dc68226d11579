//! The weights by which diffraction mixes pixels.

use super::airy::{encircled_energy, mtf};
use crate::num::quadrature::gauss_legendre;
use std::f64::consts::{PI, TAU};

/// Wavelength times f-number is at most this many px: the kernel's near part then has 137 x 137 pixels.
pub const LARGEST_SCALE_PX: f64 = 16.0;
/// The share of the pattern's light that falls beyond the kernel.
const LOST: f64 = 0.005;
/// The near part ends past the third dark ring, at 3.24 times the scale: the pattern is below 1e-3 of its middle there.
const NEAR: f64 = 4.2;
/// The finest samples within a pixel.
const MAX_SAMPLES: usize = 4;
/// Frequencies from here on, in waves a sample, count for nothing: the spline's response and the sample's sinc leave as
/// nu^-4, and what is left out is 1e-5 of the whole.
const HIGHEST: f64 = 6.0;

/// How much of the light of each sample reaches a pixel.
///
/// The picture before diffraction is known by the means of its samples, `samples` x `samples` a pixel. Between their
/// centres the running mean is taken for the cubic spline through them, which for a picture of sharp edges is the best
/// linear guess (their spectrum falls as nu^-4, and the spline's response is that over its aliases). The Airy pattern
/// spreads the light, and the pixel's active square collects what falls on it. The spline would make some weights
/// negative, by little: they are 0, so that the picture keeps between its darkest and its brightest.
///
/// Further than `core` px from the pixel the pattern is low and its rings are finer than what it shows: there light is
/// summed up by blocks of pixels, with the mean over the rings, which falls as the cube of the distance. The pattern
/// never ends and the kernel does, at `radius` px: the light beyond, a share of `lost`, is put back into the far part in
/// proportion. All weights sum to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSpread {
    pub(super) samples: usize,
    pub(super) core: usize,
    /// Of the samples, from the first row of the core: (2 core + 1) samples a side.
    pub(super) near: Vec<f64>,
    pub(super) far: Far,
    lost: f64,
}

/// The far part of a kernel, by blocks of pixels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Far {
    /// Pixels along the side of a block, an odd number.
    pub(super) block: usize,
    /// Blocks to each side.
    pub(super) reach: usize,
    /// Weights of the blocks' means, from the first row: 2 reach + 1 a side.
    pub(super) weights: Vec<f64>,
}

/// Samples a pixel, along each side, that a pattern of the given scale takes: an edge is wrong by as much as the pattern is
/// curved over a sample, so they are a quarter of it, or of a pixel.
pub(super) fn samples(scale_px: f64) -> usize {
    ((MAX_SAMPLES as f64 / scale_px.max(1.0)).ceil() as usize).clamp(1, MAX_SAMPLES)
}

impl PointSpread {
    /// The kernel for wavelength times f-number in px, and for pixels whose active part is a square in their middle with a
    /// side of `active` px, from as many samples a pixel as it takes.
    ///
    /// # Panics
    /// When the scale is not within (0, [`LARGEST_SCALE_PX`]], or `active` not within (0, 1].
    pub fn new(scale_px: f64, active: f64) -> Self {
        Self::with_samples(scale_px, active, samples(scale_px))
    }

    /// The same from a given number of samples a pixel, along each side.
    ///
    /// # Panics
    /// As [`PointSpread::new`].
    pub fn with_samples(scale_px: f64, active: f64, samples: usize) -> Self {
        assert!(scale_px > 0.0 && scale_px <= LARGEST_SCALE_PX, "wavelength x f-number of {scale_px} px");
        assert!(active > 0.0 && active <= 1.0, "an active side of {active} px");
        let core = 1 + (NEAR * scale_px).ceil() as usize;
        let side = (2 * core + 1) * samples;
        let step = 1.0 / samples as f64;
        let first = 0.5 * step - 0.5 - core as f64;
        let mut near = quarter(scale_px, [active, step], first, side.div_ceil(2));
        spread(&mut near, side);
        // HIGHEST may make it a little more than all.
        let kept = near.iter().sum::<f64>().min(1.0);
        near.iter_mut().for_each(|w| *w = w.max(0.0));
        scale_to(&mut near, kept);
        let far = Far::new(scale_px, core, 1.0 - kept);
        let lost = 1.0 - encircled_energy(far.radius() as f64 / scale_px);
        Self { samples, core, near, far, lost }
    }

    /// Samples a pixel, along each side, of the pictures that it is for.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Pixels that it reaches, to each side.
    pub fn radius(&self) -> usize {
        self.far.radius()
    }

    /// The share of the light that falls beyond the kernel and was put back into it.
    pub fn lost(&self) -> f64 {
        self.lost
    }
}

impl Far {
    /// The share `light` of the pattern, beyond `core` px.
    fn new(scale_px: f64, core: usize, light: f64) -> Self {
        // What is seen of the far light changes over lengths of the core.
        let block = 2 * (core / 4) + 1;
        // Beyond r px falls 2 scale / (pi^2 r) of the light, on average over the rings.
        let radius = 2.0 * scale_px / (PI * PI * LOST);
        let reach = ((radius / block as f64).ceil() as usize).max(core / block + 1);
        let side = 2 * reach + 1;
        let (half, core) = (block as f64 / 2.0 - 0.5, core as f64);
        // The mean over a block's pixels of what the mean over the rings, r^-3, has outside of the core.
        let weight = |m: usize, n: usize| {
            let offset = |m: usize, k: usize| (m as f64 - reach as f64) * block as f64 + k as f64 - half;
            let pixels = (0..block * block).map(|k| [offset(m, k % block), offset(n, k / block)]);
            let outside = pixels.filter(|[x, y]| x.abs().max(y.abs()) > core);
            outside.map(|[x, y]| 1.0 / ((x * x + y * y) * (x * x + y * y).sqrt())).sum::<f64>()
        };
        let mut weights: Vec<f64> = (0..side * side).map(|k| weight(k % side, k / side)).collect();
        scale_to(&mut weights, light);
        Self { block, reach, weights }
    }

    fn radius(&self) -> usize {
        self.reach * self.block + self.block / 2
    }
}

/// Makes the weights sum to `sum`.
fn scale_to(weights: &mut [f64], sum: f64) {
    let scale = sum / weights.iter().sum::<f64>();
    weights.iter_mut().for_each(|w| *w *= scale);
}

/// The weights at (first + i step, first + j step), i and j in 0..n, of samples with a side of step px:
///
/// step^2 times the integral of the transfer function, of the active square's sinc and the spline's response on both axes,
/// and of the waves of the place, over the frequencies nu up to the cut-off: in polar coordinates about frequency 0,
/// where the transfer function has its peak.
fn quarter(scale_px: f64, [active, step]: [f64; 2], first: f64, n: usize) -> Vec<f64> {
    // The waves turn this often over the radius; the rules below resolve them (a rule of n nodes holds n / pi waves).
    let highest = (1.0 / scale_px).min(HIGHEST / step);
    let phase = TAU * highest * (first.abs() + 1.0) * 2f64.sqrt();
    let radial = gauss_legendre(phase.ceil() as usize + 32);
    let turns = (0.3 * phase).ceil() as usize + 16;
    let mut sum = vec![0.0; n * n];
    let (mut along_x, mut along_y) = (vec![0.0; n], vec![0.0; n]);
    for [w, weight] in radial {
        // t = 1 - (1 - w)^2 smooths the end of the transfer function, which leaves as (1 - t)^(3/2).
        let (t, dt) = (w * (2.0 - w), 2.0 * (1.0 - w) * weight);
        let reach = step * highest;
        let ring = mtf(t * highest * scale_px) * t * dt * reach * reach * TAU / turns as f64;
        for k in 0..turns {
            let (sin, cos) = libm::sincos(0.5 * PI * (k as f64 + 0.5) / turns as f64);
            let nu = [cos, sin].map(|c| t * c * highest);
            waves(nu[0], first, step, &mut along_x);
            waves(nu[1], first, step, &mut along_y);
            let boxes = nu.map(|nu| sinc(active * nu) * spline(step * nu));
            let value = ring * boxes[0] * boxes[1];
            for (row, y) in sum.chunks_exact_mut(n).zip(&along_y) {
                let value = value * y;
                row.iter_mut().zip(&along_x).for_each(|(s, x)| *s += value * x);
            }
        }
    }
    // The two axes are alike.
    (0..n * n).map(|k| 0.5 * (sum[k] + sum[(k % n) * n + k / n])).collect()
}

/// cos(2 pi nu (first + k step)), by the recurrence of Chebyshev.
fn waves(nu: f64, first: f64, step: f64, out: &mut [f64]) {
    let twice = 2.0 * libm::cos(TAU * nu * step);
    let (mut now, mut next) = (libm::cos(TAU * nu * first), libm::cos(TAU * nu * (first + step)));
    for v in out {
        *v = now;
        (now, next) = (next, twice * next - now);
    }
}

/// The response at `nu` waves a sample of the cubic spline through samples, without the response sinc(nu) of the samples
/// themselves: nu^-4 / sum over m of (nu + m)^-4, over sinc(nu).
fn spline(nu: f64) -> f64 {
    let s = sinc(nu);
    s * s * s * 3.0 / (2.0 + libm::cos(TAU * nu))
}

fn sinc(x: f64) -> f64 {
    let v = PI * x;
    if v.abs() < 1e-8 { 1.0 } else { libm::sin(v) / v }
}

/// From the first quarter to the whole square of `side` weights a side, symmetric about its middle.
fn spread(weights: &mut Vec<f64>, side: usize) {
    let n = side.div_ceil(2);
    let fold = |k: usize| k.min(side - 1 - k);
    *weights = (0..side * side).map(|k| weights[fold(k / side) * n + fold(k % side)]).collect();
}
