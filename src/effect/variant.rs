//! A variant of the instrument: one sample of its ray effects. The picture is the weighted mean over variants.

use super::dispersion;
use glam::DVec2;

/// One variant of the instrument, with one ray to each place of the picture like the plain one, and its share of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variant {
    /// The point of the pupil: in mm from its centre for a lens, as the sines of a direction for a telecentric one.
    pub pupil: DVec2,
    /// Slopes that are added to those of the front and the back where they refract.
    pub slopes: [DVec2; 2],
    /// The wavelength; `None` for the one to which the scene's index belongs.
    pub wave: Option<dispersion::Wavelength>,
    /// Its share of the grey picture; the shares of all variants sum up to 1.
    pub grey: f64,
    /// Its shares of red, green and blue, each of which sums up to 1; `None` in all variants where the sensor tells no
    /// colours apart.
    pub colour: Option<[f64; 3]>,
}
