//! The effects of a scene file: the tables as written, with their ranges, and what they become.

use super::lens::QuadratureFile;
use super::sensor::{SensorFile, sensor};
use super::{as_built, lens, light, rules};
use crate::accuracy::COARSEST_TARGET_PX;
use crate::effect::thin_lens::{Aperture, ThinLens};
use crate::effect::{Cos4, Diffraction, Effects, Lamp, Lens, Threshold};
use crate::error::Error;
use crate::scene::document::Document;
use crate::scene::limits::*;
use crate::scene::model::{BoardSpec, CameraSpec, PrismSpec};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum EffectsFile {
    Word(WordFile),
    Auto(AutoFile),
}

impl Default for EffectsFile {
    fn default() -> Self {
        Self::Word(WordFile::All)
    }
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::scene) enum WordFile {
    All,
    None,
    Auto,
}

/// Those that may change more than a threshold.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::scene) struct AutoFile {
    /// The threshold: effects that together change less are left out.
    pub(super) auto: ThresholdFile,
}

/// Changes that may be left out; effects must be below each that is given.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ThresholdFile {
    /// Change of a pixel, of full scale 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1))]
    pub(super) grey: Option<f64>,
    /// Move of an edge or a corner, in px.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = COARSEST_TARGET_PX))]
    pub(super) px: Option<f64>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct EffectTables {
    /// A lens of finite aperture in place of the pinhole: what is out of focus is blurred.
    pub(super) thin_lens: Option<ThinLensFile>,
    /// A telecentric lens in place of the pinhole, with its pupils at infinity on both sides.
    pub(super) telecentric: Option<lens::TelecentricFile>,
    /// What keeps rays from passing: the rim of the prism, a ridge that is not sharp, a stop before the lens.
    pub(super) clipping: Option<lens::ClippingFile>,
    /// The prism as it was made.
    pub(super) manufacture: Option<as_built::ManufactureFile>,
    /// Rough surfaces, which scatter.
    pub(super) roughness: Option<as_built::RoughnessFile>,
    /// The natural fall of light towards the rim of the picture.
    pub(super) cos4: Option<Cos4File>,
    /// A point lamp that lights the board.
    pub(super) lamp: Option<LampFile>,
    /// What the surfaces of the glass reflect is missing behind it.
    pub(super) fresnel: Option<light::FresnelFile>,
    /// A single layer on every surface of the glass, against reflections.
    pub(super) coating: Option<light::CoatingFile>,
    /// What the glass absorbs.
    pub(super) absorption: Option<light::AbsorptionFile>,
    /// Light that arrives after reflections at the surfaces of the glass.
    pub(super) ghosts: Option<light::GhostsFile>,
    /// Light of many wavelengths, each bent by its own index.
    pub(super) dispersion: Option<light::DispersionFile>,
    /// Diffraction at a round aperture: the picture is convolved with the Airy pattern.
    pub(super) diffraction: Option<DiffractionFile>,
    /// A sensor that is not ideal: what a key does not ask for is left out.
    pub(super) sensor: Option<SensorFile>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ThinLensFile {
    /// Focal length over diameter of the aperture, the focal length by the thin lens equation from `focus_mm` and the
    /// camera's distance to its sensor. The working f-number, as of `effect.diffraction`, is that distance over the diameter.
    #[schemars(range(min = SMALLEST_F_NUMBER, max = LARGEST_F_NUMBER))]
    pub(super) f_number: f64,
    /// Distance from the lens to the plane that it would show sharp without a prism, in mm.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) focus_mm: f64,
    /// Sides of the aperture, a regular polygon. Left out, it is a circle.
    #[schemars(range(min = 3, max = BLADES))]
    pub(super) blades: Option<usize>,
    /// Direction of the polygon's first corner, from right to down, in deg.
    #[serde(default)]
    #[schemars(range(min = -TILT_DEG, max = TILT_DEG))]
    pub(super) rotation_deg: f64,
}

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Cos4File {
    /// The power of the cosine of the field angle; 4 by the law.
    #[schemars(range(min = 0, max = EXPONENT))]
    pub(super) exponent: f64,
}

impl Default for Cos4File {
    fn default() -> Self {
        Self { exponent: 4.0 }
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LampFile {
    /// Position [x, y, z] of the lamp, in mm.
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) position_mm: [f64; 3],
    /// The lamp's share of the light at the middle of the board; the rest comes evenly from all around.
    #[serde(default = "whole")]
    #[schemars(range(min = 0, max = 1))]
    pub(super) share: f64,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DiffractionFile {
    /// Distance from the lens's exit pupil to the sensor over the diameter of the pupil: the working f-number, which that of
    /// `effect.thin_lens` is not.
    #[schemars(range(min = 0, max = LARGEST_F_NUMBER))]
    pub(super) f_number: f64,
    /// Wavelength of the light, in nm. One pattern serves all colours, also with `effect.dispersion`.
    #[serde(default = "green")]
    #[schemars(range(min = SHORTEST_WAVE_NM, max = LONGEST_WAVE_NM))]
    pub(super) wavelength_nm: f64,
}

fn whole() -> f64 {
    1.0
}

fn green() -> f64 {
    550.0
}

/// The effects that are to be simulated.
///
/// # Errors
/// When an effect cannot be with this camera and this board.
pub(crate) fn effects(
    document: &Document,
    which: EffectsFile,
    file: &EffectTables,
    quadrature: &QuadratureFile,
    camera: &CameraSpec,
    board: &BoardSpec,
    prism: &PrismSpec,
) -> Result<Effects, Error> {
    for (there, table) in [(file.coating.is_some(), "effect.coating"), (file.ghosts.is_some(), "effect.ghosts")] {
        if there && file.fresnel.is_none() {
            return Err(rules::needs_fresnel(document, table));
        }
    }
    let lens = match (&file.thin_lens, &file.telecentric) {
        (Some(_), Some(_)) => return Err(lens::two_lenses(document)),
        (Some(lens), None) => Lens::Thin(thin_lens(lens, camera)),
        (None, Some(lens)) => Lens::Telecentric(lens::telecentric(document, lens)?),
        (None, None) => Lens::Pinhole,
    };
    let all = Effects {
        lens,
        clipping: file
            .clipping
            .as_ref()
            .map(|clipping| lens::clipping(document, clipping, camera, prism, board))
            .transpose()?,
        manufacture: file.manufacture.as_ref().map(|file| as_built::manufacture(document, file, prism)).transpose()?,
        roughness: file.roughness.as_ref().map(as_built::roughness),
        cos4: file.cos4.as_ref().map(|cos4| Cos4 { exponent: cos4.exponent }),
        lamp: file.lamp.as_ref().map(|file| lamp(document, file, camera, board)).transpose()?,
        fresnel: file.fresnel.as_ref().map(light::fresnel),
        coating: file.coating.as_ref().map(|file| light::coating(document, file, prism)).transpose()?,
        absorption: file.absorption.as_ref().map(|file| light::absorption(document, file)).transpose()?,
        ghosts: file.ghosts.as_ref().map(light::ghosts),
        dispersion: file.dispersion.as_ref().map(|file| light::dispersion(document, file, prism)).transpose()?,
        diffraction: file.diffraction.as_ref().map(|file| diffraction(document, file, camera)).transpose()?,
        sensor: file.sensor.as_ref().map(|file| sensor(document, file)).transpose()?,
        quadrature: lens::quadrature(document, quadrature)?,
        auto: None,
    };
    // A table that is not simulated must be right all the same.
    let auto = |threshold| Effects { auto: Some(threshold), ..all.clone() };
    Ok(match which {
        EffectsFile::Word(WordFile::All) => all,
        EffectsFile::Word(WordFile::None) => Effects::default(),
        EffectsFile::Word(WordFile::Auto) => auto(Threshold::default()),
        EffectsFile::Auto(AutoFile { auto: ThresholdFile { grey: None, px: None } }) => {
            let rule = "`effects.auto` is empty, and says of no effect that it may be left out".to_owned();
            let help = "give `grey`, `px` or both: effects = { auto = { grey = 0.002, px = 0.01 } }";
            return Err(document.fault("effects", rule, help));
        }
        EffectsFile::Auto(AutoFile { auto: ThresholdFile { grey, px } }) => auto(Threshold { grey, px }),
    })
}

fn thin_lens(file: &ThinLensFile, camera: &CameraSpec) -> ThinLens {
    let rotation_rad = file.rotation_deg.to_radians();
    let aperture = file.blades.map_or(Aperture::Circle, |blades| Aperture::Polygon { blades, rotation_rad });
    ThinLens::new(file.f_number, file.focus_mm, aperture, camera.focal_length_mm)
}

fn diffraction(document: &Document, file: &DiffractionFile, camera: &CameraSpec) -> Result<Diffraction, Error> {
    let diffraction =
        Diffraction { wavelength_nm: file.wavelength_nm, f_number: file.f_number, pitch_mm: camera.pitch_mm };
    rules::pattern_is_kept(document, &diffraction).map(|()| diffraction)
}

fn lamp(document: &Document, file: &LampFile, camera: &CameraSpec, board: &BoardSpec) -> Result<Lamp, Error> {
    let (middle, normal) = (board.world_from_board.translation_mm, board.world_from_board.rotation.z_axis);
    let position_mm = DVec3::from_array(file.position_mm);
    rules::lamp_lights(document, position_mm, camera, board)?;
    Ok(Lamp::new(position_mm, file.share, middle, normal))
}
