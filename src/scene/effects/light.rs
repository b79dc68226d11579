//! The effects of the glass on light: their tables as written, with their ranges, and what they become.

use super::rules;
use crate::effect::{Absorption, Coating, Dispersion, Fresnel, Ghosts};
use crate::error::Error;
use crate::optics::fresnel::{Layer, absorption_per_mm};
use crate::optics::medium::MATERIALS;
use crate::optics::polarisation::PolarisationState as Polarised;
use crate::optics::spectrum::{
    Illuminant, LightSource, Response, Sensitivity, SpectralLine, VISIBLE_NM, WavelengthBand, nodes,
};
use crate::scene::document::Document;
use crate::scene::limits::*;
use crate::scene::model::{GlassSpec, PrismSpec};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The wavelength to which an index belongs where the scene says nothing, in nm.
pub(crate) fn d_line() -> f64 {
    D_LINE_NM
}

/// The names that a glass may have.
pub(crate) fn glasses() -> Vec<&'static str> {
    MATERIALS.iter().map(|material| material.name).collect()
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct FresnelFile {
    /// Which light counts: all, or what a polariser in front of the lens lets through, its electric field along the
    /// image's x or y.
    pub(super) polarisation: PolarisationFile,
}

#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum PolarisationFile {
    #[default]
    Unpolarised,
    X,
    Y,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CoatingFile {
    /// Refractive index of the layer; magnesium fluoride has 1.38. The light is of the wavelength to which the prism's index
    /// belongs, or of each wavelength of `effect.dispersion`.
    #[schemars(range(min = SMALLEST_INDEX, max = LARGEST_INDEX))]
    pub(super) index: f64,
    /// Thickness of the layer, in nm.
    #[schemars(range(min = 0, max = THICKEST_LAYER_NM))]
    pub(super) thickness_nm: Option<f64>,
    /// Instead of the thickness: the wavelength, in nm, of which the layer is a quarter.
    #[schemars(range(min = SHORTEST_WAVE_NM, max = LONGEST_WAVE_NM))]
    pub(super) quarter_wave_nm: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AbsorptionFile {
    /// Absorption coefficient of the glass, in 1/mm.
    #[schemars(range(min = 0, max = ABSORPTION_PER_MM))]
    pub(super) per_mm: Option<f64>,
    /// Instead of the coefficient: internal transmittance of 10 mm of the glass, as catalogues give it.
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0))]
    pub(super) transmittance_10mm: Option<f64>,
}

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct GhostsFile {
    /// Light that has been reflected more often is given up.
    #[schemars(range(min = 0, max = BOUNCES))]
    pub(super) bounces: u32,
    /// Light of a smaller share of what would come in is given up.
    #[schemars(range(min = 0, max = 1))]
    pub(super) least_power: f64,
    /// Radiance of what lies on the camera's side of the glass, of full scale 1.
    #[schemars(range(min = 0, max = RADIANCE))]
    pub(super) behind: f64,
    /// Rays along each side of a pixel.
    #[schemars(range(min = 1, max = GHOST_SAMPLES))]
    pub(super) samples: usize,
}

impl Default for GhostsFile {
    fn default() -> Self {
        Self { bounces: 4, least_power: 1e-6, behind: 0.0, samples: 2 }
    }
}

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct DispersionFile {
    /// Sharp lines of the light, in nm. Left out, the light is a band.
    #[schemars(length(max = WAVES), inner(range(min = SHORTEST_WAVE_NM, max = LONGEST_WAVE_NM)))]
    pub(super) lines_nm: Vec<f64>,
    /// Powers of the lines of `lines_nm`, one each, in any unit. Left out, they are the same.
    #[schemars(length(max = WAVES), inner(range(min = 0, max = POWER)))]
    pub(super) powers: Vec<f64>,
    /// Shortest and longest wavelength of the light where it is a band, in nm.
    #[schemars(inner(range(min = SHORTEST_WAVE_NM, max = LONGEST_WAVE_NM)))]
    pub(super) band_nm: [f64; 2],
    /// Power over the band: the same everywhere, or that of an illuminant of the CIE; D65 is known from 380 to 780 nm.
    pub(super) illuminant: IlluminantFile,
    /// What the sensor makes of the light: "grey" responds to all of it alike, the others see red, green and blue.
    pub(super) response: ResponseFile,
    /// Red, green and blue of the sensor by rows [wavelength in nm, red, green, blue], in place of `response`.
    #[schemars(length(max = RESPONSE_ROWS))]
    pub(super) sensitivities: Vec<SensitivityFile>,
    /// Wavelengths that stand for a band, a picture each.
    #[schemars(range(min = 1, max = WAVES))]
    pub(super) wavelengths: usize,
}

impl Default for DispersionFile {
    fn default() -> Self {
        Self {
            lines_nm: Vec::new(),
            powers: Vec::new(),
            band_nm: [400.0, 700.0],
            illuminant: IlluminantFile::Even,
            response: ResponseFile::Grey,
            sensitivities: Vec::new(),
            wavelengths: 16,
        }
    }
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub(super) enum IlluminantFile {
    #[serde(rename = "even")]
    Even,
    A,
    D65,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum ResponseFile {
    Grey,
    NikonD5100,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub(super) struct SensitivityFile(
    #[schemars(range(min = SHORTEST_WAVE_NM, max = LONGEST_WAVE_NM))] pub(super) f64,
    #[schemars(range(min = 0, max = POWER))] pub(super) f64,
    #[schemars(range(min = 0, max = POWER))] pub(super) f64,
    #[schemars(range(min = 0, max = POWER))] pub(super) f64,
);

pub(super) fn fresnel(file: &FresnelFile) -> Fresnel {
    let light = match file.polarisation {
        PolarisationFile::Unpolarised => Polarised::Unpolarised,
        PolarisationFile::X => Polarised::X,
        PolarisationFile::Y => Polarised::Y,
    };
    Fresnel { light }
}

/// One of two keys of a table, and not both.
fn either(document: &Document, table: &str, keys: [&str; 2], values: [Option<f64>; 2]) -> Result<f64, Error> {
    let (at, rule, help) = match values {
        [Some(value), None] => return Ok(value),
        [None, Some(value)] => return Ok(value),
        [None, None] => {
            (table.to_owned(), format!("`[{table}]` has neither `{}` nor `{}`", keys[0], keys[1]), "add one of the two")
        }
        [Some(_), Some(_)] => (
            format!("{table}.{}", keys[1]),
            format!("`[{table}]` has both `{}` and `{}`, which say the same", keys[0], keys[1]),
            "take one of the two out",
        ),
    };
    Err(document.fault(&at, rule, help))
}

/// The layer on the glass of `prism`.
pub(super) fn coating(document: &Document, file: &CoatingFile, prism: &PrismSpec) -> Result<Coating, Error> {
    let keys = ["thickness_nm", "quarter_wave_nm"];
    let value = either(document, "effect.coating", keys, [file.thickness_nm, file.quarter_wave_nm])?;
    let layer = match file.thickness_nm {
        Some(thickness_nm) => Layer { index: file.index, thickness_nm },
        None => Layer::quarter_wave(file.index, value),
    };
    let body = prism.body();
    Ok(Coating {
        layer,
        outer_index: body.map_or(1.0, |body| body.outer_index),
        wavelength_nm: body.map_or(D_LINE_NM, |body| body.wavelength_nm),
    })
}

pub(super) fn absorption(document: &Document, file: &AbsorptionFile) -> Result<Absorption, Error> {
    let keys = ["per_mm", "transmittance_10mm"];
    let value = either(document, "effect.absorption", keys, [file.per_mm, file.transmittance_10mm])?;
    Ok(Absorption { per_mm: file.per_mm.unwrap_or_else(|| absorption_per_mm(value, 10.0)) })
}

pub(super) fn ghosts(file: &GhostsFile) -> Ghosts {
    Ghosts { bounces: file.bounces, least_power: file.least_power, behind: file.behind, samples: file.samples }
}

/// The wavelengths of the light in the glass of `prism`.
pub(super) fn dispersion(document: &Document, file: &DispersionFile, prism: &PrismSpec) -> Result<Dispersion, Error> {
    let key = |key: &str| format!("effect.dispersion.{key}");
    let fault = |at: &str, rule: String, help: &str| Err(document.fault(&key(at), rule, help));
    let (glass, body) = rules::named_glass(document, prism)?;
    let light = light(document, file)?;
    let response = response(document, file)?;
    let at = if file.lines_nm.is_empty() { "band_nm" } else { "lines_nm" };
    rules::glass_is_known(document, &key(at), light.band(), glass)?;
    let colour = matches!(response, Response::Rgb(_));
    let nodes = match nodes(&light, &response, file.wavelengths) {
        Ok(nodes) => nodes,
        Err(dark) => {
            let at = if file.sensitivities.is_empty() { "response" } else { "sensitivities" };
            return fault(
                at,
                format!("`{}`: {dark}", key(at)),
                "let the light and the response overlap in each channel",
            );
        }
    };
    match Dispersion::new(&nodes, colour, glass, body.wavelength_nm) {
        Ok(dispersion) => Ok(dispersion),
        // Light and reference are within what is known of the glass, as was judged above.
        Err(unknown) => fault("lines_nm", format!("`[effect.dispersion]`: {unknown}"), "name another glass"),
    }
}

fn light(document: &Document, file: &DispersionFile) -> Result<LightSource, Error> {
    let fault =
        |key: &str, rule: String, help: &str| Err(document.fault(&format!("effect.dispersion.{key}"), rule, help));
    let given = |key: &&str| document.has("effect.dispersion", key);
    if file.lines_nm.is_empty() && given(&"powers") {
        let rule = "`effect.dispersion.powers` are those of lines, and `lines_nm` names none".to_owned();
        return fault("powers", rule, "add `lines_nm`, or take `powers` out");
    }
    if let Some(key) = ["band_nm", "illuminant", "wavelengths"].into_iter().find(given)
        && !file.lines_nm.is_empty()
    {
        let rule =
            format!("`effect.dispersion.{key}` is about the light of a band, and `lines_nm` gives lines instead");
        return fault(key, rule, "take one of the two keys out");
    }
    if file.lines_nm.is_empty() {
        let [from_nm, to_nm] = file.band_nm;
        if from_nm >= to_nm {
            let rule = format!("`effect.dispersion.band_nm` runs from {from_nm} to {to_nm} nm, which is nowhere");
            return fault("band_nm", rule, "give the shorter wavelength first");
        }
        let band = WavelengthBand { from_nm, to_nm };
        let known = VISIBLE_NM;
        if matches!(file.illuminant, IlluminantFile::D65) && (from_nm < known.from_nm || to_nm > known.to_nm) {
            let rule = format!(
                "`effect.dispersion.band_nm` runs from {from_nm} to {to_nm} nm, and D65 is known from {} to {} nm",
                known.from_nm, known.to_nm
            );
            return fault("band_nm", rule, "keep the band within that, or take another `illuminant`");
        }
        return Ok(match file.illuminant {
            IlluminantFile::Even => LightSource::Band(band),
            IlluminantFile::A => LightSource::Illuminant(Illuminant::A, band),
            IlluminantFile::D65 => LightSource::Illuminant(Illuminant::D65, band),
        });
    }
    if !file.powers.is_empty() && file.powers.len() != file.lines_nm.len() {
        let rule =
            format!("`effect.dispersion.powers` has {} values for {} lines", file.powers.len(), file.lines_nm.len());
        return fault("powers", rule, "give one power for each line, or leave `powers` out");
    }
    if !file.powers.is_empty() && file.powers.iter().all(|power| *power == 0.0) {
        let rule = "`effect.dispersion.powers` are all 0, and there is no light".to_owned();
        return fault("powers", rule, "give at least one line a power above 0");
    }
    let power = |k: usize| file.powers.get(k).copied().unwrap_or(1.0);
    let line = |(k, &wavelength_nm): (usize, &f64)| SpectralLine { wavelength_nm, power: power(k) };
    Ok(LightSource::Lines(file.lines_nm.iter().enumerate().map(line).collect()))
}

fn response(document: &Document, file: &DispersionFile) -> Result<Response, Error> {
    if file.sensitivities.is_empty() {
        return Ok(match file.response {
            ResponseFile::Grey => Response::Flat,
            ResponseFile::NikonD5100 => Response::nikon_d5100(),
        });
    }
    if let Some(k) = file.sensitivities.windows(2).position(|pair| pair[0].0 >= pair[1].0) {
        let at = format!("effect.dispersion.sensitivities[{}]", k + 1);
        let rule = format!("`{at}` is at {} nm, not beyond the row before", file.sensitivities[k + 1].0);
        return Err(document.fault(&at, rule, "sort the rows by rising wavelength"));
    }
    let row = |row: &SensitivityFile| Sensitivity { wavelength_nm: row.0, rgb: [row.1, row.2, row.3] };
    Ok(Response::Rgb(file.sensitivities.iter().map(row).collect()))
}

impl GlassSpec {
    /// What is doubtful about the index of a named glass: it lies farther from the catalogue's than the melts of a glass
    /// differ.
    pub fn index_doubt(&self) -> Option<String> {
        // The widest of the usual grades of optical glass (ISO 12123, NP100 is 0.001).
        const MELTS: f64 = 1e-3;
        let glass = self.glass?;
        let Ok(known) = glass.index(self.wavelength_nm) else {
            let [first, last] = glass.range_nm;
            return Some(format!(
                "`prism.wavelength_nm` is {}, and the index of {} is known from {first} to {last} nm",
                self.wavelength_nm, glass.name
            ));
        };
        if (self.index - known).abs() <= MELTS {
            return None;
        }
        let other = match glass.wavelength_nm_of(self.index, 5e-5) {
            Some(nm) => format!("{} is its index at {nm:.0} nm", self.index),
            None => format!("it has {} nowhere from 300 to 1100 nm", self.index),
        };
        Some(format!(
            "`prism.index` is {}, and {} has {known:.5} at {} nm ({}): {other}",
            self.index, glass.name, self.wavelength_nm, glass.source
        ))
    }
}
