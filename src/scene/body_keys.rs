//! The keys of a prism's glass and place, which every kind of prism has, as they are written.

use super::effects::light::{d_line, glasses};
use super::law::LawFile;
use super::limits::*;
use schemars::JsonSchema;
use serde::Deserialize;

#[derive(Debug, Deserialize, JsonSchema)]
pub(super) struct BodyFile {
    /// Refractive index of the glass.
    #[schemars(range(min = SMALLEST_INDEX, max = LARGEST_INDEX))]
    pub(super) index: f64,
    /// Refractive index of what surrounds the glass.
    #[serde(default = "one")]
    #[schemars(range(min = SMALLEST_INDEX, max = LARGEST_INDEX))]
    pub(super) outer_index: f64,
    /// Name of the glass: how its index changes with the wavelength.
    #[schemars(extend("enum" = glasses()))]
    pub(super) glass: Option<String>,
    /// Wavelength in vacuum to which `index` belongs, in nm. Left out, it is that of the catalogues' n_d.
    #[serde(default = "d_line")]
    #[schemars(range(min = SHORTEST_WAVE_NM, max = LONGEST_WAVE_NM))]
    pub(super) wavelength_nm: f64,
    /// Whether the prism is one piece of glass: light leaves it through the surface that bounds the glass where it does, the back
    /// of the half in which that place is. Of `false`, every half is followed as if its own surfaces went on beyond x = 0. Left
    /// out, it is true of `kind = "revolved"` and of designs by an objective other than `march`.
    pub(super) solid: Option<bool>,
    /// Position [x, y, z] of the prism's frame, in mm.
    #[serde(default)]
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) position_mm: [f64; 3],
    /// Tilt [rx, ry, rz] of the prism about the fixed x, then y, then z axis, in deg.
    #[serde(default)]
    #[schemars(inner(range(min = -TILT_DEG, max = TILT_DEG)))]
    pub(super) tilt_deg: [f64; 3],
    /// What the halves of the picture are meant to be, against which figures called designed are taken: the right half, in the
    /// prism's frame with the camera's pinhole at its origin; the left one is its mirror image. Left out, cameras parallel to the
    /// real one, beside it on the central ray of each half, or what `prism.design` aims at.
    pub(super) law: Option<LawFile>,
}

fn one() -> f64 {
    1.0
}
