//! Two pictures, value by value: how far apart, where most, and a strip that shows it.

use super::pixels::Raster;
use super::transfer::Transfer;
use crate::error::Error;
use crate::num::stats;
use image::{GrayImage, Luma};
use imageproc::region_labelling::{Connectivity, connected_components};
use serde::Serialize;
use std::collections::BTreeMap;

/// How far an actual picture is from the expected one. Differences are actual minus expected, in linear light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// Pixels of each picture.
    pub pixels: usize,
    /// Pixels whose values are not equal; 0 means that the pictures are the same to the last bit (but for a zero's
    /// sign).
    pub differing: usize,
    /// Pixels whose values lie further apart than `threshold`, with those where just one value is no finite number.
    pub over_threshold: usize,
    /// The largest difference that is let pass.
    pub threshold: f64,
    /// Largest magnitude of a difference, among finite values.
    pub max_abs: f64,
    /// Root of the mean square difference over all finite pairs.
    pub rms: f64,
    /// Column and row of the pixel that is furthest off; none when all are equal.
    pub worst_px: Option<[usize; 2]>,
    /// Pairs that cannot be subtracted, since one value is not finite and the other is another value.
    pub not_finite: usize,
    /// Connected regions of pixels over the threshold, the largest first, ten at most.
    pub regions: Vec<ConnectedRegion>,
}

/// A connected region of a picture.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ConnectedRegion {
    /// Its pixels.
    pub pixels: usize,
    /// First column and row of its bounding box.
    pub first_px: [usize; 2],
    /// Last column and row of its bounding box.
    pub last_px: [usize; 2],
}

impl Difference {
    /// Whether no pixel is over the threshold.
    pub fn passes(&self) -> bool {
        self.over_threshold == 0
    }
}

/// Compares two pictures of the same size; a `threshold` of 0 demands equality.
///
/// # Errors
/// Pictures of different sizes.
pub fn compare(expected: &Raster<f32>, actual: &Raster<f32>, threshold: f64) -> Result<Difference, Error> {
    if (expected.width(), expected.height()) != (actual.width(), actual.height()) {
        let size = |picture: &Raster<f32>| format!("{} x {}", picture.width(), picture.height());
        let rule = format!("the pictures are {} and {} px, and must have one size", size(expected), size(actual));
        return Err(Error::new("the pictures to compare", rule, "compare pictures of one sensor"));
    }
    let mut found = Difference {
        pixels: expected.data().len(),
        differing: 0,
        over_threshold: 0,
        threshold,
        max_abs: 0.0,
        rms: 0.0,
        worst_px: None,
        not_finite: 0,
        regions: Vec::new(),
    };
    // One column and row more on every side: the labelling wants room for its labels on the smallest pictures.
    let mut over = GrayImage::new(expected.width() as u32 + 2, expected.height() as u32 + 2);
    // A pair that cannot be subtracted is further off than any that can.
    let mut worst = 0.0;
    let mut finite = Vec::with_capacity(found.pixels);
    for (index, (&a, &b)) in expected.data().iter().zip(actual.data()).enumerate() {
        let difference = f64::from(b) - f64::from(a);
        let same = a == b || a.to_bits() == b.to_bits();
        let size = if same {
            0.0
        } else if difference.is_finite() {
            difference.abs()
        } else {
            f64::INFINITY
        };
        found.differing += usize::from(!same);
        found.over_threshold += usize::from(size > threshold);
        let (column, row) = (index % expected.width(), index / expected.width());
        over.put_pixel(column as u32 + 1, row as u32 + 1, Luma([u8::from(size > threshold)]));
        if size.is_finite() {
            finite.push(size);
        } else {
            found.not_finite += 1;
        }
        if size > worst {
            worst = size;
            found.worst_px = Some([column, row]);
        }
    }
    found.max_abs = stats::max_abs(&finite);
    found.rms = stats::rms(&finite);
    found.regions = regions(&over);
    Ok(found)
}

/// The regions of pixels that are not 0, corners counted as neighbours, in a picture with a border of one pixel.
fn regions(over: &GrayImage) -> Vec<ConnectedRegion> {
    let labels = connected_components(over, Connectivity::Eight, Luma([0]));
    let mut found: BTreeMap<u32, ConnectedRegion> = BTreeMap::new();
    for (x, y, Luma([label])) in labels.enumerate_pixels().filter(|(_, _, pixel)| pixel.0 != [0]) {
        let px = [x as usize - 1, y as usize - 1];
        let region = found.entry(*label).or_insert(ConnectedRegion { pixels: 0, first_px: px, last_px: px });
        region.pixels += 1;
        region.first_px = std::array::from_fn(|axis| region.first_px[axis].min(px[axis]));
        region.last_px = std::array::from_fn(|axis| region.last_px[axis].max(px[axis]));
    }
    let mut regions: Vec<ConnectedRegion> = found.into_values().collect();
    regions.sort_by_key(|r| std::cmp::Reverse(r.pixels));
    regions.truncate(10);
    regions
}

/// `expected | difference | actual`, side by side as an sRGB figure.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonStrip {
    /// The figure.
    pub figure: Raster<[u8; 3]>,
    /// What a difference is multiplied by. The colour goes from white (none) to full red (actual brighter) or full
    /// blue (actual darker) at a multiplied difference of 1; 0 when the pictures are the same.
    pub gain: f64,
}

/// The panels of a strip are apart by this many columns.
const GAP_PX: usize = 4;

/// What lies between the panels, and where a picture has no pixel.
const MID_GREY: [u8; 3] = [128; 3];

/// Draws the strip of two pictures, which may differ in size; pixels of only one of them show no difference.
pub fn strip(expected: &Raster<f32>, actual: &Raster<f32>) -> ComparisonStrip {
    let (width, height) = (expected.width().max(actual.width()), expected.height().max(actual.height()));
    let difference = |i: usize, j: usize| Some(f64::from(at(actual, i, j)?) - f64::from(at(expected, i, j)?));
    let pixels = || (0..height).flat_map(move |j| (0..width).map(move |i| (i, j)));
    let largest =
        pixels().filter_map(|(i, j)| difference(i, j)).filter(|d| d.is_finite()).fold(0.0, |m: f64, d| m.max(d.abs()));
    let gain = if largest > 0.0 { 1.0 / largest } else { 0.0 };

    let step = width + GAP_PX;
    let mut figure = Raster::filled(2 * step + width, height, MID_GREY);
    for (i, j) in pixels() {
        let panels = [
            at(expected, i, j).map(grey),
            difference(i, j).map(|difference| signed(difference * gain)),
            at(actual, i, j).map(grey),
        ];
        for (panel, colour) in panels.into_iter().enumerate() {
            let row = j * figure.width();
            figure.data_mut()[row + panel * step + i] = colour.unwrap_or(MID_GREY);
        }
    }
    ComparisonStrip { figure, gain }
}

fn at(picture: &Raster<f32>, i: usize, j: usize) -> Option<f32> {
    (i < picture.width() && j < picture.height()).then(|| picture.get(i, j))
}

/// Linear light as an sRGB grey.
fn grey(light: f32) -> [u8; 3] {
    [(Transfer::Srgb.encode(f64::from(light.clamp(0.0, 1.0))) * 255.0).round() as u8; 3]
}

/// White at 0, red at 1 and above, blue at -1 and below, black where there is no number.
fn signed(difference: f64) -> [u8; 3] {
    if difference.is_nan() {
        return [0; 3];
    }
    let fade = (255.0 * (1.0 - difference.abs().min(1.0))).round() as u8;
    if difference > 0.0 { [255, fade, fade] } else { [fade, fade, 255] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(values: &[f32]) -> Raster<f32> {
        Raster::from_data(values.len(), 1, values.to_vec())
    }

    #[test]
    fn differences_are_measured_and_placed() {
        let found = compare(&row(&[0.0, 0.5, 0.25, 1.0]), &row(&[-0.0, 0.75, 0.25, 0.5]), 0.25).unwrap();
        let expected = Difference {
            pixels: 4,
            differing: 2,
            over_threshold: 1,
            threshold: 0.25,
            max_abs: 0.5,
            // (0.25^2 + 0.5^2) / 4 = 0.3125 / 4
            rms: 0.078_125f64.sqrt(),
            worst_px: Some([3, 0]),
            not_finite: 0,
            regions: vec![ConnectedRegion { pixels: 1, first_px: [3, 0], last_px: [3, 0] }],
        };
        assert_eq!(found, expected);
        assert!(!found.passes());
    }

    #[test]
    fn one_bit_of_one_pixel_is_a_difference() {
        let expected = Raster::filled(100, 80, 0.3f32);
        let mut actual = expected.clone();
        assert_eq!(compare(&expected, &actual, 0.0).unwrap().differing, 0);
        actual.data_mut()[7 * 100 + 42] = 0.3f32.next_up();
        let found = compare(&expected, &actual, 0.0).unwrap();
        assert_eq!((found.differing, found.over_threshold, found.worst_px), (1, 1, Some([42, 7])));
    }

    #[test]
    fn a_value_that_is_no_number_is_the_worst_of_all_unless_it_is_expected() {
        let found = compare(&row(&[0.0, 0.0, f32::NAN]), &row(&[1e30, f32::NAN, f32::NAN]), 1e31).unwrap();
        assert_eq!((found.not_finite, found.over_threshold, found.worst_px), (1, 1, Some([1, 0])));
        assert_eq!(found.max_abs, f64::from(1e30f32));
        let infinite = row(&[f32::INFINITY]);
        assert_eq!(compare(&infinite, &infinite, 0.0).unwrap().differing, 0);
        assert_eq!(compare(&infinite, &infinite.map(|v| -v), 0.0).unwrap().not_finite, 1);
    }

    #[test]
    fn changed_pixels_are_gathered_into_regions() {
        let expected = Raster::filled(20, 10, 0.0f32);
        let mut actual = expected.clone();
        // A diagonal of three, which only touches at corners, and one pixel far from it.
        for at in [2 * 20 + 3, 3 * 20 + 4, 4 * 20 + 5, 8 * 20 + 15] {
            actual.data_mut()[at] = 1.0;
        }
        let found = compare(&expected, &actual, 0.5).unwrap().regions;
        let diagonal = ConnectedRegion { pixels: 3, first_px: [3, 2], last_px: [5, 4] };
        assert_eq!(found, [diagonal, ConnectedRegion { pixels: 1, first_px: [15, 8], last_px: [15, 8] }]);
    }

    #[test]
    fn pictures_of_two_sizes_cannot_be_compared() {
        let problem = compare(&Raster::filled(2, 3, 0.0), &Raster::filled(3, 2, 0.0), 0.0).unwrap_err();
        assert!(problem.rule.contains("2 x 3 and 3 x 2"));
    }

    #[test]
    fn the_strip_shows_sign_and_place_at_full_strength() {
        let strip = strip(&row(&[0.0, 1.0, 0.5, 0.5]), &row(&[0.0, 1.0, 0.502, 0.4985]));
        assert!((strip.gain * 0.002 - 1.0).abs() < 1e-4, "the largest difference is 0.002 to f32 rounding");
        let panel = |k: usize| &strip.figure.row(0)[k * (4 + GAP_PX)..k * (4 + GAP_PX) + 4];
        assert_eq!(&panel(0)[..2], [[0; 3], [255; 3]]);
        assert_eq!(panel(1), [[255; 3], [255; 3], [255, 0, 0], [64, 64, 255]].as_slice());
        assert_eq!(strip.figure.row(0)[4], MID_GREY);
        // Equal pictures: a white panel.
        let same = super::strip(&row(&[0.2]), &row(&[0.2]));
        assert_eq!((same.gain, same.figure.get(1 + GAP_PX, 0)), (0.0, [255; 3]));
    }

    #[test]
    fn a_strip_of_two_sizes_shows_both_whole() {
        let strip = strip(&Raster::filled(2, 3, 1.0), &Raster::filled(3, 2, 1.0));
        assert_eq!((strip.figure.width(), strip.figure.height()), (3 * 3 + 2 * GAP_PX, 3));
        assert_eq!(strip.figure.get(2, 0), MID_GREY);
        assert_eq!(strip.figure.get(0, 2), [255; 3]);
        assert_eq!(strip.figure.get(3 + GAP_PX + 2, 2), MID_GREY);
    }
}
