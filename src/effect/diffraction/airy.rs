//! The diffraction pattern of a round aperture.

use crate::num::quadrature::gauss_legendre;
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

/// At most this share of the light of an even square whose side is 1 / `r` times wavelength times f-number leaves it, when
/// the pattern spreads it: twice what leaves a strip of that width, over one pair of sides and the other.
///
/// The light of a strip that stays has the transfer function times sinc^2 as its spectrum (Goodman, Introduction to Fourier
/// Optics, 4th ed., 7.3); what leaves is the integral of sinc^2 times what the transfer function takes off.
pub fn leaving_square(r: f64) -> f64 {
    // Waves of the strip up to here are integrated one by one; of the rest the mean of sin^2, 1/2, is right to 1e-3.
    const WAVES: usize = 16;
    let taken = |nu: f64| 1.0 - mtf(r * nu);
    let sinc2 = |nu: f64| {
        let sinc = libm::sin(PI * nu) / (PI * nu);
        sinc * sinc
    };
    let rule = gauss_legendre(12);
    let wave = |k: usize| rule.iter().map(|[x, w]| w * taken(k as f64 + x) * sinc2(k as f64 + x)).sum::<f64>();
    let near: f64 = (0..WAVES).map(wave).sum();
    // By the inverse of the wave number.
    let last = WAVES as f64;
    let far: f64 = gauss_legendre(200).iter().map(|[u, w]| w * taken(last / u)).sum::<f64>() / (2.0 * PI * PI * last);
    (2.0 * 1.01 * 2.0 * (near + far)).min(1.0)
}
