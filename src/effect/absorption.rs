//! What the glass absorbs.

use super::journey::LightPath;
use crate::optics::fresnel::left_after;

/// A glass that absorbs the same share of the light over every millimetre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Absorption {
    /// The coefficient of Beer and Lambert's law, in 1/mm.
    pub per_mm: f64,
}

impl Absorption {
    /// Whether it changes nothing.
    pub fn is_nothing(&self) -> bool {
        self.per_mm == 0.0
    }

    /// The share of the light that is left after its way through the glass: exp(-per_mm way).
    pub fn throughput(&self, journey: &LightPath) -> f64 {
        journey.crossings.get(1).map_or(1.0, |out| left_after(self.per_mm, out.way_mm))
    }
}
