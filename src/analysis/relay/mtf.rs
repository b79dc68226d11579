//! The contrast of sinusoidal patterns (modulation transfer), by diffraction and by rays.

use super::lens::perfect_contrast;
use super::pencil::{PencilRay, at_plane};
use super::wave_error::WaveError;
use crate::num::quadrature::gauss_legendre;
use glam::DVec2;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Nodes of the first rule of the overlap, along each axis.
const FIRST_NODES: usize = 24;
/// Nodes of the last one.
const MOST_NODES: usize = 384;
/// Rules agree to this.
const AGREED: f64 = 1e-6;

/// The contrast at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contrast {
    /// In the image, in cycles/mm.
    pub frequency_per_mm: f64,
    /// Of a perfect lens.
    pub perfect: f64,
    /// By diffraction, for patterns that vary along x and along y.
    pub diffraction: [f64; 2],
    /// By rays alone.
    pub geometric: [f64; 2],
}

/// The contrast by diffraction at a frequency in the image, of a pattern that varies along the unit vector `along`, with the lens
/// focused on the plane `focus_mm`; `None` where the wave error changes too fast for the finest rule.
///
/// The autocorrelation of the pupil function: the modulus of the mean of exp(2 pi i (W(p + s/2) - W(p - s/2))) over the overlap of two
/// pupils that are s = lambda nu / NA apart, times the overlap's share of the pupil (Born and Wolf, Principles of Optics, 9.5).
/// Gauss's rule over the overlap, of as many nodes as two rules need to agree, so that no grid of samples is chosen.
pub fn diffraction(wave: &WaveError, frequency_per_mm: f64, along: DVec2, focus_mm: f64) -> Option<f64> {
    let lens = wave.lens();
    let shift = lens.wavelength_mm * lens.magnification * frequency_per_mm / lens.na;
    if shift >= 2.0 {
        return Some(0.0);
    }
    let mut nodes = FIRST_NODES;
    let mut before = overlap_mean(wave, shift, along, focus_mm, nodes);
    while nodes < MOST_NODES {
        nodes *= 2;
        let now = overlap_mean(wave, shift, along, focus_mm, nodes);
        if (now - before).length() < AGREED {
            return Some(now.length());
        }
        before = now;
    }
    None
}

/// The integral over the overlap, over pi, as real and imaginary part, by a rule of `nodes` x `nodes`.
fn overlap_mean(wave: &WaveError, shift: f64, along: DVec2, focus_mm: f64, nodes: usize) -> DVec2 {
    let half = 0.5 * shift;
    let height = (1.0 - half * half).sqrt();
    let rule = gauss_legendre(nodes);
    let mut sum = DVec2::ZERO;
    for [u, row] in &rule {
        // Across the shift: height sin(t), which takes the root out of the ends.
        let t = FRAC_PI_2 * (2.0 * u - 1.0);
        let across = height * libm::sin(t);
        let width = (1.0 - across * across).sqrt() - half;
        let weight = row * FRAC_PI_2 * 2.0 * height * libm::cos(t) * width;
        for [w, column] in &rule {
            let place = along * (width * (2.0 * w - 1.0)) + along.perp() * across;
            let ends = [1.0, -1.0].map(|sign| wave.waves(place + along * (sign * half), focus_mm));
            let phase = TAU * (ends[0] - ends[1]);
            sum += weight * column * DVec2::new(libm::cos(phase), libm::sin(phase));
        }
    }
    // Both rules run over (0, 1): twice the half widths.
    sum * 2.0 / PI
}

/// The contrast by rays alone: |mean exp(2 pi i nu X)| over `rays`, which stand for equal areas of the pupil.
pub fn geometric(rays: &[PencilRay], object_frequency_per_mm: f64, along: DVec2, focus_mm: f64) -> f64 {
    let mut sum = DVec2::ZERO;
    for ray in rays {
        let phase = TAU * object_frequency_per_mm * at_plane(&ray.exit, focus_mm).dot(along);
        sum += DVec2::new(libm::cos(phase), libm::sin(phase));
    }
    sum.length() / rays.len().max(1) as f64
}

/// All contrasts at a frequency in the image; `None` as of [`diffraction`].
pub fn contrast(wave: &WaveError, rays: &[PencilRay], frequency_per_mm: f64, focus_mm: f64) -> Option<Contrast> {
    let lens = wave.lens();
    let [x, y] = [DVec2::X, DVec2::Y].map(|along| diffraction(wave, frequency_per_mm, along, focus_mm));
    let object = lens.magnification * frequency_per_mm;
    Some(Contrast {
        frequency_per_mm,
        perfect: perfect_contrast(lens.wavelength_mm * object / lens.na),
        diffraction: [x?, y?],
        geometric: [DVec2::X, DVec2::Y].map(|along| geometric(rays, object, along, focus_mm)),
    })
}
