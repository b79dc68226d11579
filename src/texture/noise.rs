//! Noise to match by: octaves of white noise, each smoothed by a Gaussian, so that there is nothing finer than a stated
//! wavelength; drawn by counting from a seed, place by place, so that it is nowhere periodic.

use crate::num::deviates::Stream;
use crate::raster::Raster;
use rayon::prelude::*;

/// Texels to the shortest wavelength.
pub(crate) const TEXELS_A_WAVE: f64 = 4.0;
/// Octaves, each twice as coarse as the one before, of the same variance.
const OCTAVES: u32 = 3;
/// Standard deviation of the finest Gaussian, in texels: half the shortest wavelength, at which it leaves exp(-pi^2) = 5e-5 of
/// the power.
const FINEST: f64 = 0.5 * TEXELS_A_WAVE;
/// The Gaussians end at so many standard deviations.
const REACH: f64 = 4.0;
/// The purpose of the random numbers of the first octave, apart from those of sensors.
const PURPOSE: u32 = 0x7e78_0000;

/// Noise of `width` x `height` texels whose smallest value is 0 and whose largest is 1.
pub fn noise(width: usize, height: usize, seed: u32) -> Raster<f32> {
    let mut sum = vec![0.0f32; width * height];
    for octave in 0..OCTAVES {
        add_octave(&mut sum, [width, height], seed, octave);
    }
    let (low, high) = sum.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    // A single texel is even.
    let scale = if high > low { 1.0 / (high - low) } else { 0.0 };
    Raster::from_data(width, height, sum.into_iter().map(|v| ((v - low) * scale).clamp(0.0, 1.0)).collect())
}

/// Adds white noise of variance 1, smoothed to variance 1.
fn add_octave(sum: &mut [f32], [width, height]: [usize; 2], seed: u32, octave: u32) {
    // Weigh by a Gaussian whose squares sum to 1.
    let sigma = FINEST * f64::from(1u32 << octave);
    let reach = (REACH * sigma) as usize;
    let plain: Vec<f64> =
        (0..=2 * reach).map(|k| (k as f64 - reach as f64) / sigma).map(|x| libm::exp(-0.5 * x * x)).collect();
    let length = plain.iter().map(|w| w * w).sum::<f64>().sqrt();
    let weights: Vec<f32> = plain.iter().map(|w| (w / length) as f32).collect();

    // Draw the rows with those around, and smooth along each.
    let rows = height + 2 * reach;
    let mut along = vec![0.0f32; width * rows];
    along.par_chunks_mut(width).enumerate().for_each(|(j, row)| {
        let mut stream = Stream::new(u64::from(seed), PURPOSE + octave, 0, j as u32);
        let white: Vec<f32> =
            (0..width + 2 * reach).map(|_| ((stream.uniform() - 0.5) * 12.0f64.sqrt()) as f32).collect();
        for (k, weight) in weights.iter().enumerate() {
            row.iter_mut().zip(&white[k..]).for_each(|(to, from)| *to += weight * from);
        }
    });

    // Smooth down the columns.
    sum.par_chunks_mut(width).enumerate().for_each(|(j, row)| {
        for (k, weight) in weights.iter().enumerate() {
            let from = &along[(j + k) * width..][..width];
            row.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power of a row at so many waves along it, by the sum itself, under a Hann window.
    fn power(row: &[f32], waves: f64) -> f64 {
        let n = row.len() as f64;
        let mean = row.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
        let parts = row.iter().enumerate().map(|(k, v)| {
            let turn = std::f64::consts::TAU * (k as f64 + 0.5) / n;
            let (sin, cos) = libm::sincos(turn * waves);
            let value = (f64::from(*v) - mean) * (1.0 - libm::cos(turn));
            [value * cos, value * sin]
        });
        let [a, b] = parts.fold([0.0; 2], |[a, b], [x, y]| [a + x, b + y]);
        a * a + b * b
    }

    /// Of all power along rows less than 1e-3 is at wavelengths below the shortest; and there is some just above it.
    #[test]
    fn nothing_is_finer_than_the_shortest_wavelength() {
        let n = 256;
        let picture = noise(n, 64, 7);
        let (mut fine, mut coarse, mut near) = (0.0, 0.0, 0.0);
        for j in 0..64 {
            for waves in 1..n / 2 {
                let texels = n as f64 / waves as f64;
                let own = power(picture.row(j), waves as f64);
                if texels < TEXELS_A_WAVE {
                    fine += own
                } else {
                    coarse += own
                }
                near += if (3.0 * TEXELS_A_WAVE..5.0 * TEXELS_A_WAVE).contains(&texels) { own } else { 0.0 };
            }
        }
        assert!(fine < 1e-3 * coarse && near > 1e-2 * coarse, "{fine} {near} {coarse}");
    }

    /// No shift along rows or columns brings the noise back.
    #[test]
    fn it_is_nowhere_periodic() {
        let picture = noise(300, 40, 1);
        let mean = picture.data().iter().map(|v| f64::from(*v)).sum::<f64>() / 12000.0;
        let product = |shift: usize| {
            let of = |j: usize| picture.row(j).iter().zip(&picture.row(j)[shift..]);
            let all = (0..40).flat_map(of).map(|(a, b)| (f64::from(*a) - mean) * (f64::from(*b) - mean));
            all.sum::<f64>() / (40 * (300 - shift)) as f64
        };
        // Beyond the reach of the coarsest Gaussian on both sides rows are independent: 40 rows of some 10 numbers.
        let worst = (64..200).map(|shift| (product(shift) / product(0)).abs()).fold(0.0, f64::max);
        assert!(worst < 0.5, "{worst}");
    }

    #[test]
    fn seeds_differ_and_a_seed_is_the_same_again() {
        assert_eq!(noise(40, 30, 3), noise(40, 30, 3));
        assert_ne!(noise(40, 30, 3), noise(40, 30, 4));
        let range = noise(40, 30, 3).data().iter().fold([1.0f32, 0.0], |[l, h], v| [l.min(*v), h.max(*v)]);
        assert_eq!(range, [0.0, 1.0]);
    }
}
