//! Transfer curves: how a stored value in [0, 1] stands for linear light.

use super::pixels::Raster;
use serde::Serialize;

/// A transfer curve that may be stated for a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Transfer {
    /// The stored value is the light.
    Linear,
    /// The piecewise curve of IEC 61966-2-1:1999.
    Srgb,
}

impl Transfer {
    /// The stored value in [0, 1] of `light` in [0, 1].
    pub fn encode(self, light: f64) -> f64 {
        match self {
            Self::Linear => light,
            Self::Srgb if light <= 0.003_130_8 => 12.92 * light,
            Self::Srgb => 1.055 * libm::pow(light, 1.0 / 2.4) - 0.055,
        }
    }

    /// The light in [0, 1] of the stored `value` in [0, 1].
    pub fn decode(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Srgb if value <= 0.040_45 => value / 12.92,
            Self::Srgb => libm::pow((value + 0.055) / 1.055, 2.4),
        }
    }

    /// The name used in metadata and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Srgb => "sRGB",
        }
    }
}

/// Luminance of linear-light red, green and blue with the primaries of Rec. ITU-R BT.709, which sRGB shares. The
/// weights sum to 1, so that grey is kept.
pub fn luminance(red: f64, green: f64, blue: f64) -> f64 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// Linear light of a picture whose values were coded as light^(1 / gamma); what is negative, as noise may be, is 0.
pub fn decoded(picture: &Raster<f32>, gamma: f64) -> Raster<f32> {
    by_value(picture, |value| libm::pow(f64::from(value.max(0.0)), gamma) as f32)
}

/// `of` each value of a picture. A file of 8 or 16 bits holds few values, over and over: what was worked out for one is kept until
/// another takes its place.
pub fn by_value(picture: &Raster<f32>, of: impl Fn(f32) -> f32) -> Raster<f32> {
    const PLACES: usize = 1 << 16;
    let mut known = vec![(0.0f32, of(0.0)); PLACES];
    let one = |&value: &f32| {
        // A cast makes 0 of what is below it, and of no number.
        let place = ((value * (PLACES - 1) as f32 + 0.5) as usize).min(PLACES - 1);
        let (own, result) = &mut known[place];
        if own.to_bits() != value.to_bits() {
            (*own, *result) = (value, of(value));
        }
        *result
    };
    Raster::from_data(picture.width(), picture.height(), picture.data().iter().map(one).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light and stored value from elsewhere: 0.18 from the tests of colour-science (eotf_inverse_sRGB), the thresholds
    /// as printed in IEC 61966-2-1, 8-bit 128 and 188 worked with 50 digits in Python's `decimal`.
    #[test]
    fn srgb_agrees_with_published_pairs() {
        let pairs = [
            (0.0, 0.0, 0.0),
            (0.003_130_8, 0.040_45, 1e-6),
            (0.18, 0.461_356_129_500_442, 1e-14),
            (0.215_860_500_113_899_26, 128.0 / 255.0, 1e-14),
            (0.502_886_458_032_568_7, 188.0 / 255.0, 1e-14),
            (1.0, 1.0, 1e-15),
        ];
        for (light, value, tolerance) in pairs {
            assert!((Transfer::Srgb.encode(light) - value).abs() <= tolerance, "{light}");
            assert!((Transfer::Srgb.decode(value) - light).abs() <= tolerance, "{value}");
        }
    }

    /// Values that share a place, are below 0, beyond 1 or no numbers, and 0 of either sign.
    #[test]
    fn what_is_kept_of_a_value_is_that_values() {
        let values = [0.0, -0.0, 0.25, 0.250_000_03, 0.25, -3.0, 0.0, 7.5, f32::NAN, 1.0, f32::INFINITY, 2e-6, 0.0];
        let of = |value: f32| 1.0 / value + 3.0 * value;
        let found = by_value(&Raster::from_data(values.len(), 1, values.to_vec()), of);
        let bits: Vec<u32> = found.data().iter().map(|v| v.to_bits()).collect();
        assert_eq!(bits, values.map(|v| of(v).to_bits()));
    }

    #[test]
    fn every_16_bit_value_survives_the_way_through_f32_light() {
        for transfer in [Transfer::Linear, Transfer::Srgb] {
            for k in 0..=65535u16 {
                let light = transfer.decode(f64::from(k) / 65535.0) as f32;
                let back = (transfer.encode(f64::from(light)) * 65535.0).round();
                assert_eq!(back, f64::from(k), "{transfer:?}");
            }
        }
    }
}
