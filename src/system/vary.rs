//! The variants of an instrument that effects ask for.

use super::System;
use crate::effect::Variant;

impl System {
    /// The instrument with `n` x `n` pixels in place of each.
    #[must_use]
    pub fn sampled(&self, n: usize) -> Self {
        Self { camera: self.camera.sampled(n), ..self.clone() }
    }

    /// The instrument of one variant.
    #[must_use]
    pub fn varied(&self, variant: &Variant) -> Self {
        let camera = match &self.effects.thin_lens {
            Some(lens) => self.camera.through(lens, variant.pupil_mm),
            None => self.camera,
        };
        let Some(wave) = &variant.wave else { return Self { camera, ..self.clone() } };
        let prism = self.prism.as_ref().map(|prism| prism.with_index_shift(wave.index_shift));
        Self { camera, prism, effects: self.effects.at_wavelength(wave.wavelength_nm), ..self.clone() }
    }
}
