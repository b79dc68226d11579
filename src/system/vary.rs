//! The variants of an instrument that ray effects average over.

use super::System;
use crate::effect::Variant;

impl System {
    /// The instrument of one variant.
    #[must_use]
    pub fn varied(&self, variant: &Variant) -> Self {
        let camera = match &self.effects.thin_lens {
            Some(lens) => self.camera.through(lens, variant.pupil_mm),
            None => self.camera,
        };
        Self { camera, ..self.clone() }
    }
}
