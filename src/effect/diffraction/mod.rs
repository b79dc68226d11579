//! Diffraction at the lens's round aperture: the picture is convolved with the Airy pattern.
//!
//! M. Born, E. Wolf, Principles of Optics (7th ed.), 8.5.2 (the pattern and its encircled energy); J. W. Goodman,
//! Introduction to Fourier Optics (4th ed.), 7.3 (the transfer function of an incoherent, aberration-free system).
//!
//! The picture is known by up to 4 x 4 samples a pixel. Of an edge, a pixel is off by up to 1.2 % of the contrast where
//! wavelength times f-number is 0.14 px, 0.8 % at 0.56 px and 0.5 % at 2.2 px, and the place where it is half bright by up to
//! 2.3e-3 px: against the integral of the transfer function, at all phases. The kernel's tests derive a bound of it.
//!
//! One wavelength serves the whole picture, 550 nm unless the scene says otherwise: light of many wavelengths, as of
//! dispersion, is spread by one pattern.

mod convolve;
mod kernel;

pub use convolve::blur;
pub use kernel::{Kernel, LARGEST_SCALE_PX};

use crate::raster::MAX_PIXELS;
use std::f64::consts::PI;

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
    /// `kernel::samples` asks for, but no more than a picture may hold pixels.
    pub fn samples(&self, size_px: [usize; 2]) -> usize {
        let fits = |n: &usize| size_px[0] * size_px[1] * n * n <= MAX_PIXELS;
        (1..=kernel::samples(self.scale_px())).rev().find(fits).unwrap_or(1)
    }
}

/// The first zero of the pattern is at this distance over wavelength times f-number: 3.8317 / pi.
pub const FIRST_ZERO: f64 = 1.219_669_891_266_504_5;

/// The irradiance of the Airy pattern over that of its middle, at a distance of `r` times wavelength times f-number:
/// (2 J1(v) / v)^2 with v = pi r.
pub fn airy(r: f64) -> f64 {
    let v = PI * r;
    // The series of 2 J1(v) / v is 1 - v^2 / 8 + v^4 / 192 - ...
    let amplitude = if v.abs() < 1e-4 { 1.0 - v * v / 8.0 } else { 2.0 * libm::j1(v) / v };
    amplitude * amplitude
}

/// The share of the pattern's light within a distance of `r` times wavelength times f-number: 1 - J0(v)^2 - J1(v)^2
/// with v = pi r (Rayleigh).
pub fn encircled_energy(r: f64) -> f64 {
    let v = PI * r;
    let (j0, j1) = (libm::j0(v), libm::j1(v));
    1.0 - j0 * j0 - j1 * j1
}

/// The modulation transfer function at `nu` times the cut-off frequency 1 / (wavelength times f-number):
/// (2 / pi) (acos nu - nu sqrt(1 - nu^2)), 0 from the cut-off on.
pub fn mtf(nu: f64) -> f64 {
    let nu = nu.abs();
    if nu < 1.0 { 2.0 / PI * (libm::acos(nu) - nu * (1.0 - nu * nu).sqrt()) } else { 0.0 }
}

#[cfg(test)]
mod tests;
