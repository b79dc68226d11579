//! Colours that a colour-blind reader can tell apart, and colour maps.

/// A colour in sRGB, 8 bits a channel.
pub type Rgb = [u8; 3];

/// Paper.
pub const WHITE: Rgb = [255, 255, 255];
/// Lines and letters.
pub const INK: Rgb = [26, 26, 26];
/// Text and lines of second rank.
pub const GREY: Rgb = [100, 100, 100];
/// Grid lines and frames.
pub(crate) const PALE: Rgb = [218, 218, 218];
/// What has no value.
pub const MISSING: Rgb = [235, 235, 235];
/// What a reader shall find first: vermilion, which no colour-blind reader takes for [`INK`] or blue.
pub const ACCENT: Rgb = [213, 94, 0];

/// Colours of series in a chart, most distinct first: the palette of Okabe and Ito (2008), without its yellow, which
/// is too pale on white; then brown, grey, violet and olive.
pub(crate) const SERIES: [Rgb; 11] = [
    [0, 114, 178],
    ACCENT,
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [0, 0, 0],
    [110, 60, 30],
    [140, 140, 140],
    [95, 45, 150],
    [125, 130, 20],
];

/// How a number between 0 and 1 becomes a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Map {
    /// Small to large: viridis, perceptually uniform and readable without colour vision.
    Sequential,
    /// Small to large for dots and thin lines on white: the darker four fifths of viridis, large values darkest.
    Marks,
    /// Negative (blue) over zero (white) to positive (red): RdBu of ColorBrewer, reversed.
    Diverging,
}

impl Map {
    /// The colour at `share`, which is held within 0..=1; [`MISSING`] for NaN.
    pub fn colour(self, share: f64) -> Rgb {
        if share.is_nan() {
            return MISSING;
        }
        let share = share.clamp(0.0, 1.0);
        let (stops, share): (&[Rgb], f64) = match self {
            Self::Sequential => (&VIRIDIS, share),
            Self::Marks => (&VIRIDIS, 0.8 * (1.0 - share)),
            Self::Diverging => (&RED_BLUE, share),
        };
        let at = share * (stops.len() - 1) as f64;
        let low = (at.floor() as usize).min(stops.len() - 2);
        mixed(stops[low], stops[low + 1], at - low as f64)
    }
}

/// The colour `share` of the way from `a` to `b`, in sRGB.
pub fn mixed(a: Rgb, b: Rgb, share: f64) -> Rgb {
    [0, 1, 2].map(|c| (f64::from(a[c]) + (f64::from(b[c]) - f64::from(a[c])) * share).round() as u8)
}

/// The 8-bit sRGB value of a linear intensity, held within 0..=1 (IEC 61966-2-1).
pub fn srgb_from_linear(linear: f64) -> u8 {
    let v = linear.clamp(0.0, 1.0);
    let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

/// Every fifth of the 256 entries of viridis (Smith and van der Walt 2015, CC0, as published with matplotlib); linear
/// in between, which is within one 8-bit step of the whole table.
const VIRIDIS: [Rgb; 52] = [
    [68, 1, 84],
    [70, 8, 92],
    [71, 16, 99],
    [72, 23, 105],
    [72, 29, 111],
    [72, 36, 117],
    [71, 42, 122],
    [70, 48, 126],
    [69, 55, 129],
    [67, 61, 132],
    [65, 66, 135],
    [63, 72, 137],
    [61, 78, 138],
    [58, 83, 139],
    [56, 89, 140],
    [53, 94, 141],
    [51, 99, 141],
    [49, 104, 142],
    [46, 109, 142],
    [44, 113, 142],
    [42, 118, 142],
    [41, 123, 142],
    [39, 128, 142],
    [37, 132, 142],
    [35, 137, 142],
    [33, 142, 141],
    [32, 146, 140],
    [31, 151, 139],
    [30, 156, 137],
    [31, 161, 136],
    [33, 165, 133],
    [36, 170, 131],
    [40, 174, 128],
    [46, 179, 124],
    [53, 183, 121],
    [61, 188, 116],
    [70, 192, 111],
    [80, 196, 106],
    [90, 200, 100],
    [101, 203, 94],
    [112, 207, 87],
    [124, 210, 80],
    [137, 213, 72],
    [149, 216, 64],
    [162, 218, 55],
    [176, 221, 47],
    [189, 223, 38],
    [202, 225, 31],
    [216, 226, 25],
    [229, 228, 25],
    [241, 229, 29],
    [253, 231, 37],
];

/// ColorBrewer's RdBu of 11 classes (Brewer and Harrower, Apache 2.0), from blue to red.
const RED_BLUE: [Rgb; 11] = [
    [5, 48, 97],
    [33, 102, 172],
    [67, 147, 195],
    [146, 197, 222],
    [209, 229, 240],
    [247, 247, 247],
    [253, 219, 199],
    [244, 165, 130],
    [214, 96, 77],
    [178, 24, 43],
    [103, 0, 31],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE 1976 lightness of an sRGB colour.
    fn lightness(colour: Rgb) -> f64 {
        let linear = colour.map(|c| {
            let v = f64::from(c) / 255.0;
            if v <= 0.04045 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) }
        });
        let y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
        116.0 * libm::cbrt(y) - 16.0
    }

    #[test]
    fn sequential_map_rises_evenly_in_lightness() {
        // Viridis was made for an even rise in CAM02-UCS; CIE lightness differs from it by a little, hence the 25 %.
        let steps: Vec<f64> = (0..=20).map(|i| lightness(Map::Sequential.colour(f64::from(i) / 20.0))).collect();
        let mean = (steps[20] - steps[0]) / 20.0;
        assert!(steps.windows(2).all(|pair| (pair[1] - pair[0] - mean).abs() < 0.25 * mean), "{steps:?}");
    }

    #[test]
    fn sequential_map_meets_published_entries() {
        // Entries 0, 64, 128, 192 and 255 of matplotlib's table.
        let published = [(0, [68, 1, 84]), (64, [59, 82, 139]), (128, [33, 145, 140]), (192, [94, 201, 98])];
        for (entry, colour) in published.into_iter().chain([(255, [253, 231, 37])]) {
            let ours = Map::Sequential.colour(f64::from(entry) / 255.0);
            assert!((0..3).all(|c| ours[c].abs_diff(colour[c]) <= 1), "{entry}: {ours:?} {colour:?}");
        }
    }

    #[test]
    fn diverging_map_is_palest_in_the_middle_and_falls_off_evenly() {
        for i in 0..10 {
            let (near, far) = (f64::from(i) / 20.0, f64::from(i + 1) / 20.0);
            for side in [-1.0, 1.0] {
                let at = |d: f64| lightness(Map::Diverging.colour(0.5 + side * d));
                assert!(at(near) > at(far));
            }
        }
    }

    #[test]
    fn out_of_range_and_nan_have_a_colour() {
        assert_eq!(Map::Sequential.colour(-3.0), Map::Sequential.colour(0.0));
        assert_eq!(Map::Sequential.colour(f64::INFINITY), Map::Sequential.colour(1.0));
        assert_eq!(Map::Diverging.colour(f64::NAN), MISSING);
    }

    #[test]
    fn srgb_of_known_intensities() {
        assert_eq!([0.0, 1.0, 0.5, 0.215_861, -1.0, 2.0].map(srgb_from_linear), [0, 255, 188, 128, 0, 255]);
    }
}
