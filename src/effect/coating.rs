//! An anti-reflection layer on every surface of the glass.

use crate::optics::fresnel::{Interface, Layer};

/// The same layer on facets and backs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coating {
    /// The layer.
    pub layer: Layer,
    /// Refractive index around the glass.
    pub outer_index: f64,
    /// The light's wavelength in vacuum, in nm.
    pub wavelength_nm: f64,
}

impl Coating {
    /// Whether it changes nothing.
    pub fn is_nothing(&self) -> bool {
        self.layer.thickness_nm == 0.0
    }

    /// The surface that light meets with `eta` = n_in / n_out, on its way into the glass or out of it.
    pub fn interface(&self, eta: f64, out: bool) -> Interface {
        let outer = self.outer_index;
        let (n_in, n_out) = if out { (eta * outer, outer) } else { (outer, outer / eta) };
        // Without thickness the indices do not matter, only their ratio: the same numbers as on a bare surface.
        if self.is_nothing() {
            Interface::bare(eta, 1.0)
        } else {
            Interface { n_in, n_out, layer: Some((self.layer, self.wavelength_nm)) }
        }
    }
}
