//! From linear light to the levels of 16-bit samples.

use crate::raster::transfer::Transfer;
use std::sync::LazyLock;

/// The largest level.
const LARGEST: u16 = u16::MAX;
/// From so many values on the table of sRGB takes less time than the curve does, which it is made by.
const LEAST_FOR_TABLE: usize = 1 << 18;
/// Bits of an f32 below those by which the table is entered: a part is a thousandth of its values long.
const PART_BITS: u32 = 13;
/// The curve and its inverse are rounded by far less than this share of the light.
const ROUNDING: f64 = 1e-12;

/// The nearest level of a linear light, clamped to [0, 1].
pub(super) fn level16(light: f32, transfer: Transfer) -> u16 {
    // The cast turns a NaN into 0.
    (transfer.encode(f64::from(light.clamp(0.0, 1.0))) * f64::from(LARGEST)).round() as u16
}

/// How many values are taken at a time.
pub(super) const PIECE: usize = 1 << 14;

/// The bytes of the nearest levels of a piece of `of` values in all, the larger byte first, as [`level16`] has them.
pub(super) fn levels16(light: &[f32], transfer: Transfer, of: usize) -> Vec<u8> {
    let table = (transfer == Transfer::Srgb && of >= LEAST_FOR_TABLE).then(|| &*TABLE);
    let level = |light: f32| table.map_or_else(|| level16(light, transfer), |table| table.level(light));
    // Much of a picture of a board is of one light.
    let (mut last, mut known) = (0.0f32, [0, 0]);
    let mut bytes = Vec::with_capacity(2 * light.len());
    for &light in light {
        if light.to_bits() != last.to_bits() {
            (last, known) = (light, level(light).to_be_bytes());
        }
        bytes.extend_from_slice(&known);
    }
    bytes
}

static TABLE: LazyLock<SrgbLevels> = LazyLock::new(SrgbLevels::new);

/// The curve of sRGB as the light from which on each level is the nearest one: [`level16`] without its power.
struct SrgbLevels {
    /// Of each level the smallest light that has it or a larger one.
    from: Vec<f32>,
    /// Of each part of the numbers from 0 to 1, and of what follows them, the level of its first.
    first: Vec<u16>,
}

impl SrgbLevels {
    fn new() -> Self {
        let level = |bits: u32| level16(f32::from_bits(bits), Transfer::Srgb);
        let one = 1.0f32.to_bits();

        // Find where each level begins: close to where the curve is halfway from the one below.
        let from = (0..=LARGEST).map(|k| {
            let halfway = (f64::from(k) - 0.5) / f64::from(LARGEST);
            let begins = Transfer::Srgb.decode(halfway.max(0.0));
            let mut bits = (begins as f32).to_bits().min(one);
            // What rounding can make of the curve decides only close to where it is halfway.
            let has = |bits: u32| {
                let off = f64::from(f32::from_bits(bits)) - begins;
                if off.abs() > ROUNDING * begins { off > 0.0 } else { level(bits) >= k }
            };
            while !has(bits) {
                bits += 1;
            }
            while bits > 0 && has(bits - 1) {
                bits -= 1;
            }
            f32::from_bits(bits)
        });
        let from: Vec<f32> = from.collect();

        // Enter it by the leading bits of the light.
        let mut k = 0;
        let first = (0..=(one >> PART_BITS) + 1).map(|part| {
            let start = part << PART_BITS;
            while k < LARGEST && from[usize::from(k) + 1].to_bits() <= start {
                k += 1;
            }
            k
        });
        let first = first.collect();
        Self { from, first }
    }

    fn level(&self, light: f32) -> u16 {
        let light = light.clamp(0.0, 1.0);
        // A NaN has no place among numbers.
        if light.is_nan() {
            return 0;
        }
        // Taken off its sign, -0 is 0.
        let part = (light.abs().to_bits() >> PART_BITS) as usize;
        let [low, high] = [self.first[part], self.first[part + 1]].map(usize::from);
        low as u16 + self.from[low + 1..=high].partition_point(|from| *from <= light) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On both sides of where each level begins, at the seam of the curve, and at light that is none.
    #[test]
    fn the_table_has_the_levels_of_the_curve() {
        let table = &*TABLE;
        let seam = 0.003_130_8f32.to_bits();
        let around = table.from.iter().flat_map(|from| {
            let bits = from.to_bits();
            [bits.saturating_sub(1), bits, bits + 1]
        });
        for light in around.chain(seam - 300..seam + 300).map(f32::from_bits) {
            assert_eq!(table.level(light), level16(light, Transfer::Srgb), "{light:e}");
        }
        for light in [0.0, -0.0, -1.0, 2.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e-40, 1.0 - f32::EPSILON] {
            assert_eq!(table.level(light), level16(light, Transfer::Srgb), "{light:e}");
        }
    }

    /// Everywhere in between: numbers spread evenly over [0, 1], as light and as bits.
    #[test]
    fn many_values_have_the_levels_of_the_curve() {
        let n = LEAST_FOR_TABLE as u32;
        let light: Vec<f32> = (0..n / 2)
            .flat_map(|k| [k as f32 / (n / 2) as f32, f32::from_bits(k * 2 * (1.0f32.to_bits() / n))])
            .collect();
        let expected: Vec<u8> = light.iter().flat_map(|light| level16(*light, Transfer::Srgb).to_be_bytes()).collect();
        assert!(levels16(&light, Transfer::Srgb, light.len()) == expected);
    }
}
