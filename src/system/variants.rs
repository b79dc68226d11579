//! The variants of an instrument over which ray effects are averaged.

use super::instrument::System;
use crate::effect::dispersion::Wavelength;
use crate::effect::{Effects, Lens, Variant};
use crate::prism::biprism::Prism;
use std::borrow::Cow;

impl System {
    /// The instrument with `n` x `n` pixels in place of each.
    #[must_use]
    pub fn sampled(&self, n: usize) -> Self {
        Self { camera: self.camera.sampled(n), ..self.clone() }
    }

    /// The instrument with the surfaces of its prism continued beyond where they were given, where their formulas go on there.
    #[must_use]
    pub fn continued(&self) -> Self {
        Self { prism: self.prism.as_ref().map(Prism::continued), ..self.clone() }
    }

    /// The instrument with a sensor of `size_px` of its own pixels, from pixel `first` on.
    #[must_use]
    pub fn window(&self, first: [usize; 2], size_px: [usize; 2]) -> Self {
        Self { camera: self.camera.window(first, size_px), ..self.clone() }
    }

    /// The instrument with a sensor that has `frame` more pixels on every side.
    #[must_use]
    pub fn framed(&self, frame: usize) -> Self {
        Self { camera: self.camera.framed(frame), ..self.clone() }
    }

    /// The instrument in each of the wavelengths that stand for the scene's light, through the middle of the pupil, with its
    /// share of the grey picture; the instrument itself where its light has the wavelength of the scene's own index.
    pub fn wavelengths(&self) -> Vec<(f64, Cow<'_, Self>)> {
        match self.effects.dispersion.as_ref().filter(|dispersion| !dispersion.is_nothing()) {
            None => vec![(1.0, Cow::Borrowed(self))],
            Some(dispersion) => {
                let at = |wave: &Wavelength| (wave.grey(), Cow::Owned(self.at_wavelength(wave)));
                dispersion.waves.iter().map(at).collect()
            }
        }
    }

    /// The instrument in light of one wavelength alone.
    #[must_use]
    pub fn at_wavelength(&self, wave: &Wavelength) -> Self {
        let prism = self.prism.as_ref().map(|prism| prism.with_index_shift(wave.index_shift));
        let effects = Effects { dispersion: None, ..self.effects.at_wavelength(wave.wavelength_nm) };
        Self { prism, effects, ..self.clone() }
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
