//! The diffraction pattern of a round aperture.

use std::f64::consts::PI;

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
