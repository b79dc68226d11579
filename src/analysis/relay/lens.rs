//! The ideal lens behind the prism.

use glam::DVec2;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// An ideal (paraxial) lens, telecentric on the side of the prism, its axis parallel to the camera's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayLens {
    /// Numerical aperture on the side of the prism: the sine of the outermost ray to the axis.
    pub na: f64,
    /// Size of the image over that of the object.
    pub magnification: f64,
    /// Wavelength in vacuum, in mm.
    pub wavelength_mm: f64,
}

impl RelayLens {
    /// Radius of the first dark ring of a perfect lens, in the image plane, in um: 0.61 lambda / (NA / M).
    pub fn airy_radius_um(&self) -> f64 {
        1e3 * 0.61 * self.wavelength_mm * self.magnification / self.na
    }

    /// Frequency in the image at which a perfect lens has no contrast left, in cycles/mm: 2 NA / (lambda M).
    pub fn cut_off_per_mm(&self) -> f64 {
        2.0 * self.na / (self.wavelength_mm * self.magnification)
    }
}

/// Points of the unit disc that stand for equal areas: `rings` circles, each of 4 `rings` points.
pub fn disc(rings: usize) -> Vec<DVec2> {
    let spokes = 4 * rings;
    let on = |ring: usize, spoke: usize| {
        let radius = ((ring as f64 + 0.5) / rings as f64).sqrt();
        let angle = (spoke as f64 + 0.5) * FRAC_PI_2 / rings as f64;
        radius * DVec2::new(libm::cos(angle), libm::sin(angle))
    };
    (0..rings).flat_map(|ring| (0..spokes).map(move |spoke| on(ring, spoke))).collect()
}

/// The contrast of a perfect lens at `shift`, the frequency over half that of the cut-off: 0 to 2.
pub(crate) fn perfect_contrast(shift: f64) -> f64 {
    if shift >= 2.0 {
        return 0.0;
    }
    let half = 0.5 * shift;
    (libm::acos(half) - half * (1.0 - half * half).sqrt()) * FRAC_2_PI
}
