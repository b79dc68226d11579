//! The natural fall of light towards the rim of the picture.

use super::journey::LightPath;

/// The cosine fourth law, or another power of the cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cos4 {
    /// The power of the cosine: 4 by the law, 0 for none.
    pub exponent: f64,
}

impl Cos4 {
    /// Whether it changes nothing.
    pub fn is_nothing(&self) -> bool {
        self.exponent == 0.0
    }

    /// cos^p of the angle at which light meets the sensor. A pupil element of area dA at the distance d along the axis
    /// gives a radiance L the irradiance L cos^4 dA / d^2: twice the cosine for the two tilted areas, twice for the
    /// longer way (Born & Wolf, Principles of Optics, 4.8.3).
    pub fn throughput(&self, journey: &LightPath) -> f64 {
        libm::pow(journey.image_cos, self.exponent)
    }
}
