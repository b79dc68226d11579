//! The sensor of a scene file: the table as written, with its ranges, and what it becomes.

use super::rules;
use crate::effect::Sensor;
use crate::effect::sensor::{Adc, Bayer, Demosaic, Order};
use crate::error::Error;
use crate::scene::document::Document;
use crate::scene::limits::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SensorFile {
    /// Names the specimen, and with `frame` the noise.
    #[serde(default)]
    #[schemars(range(max = SEED))]
    pub(super) seed: u32,
    /// Number of the exposure: another one has other noise on the same specimen.
    #[serde(default)]
    #[schemars(range(max = SEED))]
    pub(super) frame: u32,
    /// The part of a pixel's area that collects light, a square in its middle.
    #[serde(default = "one")]
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0))]
    pub(super) fill_factor: f64,
    /// Colour filters over the pixels, by the four in the upper left corner. Left out, there are none.
    pub(super) bayer: Option<BayerFile>,
    /// The share of their light that the red, green and blue filters let through.
    #[schemars(inner(range(min = 0, max = 1)))]
    pub(super) transmission: Option<[f64; 3]>,
    /// How the filters' mosaic becomes a picture: raw, one value a pixel; or bilinear, three colours.
    pub(super) demosaic: Option<DemosaicFile>,
    /// Electrons that radiance 1 frees in a pixel during the exposure. Given, light is shot noise too.
    #[schemars(range(max = ELECTRONS), extend("exclusiveMinimum" = 0))]
    pub(super) white_e: Option<f64>,
    /// Whether electrons come at random. Left out, they do where `white_e` is given.
    pub(super) shot_noise: Option<bool>,
    /// Photo response non-uniformity: standard deviation of the pixels' gain, of 1.
    #[serde(default)]
    #[schemars(range(min = 0, max = UNEVENNESS))]
    pub(super) prnu: f64,
    /// Mean electrons that come without light.
    #[schemars(range(min = 0, max = ELECTRONS))]
    pub(super) dark_e: Option<f64>,
    /// Dark signal non-uniformity: standard deviation of the pixels' offset, in electrons.
    #[schemars(range(min = 0, max = ELECTRONS))]
    pub(super) dsnu_e: Option<f64>,
    /// Standard deviation of the noise of a read-out, in electrons.
    #[schemars(range(min = 0, max = ELECTRONS))]
    pub(super) read_noise_e: Option<f64>,
    /// Electrons that a pixel holds. Left out, it holds all.
    #[schemars(range(max = ELECTRONS), extend("exclusiveMinimum" = 0))]
    pub(super) full_well_e: Option<f64>,
    /// Bits of the converter. Left out, there is none: values are electrons over `white_e`.
    #[schemars(range(min = 1, max = ADC_BITS))]
    pub(super) adc_bits: Option<u32>,
    /// Numbers of the converter an electron. Left out, the full well, or radiance 1 where it holds all, gives the largest
    /// number.
    #[schemars(range(max = GAIN), extend("exclusiveMinimum" = 0))]
    pub(super) gain_dn_per_e: Option<f64>,
    /// Number of the converter for no electrons. Left out, it is 0.
    #[schemars(range(min = 0, max = BLACK_LEVEL))]
    pub(super) black_level_dn: Option<f64>,
    /// The picture holds value^(1 / gamma). Where that is not 1, a PNG is not coded again: see `output.encoding`.
    #[serde(default = "one")]
    #[schemars(range(min = 1.0 / GAMMA, max = GAMMA))]
    pub(super) gamma: f64,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum BayerFile {
    Rggb,
    Bggr,
    Grbg,
    Gbrg,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum DemosaicFile {
    Raw,
    Bilinear,
}

fn one() -> f64 {
    1.0
}

/// The sensor that `file` describes.
///
/// # Errors
/// A key that says something of what another key would have to name first.
pub(super) fn sensor(document: &Document, file: &SensorFile) -> Result<Sensor, Error> {
    let needs = |given: bool, key: &str, rule: &str, help: &str| {
        let at = format!("effect.sensor.{key}");
        if given { Err(document.fault(&at, format!("`{at}` {rule}"), help)) } else { Ok(()) }
    };
    let electrons = [
        ("shot_noise", file.shot_noise == Some(true)),
        ("dark_e", file.dark_e.is_some()),
        ("dsnu_e", file.dsnu_e.is_some()),
        ("read_noise_e", file.read_noise_e.is_some()),
        ("full_well_e", file.full_well_e.is_some()),
        ("gain_dn_per_e", file.gain_dn_per_e.is_some()),
    ];
    for (key, given) in electrons {
        let rule = "is about electrons, and the scene does not say how many light frees";
        needs(given && file.white_e.is_none(), key, rule, "add `white_e`, the electrons of radiance 1")?;
    }
    for (key, given) in
        [("gain_dn_per_e", file.gain_dn_per_e.is_some()), ("black_level_dn", file.black_level_dn.is_some())]
    {
        let rule = "is about the numbers of a converter, and the scene has none";
        needs(given && file.adc_bits.is_none(), key, rule, "add `adc_bits`")?;
    }
    for (key, given) in [("transmission", file.transmission.is_some()), ("demosaic", file.demosaic.is_some())] {
        let rule = "is about colour filters, and the scene has none";
        needs(given && file.bayer.is_none(), key, rule, "add `bayer`, such as \"rggb\"")?;
    }
    let white_e = file.white_e.unwrap_or(1.0);
    let full_well_e = file.full_well_e.unwrap_or(f64::INFINITY);
    let adc = file.adc_bits.map(|bits| adc(file, bits, if full_well_e.is_finite() { full_well_e } else { white_e }));
    if let Some(adc) = &adc {
        rules::black_below_white(document, adc)?;
    }
    Ok(Sensor {
        seed: file.seed.into(),
        frame: file.frame,
        fill_factor: file.fill_factor,
        bayer: file.bayer.map(|order| bayer(file, order)),
        white_e,
        prnu: file.prnu,
        dark_e: file.dark_e.unwrap_or(0.0),
        shot_noise: file.shot_noise.unwrap_or(file.white_e.is_some()),
        full_well_e,
        dsnu_e: file.dsnu_e.unwrap_or(0.0),
        read_noise_e: file.read_noise_e.unwrap_or(0.0),
        adc,
        gamma: file.gamma,
    })
}

fn adc(file: &SensorFile, bits: u32, largest_e: f64) -> Adc {
    let black_level_dn = file.black_level_dn.unwrap_or(0.0);
    let unit = Adc { bits, gain_dn_per_e: 1.0, black_level_dn };
    let gain_dn_per_e = file.gain_dn_per_e.unwrap_or((unit.largest_dn() - black_level_dn) / largest_e);
    Adc { gain_dn_per_e, ..unit }
}

fn bayer(file: &SensorFile, order: BayerFile) -> Bayer {
    let order = match order {
        BayerFile::Rggb => Order::Rggb,
        BayerFile::Bggr => Order::Bggr,
        BayerFile::Grbg => Order::Grbg,
        BayerFile::Gbrg => Order::Gbrg,
    };
    let demosaic = match file.demosaic {
        Some(DemosaicFile::Bilinear) => Demosaic::Bilinear,
        Some(DemosaicFile::Raw) | None => Demosaic::Raw,
    };
    Bayer { order, transmission: file.transmission.unwrap_or([1.0; 3]), demosaic }
}
