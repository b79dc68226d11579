//! The variants of an instrument that effects ask for.

use super::instrument::System;
use crate::effect::{Lens, Variant};

impl System {
    /// The instrument with `n` x `n` pixels in place of each.
    #[must_use]
    pub fn sampled(&self, n: usize) -> Self {
        Self { camera: self.camera.sampled(n), ..self.clone() }
    }

    /// The instrument of one variant.
    #[must_use]
    pub fn variant(&self, variant: &Variant) -> Self {
        let camera = match &self.effects.lens {
            Lens::Thin(lens) => self.camera.through(lens, variant.pupil),
            Lens::Telecentric(lens) => self.camera.along(lens, variant.pupil),
            Lens::Pinhole => self.camera,
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
