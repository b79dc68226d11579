//! The contrast of sinusoidal patterns (modulation transfer), by diffraction and by rays.

use super::lens::perfect_contrast;
use super::pencil::{PencilRay, at_plane};
use super::wave_error::WaveError;
use crate::num::quadrature::gauss_legendre;
use glam::DVec2;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Nodes of the rules of the overlap, along each axis, by rising number: half as many more from one to the next.
const RULES: [usize; 9] = [16, 24, 36, 54, 80, 120, 180, 270, 405];
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
/// focused on each of the planes `focus_mm`; `None` where the wave error changes too fast for the finest rule.
///
/// The autocorrelation of the pupil function: the modulus of the mean of exp(2 pi i (W(p + s/2) - W(p - s/2))) over the overlap of two
/// pupils that are s = lambda nu / NA apart, times the overlap's share of the pupil (Born and Wolf, Principles of Optics, 9.5).
/// Gauss's rule over the overlap, of as many nodes as two rules need to agree, so that no grid of samples is chosen.
pub fn diffraction(wave: &WaveError, frequency_per_mm: f64, along: DVec2, focus_mm: &[f64]) -> Option<Vec<f64>> {
    let lens = wave.lens();
    let shift = lens.wavelength_mm * lens.magnification * frequency_per_mm / lens.na;
    if shift >= 2.0 {
        return Some(vec![0.0; focus_mm.len()]);
    }

    // Raise the rule for the planes in which it does not agree with the one before.
    let mut planes: Vec<PlaneMean> =
        focus_mm.iter().map(|z| PlaneMean { focus_mm: *z, mean: None, settled: false }).collect();
    for nodes in RULES {
        let overlap = overlap(wave, shift, along, nodes);
        planes.par_iter_mut().filter(|plane| !plane.settled).for_each(|plane| plane.refine(wave, &overlap));
        if planes.iter().all(|plane| plane.settled) {
            return planes.iter().map(|plane| plane.mean.map(DVec2::length)).collect();
        }
    }
    None
}

/// The integral over the overlap, over pi, as real and imaginary part, with the lens focused on one plane.
#[derive(Debug, Clone, Copy)]
struct PlaneMean {
    focus_mm: f64,
    mean: Option<DVec2>,
    settled: bool,
}

impl PlaneMean {
    /// By the next rule.
    fn refine(&mut self, wave: &WaveError, overlap: &[OverlapNode]) {
        let mut sum = DVec2::ZERO;
        for node in overlap {
            let (sin, cos) = libm::sincos(TAU * (node.waves + wave.defocus(self.focus_mm) * node.along));
            sum += node.weight * DVec2::new(cos, sin);
        }
        self.settled = self.mean.is_some_and(|before| (sum - before).length() < AGREED);
        self.mean = Some(sum);
    }
}

/// A place of the overlap of the two pupils.
#[derive(Debug, Clone, Copy)]
struct OverlapNode {
    /// Its share of the pupil; the weights of all have the overlap's share as their sum.
    weight: f64,
    /// The wave error at the place in one pupil less that in the other, in waves.
    waves: f64,
    /// The same of the sine or cosine that a change of focus adds by: see [`WaveError::along`].
    along: f64,
}

/// The nodes of the rule of `nodes` x `nodes`, which are the same for every focus.
fn overlap(wave: &WaveError, shift: f64, along: DVec2, nodes: usize) -> Vec<OverlapNode> {
    let half = 0.5 * shift;
    let height = (1.0 - half * half).sqrt();
    let rule = gauss_legendre(nodes);
    let row = |[u, row]: &[f64; 2]| {
        // Across the shift: height sin(t), which takes the root out of the ends.
        let t = FRAC_PI_2 * (2.0 * u - 1.0);
        let (sin, cos) = libm::sincos(t);
        let across = height * sin;
        let width = (1.0 - across * across).sqrt() - half;
        // Both rules run over (0, 1): twice the half widths.
        let weight = row * FRAC_PI_2 * 2.0 * height * cos * width * 2.0 / PI;
        let node = |[w, column]: &[f64; 2]| {
            let place = along * (width * (2.0 * w - 1.0)) + along.perp() * across;
            let [one, other] = [1.0, -1.0].map(|sign| place + along * (sign * half));
            OverlapNode {
                weight: weight * column,
                waves: wave.series_waves(one) - wave.series_waves(other),
                along: wave.along(one) - wave.along(other),
            }
        };
        rule.iter().map(node).collect::<Vec<_>>()
    };
    rule.par_iter().map(row).collect::<Vec<_>>().concat()
}

/// The contrast by rays alone: |mean exp(2 pi i nu X)| over `rays`, which stand for equal areas of the pupil.
pub fn geometric(rays: &[PencilRay], object_frequency_per_mm: f64, along: DVec2, focus_mm: f64) -> f64 {
    let mut sum = DVec2::ZERO;
    for ray in rays {
        let phase = TAU * object_frequency_per_mm * at_plane(&ray.exit, focus_mm).dot(along);
        let (sin, cos) = libm::sincos(phase);
        sum += DVec2::new(cos, sin);
    }
    sum.length() / rays.len().max(1) as f64
}

/// All contrasts at a frequency in the image, with the lens focused on each of the planes `focus_mm`; `None` as of [`diffraction`].
pub fn contrasts(
    wave: &WaveError,
    rays: &[PencilRay],
    frequency_per_mm: f64,
    focus_mm: &[f64],
) -> Option<Vec<Contrast>> {
    let lens = wave.lens();
    let [x, y] = [DVec2::X, DVec2::Y].map(|along| diffraction(wave, frequency_per_mm, along, focus_mm));
    let object = lens.magnification * frequency_per_mm;
    let of = |(focus_mm, diffraction): (&f64, [f64; 2])| Contrast {
        frequency_per_mm,
        perfect: perfect_contrast(lens.wavelength_mm * object / lens.na),
        diffraction,
        geometric: [DVec2::X, DVec2::Y].map(|along| geometric(rays, object, along, *focus_mm)),
    };
    let both = x?.into_iter().zip(y?).map(|(x, y)| [x, y]);
    Some(focus_mm.iter().zip(both).map(of).collect())
}
