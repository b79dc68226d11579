//! The variants of an instrument that effects ask for.

use super::instrument::System;
use crate::effect::Variant;

impl System {
    /// The instrument with `n` x `n` pixels in place of each.
    #[must_use]
    pub fn sampled(&self, n: usize) -> Self {
        Self { camera: self.camera.sampled(n), ..self.clone() }
    }

    /// The instrument with a sensor of `size_px` of its own pixels, from pixel `first` on.
    #[must_use]
    pub fn window(&self, first: [usize; 2], size_px: [usize; 2]) -> Self {
        Self { camera: self.camera.window(first, size_px), ..self.clone() }
    }

    /// The instrument of one variant.
    #[must_use]
    pub fn variant(&self, variant: &Variant) -> Self {
        let camera = match (&self.effects.thin_lens, &self.effects.telecentric) {
            (Some(lens), _) => self.camera.through(lens, variant.pupil),
            (None, Some(lens)) => self.camera.along(lens, variant.pupil),
            (None, None) => self.camera,
        };
        let prism = self.prism.as_ref().map(|prism| {
            let prism = prism.with_slopes(variant.slopes);
            variant.wave.map_or(prism.clone(), |wave| prism.with_index_shift(wave.index_shift))
        });
        let effects = match &variant.wave {
            Some(wave) => self.effects.at_wavelength(wave.wavelength_nm),
            None => self.effects.clone(),
        };
        Self { camera, prism, effects, ..self.clone() }
    }
}
