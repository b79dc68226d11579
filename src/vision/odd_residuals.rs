//! Corners whose fits leave more than those around them: something lies over them, glare or a shadow, which no noise is.
//!
//! What is beyond the noise of the corners around is alike over many pixels. A fit takes it for noise, each pixel for itself, and says
//! too little.

use super::detection::Corner;
use crate::num::stats::quantile;
use std::collections::BTreeMap;

/// A mean square of the residual, as a share of the contrast's, that is above this against the corners around is no chance.
const MORE: f64 = 1.5;
/// What is beyond that is alike over so many pixels: beside bright spots of light of half a square to a square and a half it takes 11.
const ALIKE_PX: f64 = 12.0;
/// How far the corners around one reach, in steps, and how many are needed.
const AROUND: i32 = 2;
const LEAST_AROUND: usize = 3;

/// Widens the covariances of the corners that are less like the model than those around them.
pub(super) fn widen_unlike(corners: &mut [Corner]) {
    let relative: BTreeMap<[i32; 2], f64> =
        corners.iter().map(|c| (c.index, (c.residual / c.contrast) * (c.residual / c.contrast))).collect();
    for corner in corners {
        let around: Vec<f64> = (-AROUND..=AROUND)
            .flat_map(|i| (-AROUND..=AROUND).map(move |j| [i, j]))
            .filter(|offset| *offset != [0, 0])
            .filter_map(|[i, j]| relative.get(&[corner.index[0] + i, corner.index[1] + j]).copied())
            .collect();
        let Some(typical) = quantile(&around, 0.5).filter(|_| around.len() >= LEAST_AROUND) else { continue };
        let share = 1.0 - MORE * typical / relative[&corner.index];
        if share > 0.0 {
            corner.covariance_px2 *= 1.0 + (ALIKE_PX - 1.0) * share;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::Polarity;
    use glam::{DMat2, DVec2};

    #[test]
    fn a_corner_under_glare_is_widened_and_a_dark_one_is_not() {
        let corner = |i: i32, j: i32| Corner {
            position_px: DVec2::new(40.0 * f64::from(i), 40.0 * f64::from(j)),
            index: [i, j],
            covariance_px2: DMat2::IDENTITY,
            // Light that falls over the board takes contrast and residual with it.
            contrast: 0.8 * libm::exp(-0.5 * f64::from(i)),
            residual: 0.01 * libm::exp(-0.5 * f64::from(i)),
            polarity: Polarity::Main,
        };
        let mut corners: Vec<Corner> = (0..5).flat_map(|i| (0..4).map(move |j| corner(i, j))).collect();
        corners[9].residual *= 3.0;
        widen_unlike(&mut corners);
        for (k, corner) in corners.iter().enumerate() {
            // Of nine times the square one and a half are taken for noise.
            let expected = if k == 9 { 1.0 + 11.0 * (7.5 / 9.0) } else { 1.0 };
            assert!((corner.covariance_px2.x_axis.x - expected).abs() < 1e-9, "{k} {corner:?}");
        }
    }
}
