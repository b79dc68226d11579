//! Shifts of the pattern's lines between two pictures, from their pixels, without a detector.

use crate::raster::Raster;

/// A line is crossed within this many pixels, or it runs along the row and says nothing of its place across it.
const WIDEST: usize = 5;
/// Pixels within this share of the contrast are of one colour.
const PLAIN: f32 = 1e-3;

/// At each place where a row or a column of the reference goes from one colour to the other: how far along it the line
/// between them has moved in `picture`, in px, by the integral of the difference over the contrast.
pub(super) fn line_shifts(picture: &Raster<f32>, reference: &Raster<f32>, contrast: f64) -> Vec<f64> {
    let (width, height) = (reference.width(), reference.height());
    let mut shifts = Vec::new();
    let rows = (0..height).map(|j| (j * width, 1, width));
    let columns = (0..width).map(|i| (i, width, height));
    for (start, step, count) in rows.chain(columns) {
        let at = |raster: &Raster<f32>, k: usize| raster.data()[start + k * step];
        along(count, |k| at(picture, k), |k| at(reference, k), contrast, &mut shifts);
    }
    shifts
}

/// The crossings of one row or column of `count` pixels.
fn along(
    count: usize,
    picture: impl Fn(usize) -> f32,
    reference: impl Fn(usize) -> f32,
    contrast: f64,
    shifts: &mut Vec<f64>,
) {
    let near = PLAIN * contrast.abs() as f32;
    // A pixel that has the colour of one of its neighbours is a plain one.
    let plain = |k: usize| {
        let same = |other: usize| (reference(k) - reference(other)).abs() <= near;
        (k > 0 && same(k - 1)) || (k + 1 < count && same(k + 1))
    };
    let mut last: Option<usize> = None;
    for k in (0..count).filter(|&k| plain(k)) {
        if let Some(from) = last {
            let step = f64::from(reference(k)) - f64::from(reference(from));
            // From one colour to the other, over a few pixels.
            if k - from <= WIDEST + 1 && (step.abs() - contrast.abs()).abs() <= 2.0 * f64::from(near) {
                let moved: f64 = (from..=k).map(|i| f64::from(reference(i)) - f64::from(picture(i))).sum();
                shifts.push(moved / step);
            }
        }
        last = Some(k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bars of 7.3 px, area-sampled, that begin at `phase`.
    fn bars(phase: f64) -> Raster<f32> {
        let white_before = |x: f64| {
            let u = (x - phase) / 7.3;
            let whole = (u / 2.0).floor();
            7.3 * (whole + (u - 2.0 * whole).min(1.0))
        };
        let row: Vec<f32> = (0..60)
            .map(|i| (0.1 + 0.8 * (white_before(f64::from(i) + 1.0) - white_before(f64::from(i)))) as f32)
            .collect();
        Raster::from_data(60, 2, row.repeat(2))
    }

    #[test]
    fn a_shift_of_bars_is_the_shift_of_every_line() {
        let (before, after) = (bars(0.4), bars(0.43));
        let shifts = line_shifts(&after, &before, 0.8);
        // Two rows of 7 or 8 lines; the columns cross none.
        assert!((12..=16).contains(&shifts.len()), "{}", shifts.len());
        assert!(shifts.iter().all(|s| (s - 0.03).abs() < 1e-6), "{shifts:?}");
        assert!(line_shifts(&before, &before, 0.8).iter().all(|s| *s == 0.0));
    }
}
