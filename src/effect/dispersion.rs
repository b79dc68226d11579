//! The glass bends every wavelength by its own index.

use crate::optics::medium::{Material, OutOfRange};
use crate::optics::spectrum::SpectrumNode;
use crate::raster::transfer::luminance;

/// The few wavelengths that stand for the light.
#[derive(Debug, Clone, PartialEq)]
pub struct Dispersion {
    /// The wavelengths with their shares.
    pub waves: Vec<Wavelength>,
    /// Whether the sensor tells colours apart.
    pub colour: bool,
}

/// A wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wavelength {
    /// The wavelength in vacuum, in nm.
    pub wavelength_nm: f64,
    /// The index of the glass at this wavelength, less that at the wavelength to which the scene's own index belongs.
    pub index_shift: f64,
    /// Its share of what red, green and blue receive; all three are the same where the sensor tells no colours apart.
    pub weights: [f64; 3],
}

impl Wavelength {
    /// Its share of the grey picture, which is the luminance of the channels.
    pub fn grey(&self) -> f64 {
        let [r, g, b] = self.weights;
        if r == g && g == b { g } else { luminance(r, g, b) }
    }
}

impl Dispersion {
    /// The light of `nodes` in `glass`, whose index is given at `reference_nm`. The glass at hand may differ from its
    /// catalogue by what its melt does, a constant in good approximation: only the change over the wavelengths is taken
    /// from there.
    ///
    /// # Errors
    /// Where the catalogue says nothing of a wavelength.
    pub fn new(nodes: &[SpectrumNode], colour: bool, glass: &Material, reference_nm: f64) -> Result<Self, OutOfRange> {
        let reference = glass.index(reference_nm)?;
        let wave = |node: &SpectrumNode| {
            let index_shift = glass.index(node.wavelength_nm)? - reference;
            Ok(Wavelength { wavelength_nm: node.wavelength_nm, index_shift, weights: node.weights })
        };
        Ok(Self { waves: nodes.iter().map(wave).collect::<Result<_, _>>()?, colour })
    }

    /// Whether it changes nothing: all light has the wavelength of the scene's own index.
    pub fn is_nothing(&self) -> bool {
        !self.colour && self.waves.iter().all(|wave| wave.index_shift == 0.0)
    }
}
