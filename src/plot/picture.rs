//! Rasters prepared for a figure: scaled down, cropped, turned into sRGB.

use super::colour::{self, Map, Rgb};
use crate::raster::Raster;

/// The picture at `width` x `height`, each value the mean over the area it covers in the source.
///
/// Values that are not finite are left out of the mean; where nothing is left, the result is NaN. Averaging belongs
/// before any gamma: the values are linear.
pub(crate) fn area_averaged(picture: &Raster<f32>, width: usize, height: usize) -> Raster<f32> {
    let columns = spans(picture.width(), width);
    let rows = spans(picture.height(), height);
    let mean = |row: &Span, column: &Span| {
        let (mut sum, mut area) = (0.0, 0.0);
        for (dy, row_weight) in row.weights.iter().enumerate() {
            let values = &picture.row(row.first + dy)[column.first..];
            for (&value, column_weight) in values.iter().zip(&column.weights) {
                if value.is_finite() {
                    sum += row_weight * column_weight * f64::from(value);
                    area += row_weight * column_weight;
                }
            }
        }
        if area > 0.0 { (sum / area) as f32 } else { f32::NAN }
    };
    let data = rows.iter().flat_map(|row| columns.iter().map(move |column| mean(row, column))).collect();
    Raster::from_data(columns.len(), rows.len(), data)
}

/// The `width` x `height` pixels from (`left`, `top`) on, as far as the picture has them.
pub fn cut_out<T: Copy>(picture: &Raster<T>, left: usize, top: usize, width: usize, height: usize) -> Raster<T> {
    let (right, bottom) = (picture.width().min(left + width), picture.height().min(top + height));
    let (left, top) = (left.min(right), top.min(bottom));
    let data = (top..bottom).flat_map(|j| picture.row(j)[left..right].iter().copied()).collect();
    Raster::from_data(right - left, bottom - top, data)
}

/// Linear grey, 0 black to 1 white, as sRGB; [`colour::MISSING`] for NaN.
pub fn grey(picture: &Raster<f32>) -> Raster<Rgb> {
    let of = |light: f32| if light.is_nan() { colour::MISSING } else { [colour::srgb_from_linear(light.into()); 3] };
    // Much of a picture of a board is of one light.
    let (mut last, mut known) = (0.0, of(0.0));
    let grey = |&light: &f32| {
        if light != last {
            (last, known) = (light, of(light));
        }
        known
    };
    Raster::from_data(picture.width(), picture.height(), picture.data().iter().map(grey).collect())
}

/// Shares of a colour map, 0..=1, as colours; [`colour::MISSING`] for NaN.
pub fn mapped(shares: &Raster<f64>, map: Map) -> Raster<Rgb> {
    shares.map(|share| map.colour(share))
}

/// The source pixels under one target pixel along one axis, with the length of each that is covered.
struct Span {
    first: usize,
    weights: Vec<f64>,
}

fn spans(source: usize, target: usize) -> Vec<Span> {
    if source == 0 {
        return Vec::new();
    }
    let ratio = source as f64 / target as f64;
    let span = |k: usize| {
        let (start, end) = (k as f64 * ratio, ((k + 1) as f64 * ratio).min(source as f64));
        let first = (start as usize).min(source - 1);
        let last = (end.ceil() as usize).clamp(first + 1, source);
        let covered = |i: usize| (end.min(i as f64 + 1.0) - start.max(i as f64)).max(0.0);
        Span { first, weights: (first..last).map(covered).collect() }
    };
    (0..target).map(span).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_keeps_its_mean_at_any_size() {
        let ramp = Raster::from_data(12, 10, (0..120).map(|i| i as f32).collect());
        for (w, h) in [(12, 10), (6, 5), (5, 3), (7, 10), (1, 1), (24, 20)] {
            let small = area_averaged(&ramp, w, h);
            let mean = small.data().iter().map(|&v| f64::from(v)).sum::<f64>() / (w * h) as f64;
            assert!((mean - 59.5).abs() < 1e-4, "{w} x {h}: {mean}");
        }
        assert_eq!(area_averaged(&ramp, 12, 10), ramp);
    }

    #[test]
    fn two_to_three_takes_thirds() {
        // Three target pixels of 2/3 source pixel each: 0, half of each, 6.
        let pair = Raster::from_data(2, 1, vec![0.0, 6.0]);
        let data = area_averaged(&pair, 3, 1);
        assert!(data.data().iter().zip([0.0, 3.0, 6.0]).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-6), "{data:?}");
    }

    #[test]
    fn a_bright_pixel_keeps_its_light() {
        // Of five pixels the second is bright; three targets cover 5/3 each: the first 2/3 of it, the second 1/3.
        let five = Raster::from_data(5, 1, vec![0.0, 1.0, 0.0, 0.0, 0.0]);
        let data = area_averaged(&five, 3, 1);
        assert!(data.data().iter().zip([0.4, 0.2, 0.0]).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-6), "{data:?}");
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let holes = Raster::from_data(4, 1, vec![f32::NAN, 1.0, f32::NAN, f32::INFINITY]);
        let half = area_averaged(&holes, 2, 1);
        assert_eq!(half.get(0, 0), 1.0);
        assert!(half.get(1, 0).is_nan());
        assert_eq!(grey(&half).get(1, 0), colour::MISSING);
    }

    #[test]
    fn an_empty_picture_stays_empty() {
        assert!(area_averaged(&Raster::from_data(0, 0, Vec::new()), 5, 5).data().is_empty());
        assert!(cut_out(&Raster::filled(4, 4, 1u8), 7, 9, 3, 3).data().is_empty());
    }

    #[test]
    fn a_cut_is_where_it_says() {
        let numbers = Raster::from_data(4, 3, (0..12).collect::<Vec<i32>>());
        assert_eq!(cut_out(&numbers, 1, 1, 2, 5), Raster::from_data(2, 2, vec![5, 6, 9, 10]));
    }
}
