//! All that spreads the light of a picture behind one lens.

use super::cells::CellSpread;
use super::settings::Diffraction;
use super::transfer::PixelSpread;

/// How a lens spreads light.
#[derive(Debug, Clone)]
pub struct LightSpread {
    /// That of evenly lit pixels.
    pub pixels: PixelSpread,
    /// That of the cells of the others; `None` where pixels do for them.
    pub cells: Option<CellSpread>,
    /// The share of the picture that is spread so: see [`Diffraction::spread_scale`].
    pub share: f64,
}

impl LightSpread {
    /// For a lens that diffracts, for pixels with an active square of side `active` px, and for as many cells along each side of a
    /// pixel as [`Diffraction::cells`] has.
    pub fn new(lens: &Diffraction, active: f64, cells: usize) -> Self {
        let (scale, share) = lens.spread_scale();
        let pixels = PixelSpread::new(scale, active, cells);
        let cells = (cells > 1).then(|| CellSpread::new(scale, active, cells));
        Self { pixels, cells, share }
    }
}
