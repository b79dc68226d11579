//! Light by wavelength: lines, bands, illuminants, the response of a sensor, and the few wavelengths that stand for them.

use std::f64::consts::FRAC_1_SQRT_2;

/// The light that a scene is seen by.
#[derive(Debug, Clone, PartialEq)]
pub enum LightSource {
    /// Sharp lines.
    Lines(Vec<SpectralLine>),
    /// The same power at every wavelength of a band.
    Band(WavelengthBand),
    /// A standard illuminant, seen through a band.
    Illuminant(Illuminant, WavelengthBand),
}

/// A sharp line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralLine {
    /// Its wavelength in vacuum, in nm.
    pub wavelength_nm: f64,
    /// Its power, in any unit.
    pub power: f64,
}

/// A stretch of wavelengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WavelengthBand {
    /// Its shortest wavelength, in nm.
    pub from_nm: f64,
    /// Its longest, in nm.
    pub to_nm: f64,
}

/// Illuminants of the CIE (ISO 11664-2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Illuminant {
    /// Incandescent light: a Planckian radiator of 2848 K on the scale of 1931.
    A,
    /// Average daylight.
    D65,
}

/// How strongly a sensor's channels respond to a wavelength.
#[derive(Debug, Clone, PartialEq)]
pub enum Response {
    /// One channel that responds to all wavelengths alike.
    Flat,
    /// Red, green and blue.
    Rgb(Vec<Sensitivity>),
}

/// The response of three channels at one wavelength; between two of them it changes linearly, and beyond the ends it is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity {
    /// The wavelength in nm.
    pub wavelength_nm: f64,
    /// The response of red, green and blue, in any unit.
    pub rgb: [f64; 3],
}

/// A wavelength that stands for a part of the spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectrumNode {
    /// The wavelength in vacuum, in nm.
    pub wavelength_nm: f64,
    /// Its share of what red, green and blue receive; all three are the same where there is one channel.
    pub weights: [f64; 3],
}

/// A channel that receives nothing at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the {} channel responds to no wavelength of the light", ["red", "green", "blue"][*channel])]
pub struct Dark {
    /// The channel: red, green, blue.
    pub channel: usize,
}

/// Wavelengths, in nm, over which [`Illuminant::D65`] and the shipped responses are given.
pub const VISIBLE_NM: WavelengthBand = WavelengthBand { from_nm: 380.0, to_nm: 780.0 };

/// CIE standard illuminant D65, relative power from 380 to 780 nm at every 10 nm (CIE 15:2018, Table 1; ISO 11664-2), which
/// is linear in between by its definition.
const D65: [f64; 41] = [
    49.9755, 54.6482, 82.7549, 91.486, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811, 109.354,
    107.802, 104.79, 107.689, 104.405, 104.046, 100.0, 96.3342, 95.788, 88.6856, 90.0062, 89.5991, 87.6987, 83.2886,
    83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.349, 61.604, 69.8856, 75.087, 63.5927, 46.4182,
    66.8054, 63.3828,
];

/// Red, green and blue of the Nikon D5100 as measured at the NPL, from 400 to 700 nm at every 10 nm, each of largest value
/// 1 at its peak on the finer grid of the source (Darrodi, Finlayson, Goodman & Mackiewicz, J. Opt. Soc. Am. A 32 (2015)
/// 381).
const NIKON_D5100: [[f64; 3]; 31] = [
    [0.0000, 0.0000, 0.0015],
    [0.0029, 0.0013, 0.0166],
    [0.0496, 0.0650, 0.3617],
    [0.0766, 0.1371, 0.7553],
    [0.0613, 0.1686, 0.8749],
    [0.0489, 0.1960, 0.9631],
    [0.0402, 0.2542, 1.0000],
    [0.0476, 0.3735, 0.9890],
    [0.0528, 0.4597, 0.9050],
    [0.0479, 0.4889, 0.7515],
    [0.0502, 0.6165, 0.5671],
    [0.0637, 0.8010, 0.3941],
    [0.1004, 0.9389, 0.2498],
    [0.1236, 1.0000, 0.1616],
    [0.0763, 0.9615, 0.1100],
    [0.0412, 0.8891, 0.0653],
    [0.0425, 0.7763, 0.0341],
    [0.1118, 0.6358, 0.0198],
    [0.5645, 0.4928, 0.0138],
    [0.9810, 0.3518, 0.0100],
    [0.9631, 0.2117, 0.0065],
    [0.8343, 0.1180, 0.0037],
    [0.7037, 0.0701, 0.0040],
    [0.5708, 0.0473, 0.0040],
    [0.4383, 0.0353, 0.0055],
    [0.3430, 0.0268, 0.0060],
    [0.2377, 0.0203, 0.0061],
    [0.0913, 0.0094, 0.0030],
    [0.0206, 0.0029, 0.0008],
    [0.0054, 0.0009, 0.0003],
    [0.0013, 0.0004, 0.0002],
];

impl Illuminant {
    /// Its relative power at a wavelength, 100 at 560 nm; the nearest end beyond [`VISIBLE_NM`] for D65.
    pub fn power(self, wavelength_nm: f64) -> f64 {
        match self {
            Self::A => {
                // The constants of the definition (ISO 11664-2), not today's.
                let exponent = |nm: f64| libm::expm1(1.435e7 / (2848.0 * nm));
                let ratio = 560.0 / wavelength_nm;
                100.0 * (ratio * ratio * ratio * ratio * ratio) * exponent(560.0) / exponent(wavelength_nm)
            }
            Self::D65 => {
                let place = ((wavelength_nm - 380.0) / 10.0).clamp(0.0, 40.0);
                let below = (place as usize).min(39);
                D65[below] + (D65[below + 1] - D65[below]) * (place - below as f64)
            }
        }
    }
}

impl Response {
    /// Red, green and blue of a consumer camera, the Nikon D5100.
    pub fn nikon_d5100() -> Self {
        let row = |(k, rgb): (usize, &[f64; 3])| Sensitivity { wavelength_nm: 400.0 + 10.0 * k as f64, rgb: *rgb };
        Self::Rgb(NIKON_D5100.iter().enumerate().map(row).collect())
    }

    /// What the three channels give at a wavelength.
    pub fn at(&self, wavelength_nm: f64) -> [f64; 3] {
        let Self::Rgb(rows) = self else { return [1.0; 3] };
        let after = rows.partition_point(|row| row.wavelength_nm < wavelength_nm);
        match (after.checked_sub(1).and_then(|k| rows.get(k)), rows.get(after)) {
            (_, Some(b)) if b.wavelength_nm == wavelength_nm => b.rgb,
            (Some(a), Some(b)) => {
                let share = (wavelength_nm - a.wavelength_nm) / (b.wavelength_nm - a.wavelength_nm);
                [0, 1, 2].map(|c| a.rgb[c] + (b.rgb[c] - a.rgb[c]) * share)
            }
            _ => [0.0; 3],
        }
    }
}

impl LightSource {
    /// The wavelengths between which all of the light lies.
    pub fn band(&self) -> WavelengthBand {
        match self {
            Self::Lines(lines) => {
                lines.iter().fold(WavelengthBand { from_nm: f64::INFINITY, to_nm: f64::NEG_INFINITY }, |band, line| {
                    WavelengthBand {
                        from_nm: band.from_nm.min(line.wavelength_nm),
                        to_nm: band.to_nm.max(line.wavelength_nm),
                    }
                })
            }
            Self::Band(band) | Self::Illuminant(_, band) => *band,
        }
    }

    fn power(&self, wavelength_nm: f64) -> f64 {
        match self {
            Self::Illuminant(illuminant, _) => illuminant.power(wavelength_nm),
            Self::Lines(_) | Self::Band(_) => 1.0,
        }
    }
}

/// The wavelengths that stand for `light` as a sensor of `response` sees it: one for every line; for a band `count` (at
/// least 1), each standing for an equal stretch of it. Each channel's weights add up to 1, so that a white board is white.
///
/// A stretch is stood for by the mean of its wavelengths, weighed as the channels together receive them, and has exactly
/// the weight that it has in each channel: a picture that changes linearly over each stretch is summed without error where
/// there is one channel, and the error of any smooth one falls as the square of the count.
///
/// # Errors
/// [`Dark`] when a channel receives nothing.
pub fn nodes(light: &LightSource, response: &Response, count: usize) -> Result<Vec<SpectrumNode>, Dark> {
    let parts: Vec<Part> = match light {
        LightSource::Lines(lines) => {
            let part = |line: &SpectralLine| {
                let power = response.at(line.wavelength_nm).map(|r| r * line.power);
                Part { power, moment: power.map(|p| p * line.wavelength_nm), middle_nm: line.wavelength_nm }
            };
            lines.iter().map(part).collect()
        }
        LightSource::Band(band) | LightSource::Illuminant(_, band) => {
            let cuts = cuts(light, response);
            let count = count.max(1);
            let end = |k: usize| band.from_nm + (band.to_nm - band.from_nm) * (k as f64 / count as f64);
            (0..count).map(|k| part(light, response, &cuts, end(k), end(k + 1))).collect()
        }
    };
    let mut total = [0.0; 3];
    for part in &parts {
        (0..3).for_each(|c| total[c] += part.power[c]);
    }
    if let Some(channel) = (0..3).find(|&c| total[c].partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater)) {
        return Err(Dark { channel });
    }
    let node = |part: Part| {
        let share = |values: [f64; 3]| -> f64 { (0..3).map(|c| values[c] / total[c]).sum() };
        let (power, moment) = (share(part.power), share(part.moment));
        let wavelength_nm = if power > 0.0 { moment / power } else { part.middle_nm };
        SpectrumNode { wavelength_nm, weights: [0, 1, 2].map(|c| part.power[c] / total[c]) }
    };
    Ok(parts.into_iter().map(node).collect())
}

/// What each channel receives from a part of the spectrum, and that times its wavelength in nm.
struct Part {
    power: [f64; 3],
    moment: [f64; 3],
    middle_nm: f64,
}

/// Wavelengths at which light or response change their slope.
fn cuts(light: &LightSource, response: &Response) -> Vec<f64> {
    let mut cuts: Vec<f64> = match light {
        // A is smooth: its cuts keep the stretches short.
        LightSource::Illuminant(..) => (20..=250).map(|k| 10.0 * f64::from(k)).collect(),
        LightSource::Lines(_) | LightSource::Band(_) => Vec::new(),
    };
    if let Response::Rgb(rows) = response {
        cuts.extend(rows.iter().map(|row| row.wavelength_nm));
    }
    cuts.sort_by(f64::total_cmp);
    cuts
}

/// The integrals over one stretch, cut where the integrand has kinks; between them a moment is a cubic, for which two Gauss
/// points are exact, and illuminant A is off by less than 1e-8 of itself from 380 nm on.
fn part(light: &LightSource, response: &Response, cuts: &[f64], from_nm: f64, to_nm: f64) -> Part {
    let mut part = Part { power: [0.0; 3], moment: [0.0; 3], middle_nm: 0.5 * (from_nm + to_nm) };
    let inner = cuts.iter().copied().filter(|nm| *nm > from_nm && *nm < to_nm);
    let mut start = from_nm;
    for end in inner.chain([to_nm]) {
        let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
        // +- 1 / sqrt(3)
        for side in [-1.0, 1.0] {
            let nm = middle + side * half * (FRAC_1_SQRT_2 * (2.0f64 / 3.0).sqrt());
            let power = light.power(nm) * half;
            for (c, seen) in response.at(nm).into_iter().enumerate() {
                part.power[c] += seen * power;
                part.moment[c] += seen * power * nm;
            }
        }
        start = end;
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: WavelengthBand = WavelengthBand { from_nm: 400.0, to_nm: 700.0 };

    /// CIE 15:2018, Table 1.
    #[test]
    fn illuminants_have_their_tabulated_values() {
        for (nm, a, d65) in [
            (380.0, 9.7951, 49.9755),
            (445.0, 30.8508, 110.936),
            (560.0, 100.0, 100.0),
            (625.0, 147.235, 85.4936),
            (780.0, 241.675, 63.3828),
        ] {
            assert!((Illuminant::A.power(nm) - a).abs() < 1e-5 * a, "{nm}: {}", Illuminant::A.power(nm));
            assert!((Illuminant::D65.power(nm) - d65).abs() < 1e-5 * d65, "{nm}: {}", Illuminant::D65.power(nm));
        }
    }

    #[test]
    fn weights_add_up_to_one_and_wavelengths_rise() {
        for light in [
            LightSource::Band(WHOLE),
            LightSource::Illuminant(Illuminant::A, WHOLE),
            LightSource::Illuminant(Illuminant::D65, WHOLE),
        ] {
            for response in [Response::Flat, Response::nikon_d5100()] {
                for count in [1, 2, 7, 64] {
                    let nodes = nodes(&light, &response, count).expect("all channels see the whole band");
                    assert_eq!(nodes.len(), count);
                    for c in 0..3 {
                        let sum: f64 = nodes.iter().map(|n| n.weights[c]).sum();
                        assert!((sum - 1.0).abs() < 1e-14);
                    }
                    assert!(nodes.windows(2).all(|w| w[0].wavelength_nm < w[1].wavelength_nm));
                }
            }
        }
    }

    /// A linear picture is summed exactly, with one wavelength or with many.
    #[test]
    fn one_wavelength_has_the_mean_of_the_light() {
        let light = LightSource::Illuminant(Illuminant::D65, WHOLE);
        let mean = |count| -> f64 {
            let nodes = nodes(&light, &Response::Flat, count).expect("light");
            nodes.iter().map(|n| n.weights[1] * n.wavelength_nm).sum()
        };
        assert!((mean(1) - mean(1000)).abs() < 1e-10);
        // Of an even band it is the middle.
        let even = nodes(&LightSource::Band(WHOLE), &Response::Flat, 1).expect("light");
        assert!((even[0].wavelength_nm - 550.0).abs() < 1e-12);
    }

    /// A picture that bends over the wavelengths: the error falls by four when the count doubles.
    #[test]
    fn the_error_falls_as_the_square_of_the_count() {
        let light = LightSource::Illuminant(Illuminant::D65, WHOLE);
        let response = Response::nikon_d5100();
        let seen = |count, c: usize| -> f64 {
            let nodes = nodes(&light, &response, count).expect("light");
            nodes.iter().map(|n| n.weights[c] * libm::sin(n.wavelength_nm / 40.0)).sum()
        };
        for c in 0..3 {
            let exact = seen(1 << 14, c);
            let error = |count| (seen(count, c) - exact).abs();
            // From 64 on a stretch is shorter than the tables' own steps.
            let order = libm::log2(error(64) / error(512)) / 3.0;
            assert!((order - 2.0).abs() < 0.2, "channel {c}: order {order}");
        }
    }

    #[test]
    fn lines_keep_their_places_and_powers() {
        let lines = [(486.1, 1.0), (587.6, 3.0)].map(|(wavelength_nm, power)| SpectralLine { wavelength_nm, power });
        let light = LightSource::Lines(lines.to_vec());
        let n = nodes(&light, &Response::Flat, 9).expect("light");
        assert_eq!(n.iter().map(|n| n.weights[0]).collect::<Vec<_>>(), [0.25, 0.75]);
        assert!((n[0].wavelength_nm - 486.1).abs() < 1e-12 && (n[1].wavelength_nm - 587.6).abs() < 1e-12);
        assert_eq!(light.band(), WavelengthBand { from_nm: 486.1, to_nm: 587.6 });
    }

    #[test]
    fn colours_fall_into_their_channels() {
        for (nm, channel) in [(460.0, 2), (530.0, 1), (610.0, 0)] {
            let seen = Response::nikon_d5100().at(nm);
            assert!((0..3).all(|c| seen[c] <= seen[channel]), "{nm}: {seen:?}");
        }
        assert_eq!(Response::nikon_d5100().at(900.0), [0.0; 3]);
        assert_eq!(Response::nikon_d5100().at(399.0), [0.0; 3]);
        assert_eq!(Response::nikon_d5100().at(700.0), [0.0013, 0.0004, 0.0002]);
        assert_eq!(Response::nikon_d5100().at(400.0), [0.0, 0.0, 0.0015]);
    }

    #[test]
    fn a_channel_in_the_dark_is_named() {
        let infrared = LightSource::Band(WavelengthBand { from_nm: 800.0, to_nm: 900.0 });
        assert_eq!(nodes(&infrared, &Response::nikon_d5100(), 4), Err(Dark { channel: 0 }));
        assert_eq!(Dark { channel: 2 }.to_string(), "the blue channel responds to no wavelength of the light");
    }
}
