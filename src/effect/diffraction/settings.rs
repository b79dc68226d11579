//! The settings of diffraction.

use super::kernel;
use crate::raster::MAX_PIXELS;

/// The lens as diffraction sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diffraction {
    /// Wavelength in vacuum, in nm.
    pub wavelength_nm: f64,
    /// Distance from the exit pupil to the sensor over the diameter of the pupil: the working f-number.
    pub f_number: f64,
    /// Side of a pixel, in mm.
    pub pitch_mm: f64,
}

impl Diffraction {
    /// Wavelength times f-number over the pitch: the unit of all lengths of the pattern, in px.
    pub fn scale_px(&self) -> f64 {
        self.wavelength_nm * 1e-6 * self.f_number / self.pitch_mm
    }

    /// Whether it changes nothing.
    pub fn is_nothing(&self) -> bool {
        self.scale_px() == 0.0
    }

    /// Samples along each side of a pixel from which a picture of the given size is convolved: as many as
    /// `kernel::samples` gives, but no more than a picture may hold pixels.
    pub fn samples(&self, size_px: [usize; 2]) -> usize {
        let fits = |n: &usize| size_px[0] * size_px[1] * n * n <= MAX_PIXELS;
        (1..=kernel::samples(self.scale_px())).rev().find(fits).unwrap_or(1)
    }
}
