//! Goldens of what is random: two sets of pictures, drawn with different seeds, are of one scene when region by region
//! their means and their noise agree as well as chance allows.
//!
//! Each set is summed up by its own spread from picture to picture, so that neither white nor normal noise is assumed:
//! only that the mean over a region and the variance over a region, of many pixels, are nearly normal.

use crate::num::stats::{mean, normal_beyond, student_beyond};
use crate::raster::Raster;
use serde::{Deserialize, Serialize};

/// A right program fails a case with this probability, were its random numbers drawn anew; they are not, as a seed fixes
/// them, so it fails only by chance on the day on which the way of drawing changes.
pub const FALSE_ALARM: f64 = 1e-6;
/// Pictures to be drawn of a case.
pub const REPLICATES: usize = 64;
/// Regions are squares of this many pixels, cut off at the right and the lower border.
const SIDE_PX: usize = 16;
/// Where nothing is random, f32 keeps light of full scale 1 this well.
const ROUNDING: f64 = 1e-6;

/// What a set of pictures is like, region by region from the top left.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Regions {
    /// Pictures.
    pub replicates: usize,
    /// Columns and rows of a picture.
    pub size_px: [usize; 2],
    /// Mean light.
    pub light: Vec<Estimate>,
    /// Mean over the pixels of their variance from picture to picture.
    pub variance: Vec<Estimate>,
}

/// A mean over pictures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error.
    pub error: f64,
}

impl Estimate {
    fn of(values: &[f64]) -> Self {
        let mean = mean(values);
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let n = values.len() as f64;
        Self { mean, error: (squares / (n * (n - 1.0))).sqrt() }
    }
}

impl Regions {
    /// Sums up pictures of one scene, each drawn with a seed of its own.
    ///
    /// # Panics
    /// When there are fewer than two, or they differ in size.
    pub fn of(pictures: &[Raster<f32>]) -> Self {
        assert!(pictures.len() > 1, "noise shows in two pictures or more");
        let (width, height) = (pictures[0].width(), pictures[0].height());
        assert!(pictures.iter().all(|p| (p.width(), p.height()) == (width, height)), "pictures of one size");
        let average = average(pictures);
        // Of n numbers about their own mean the sum of squares is n - 1 variances.
        let freedom = (pictures.len() as f64 - 1.0) / pictures.len() as f64;
        let (mut light, mut variance) = (Vec::new(), Vec::new());
        for y in (0..height).step_by(SIDE_PX) {
            for x in (0..width).step_by(SIDE_PX) {
                let (rows, columns) = (y..height.min(y + SIDE_PX), x..width.min(x + SIDE_PX));
                let pixels = (rows.len() * columns.len()) as f64;
                let sum = |f: &dyn Fn(usize) -> f64| -> f64 {
                    rows.clone().flat_map(|j| columns.clone().map(move |i| j * width + i)).map(f).sum::<f64>() / pixels
                };
                let lights: Vec<f64> = pictures.iter().map(|p| sum(&|k| f64::from(p.data()[k]))).collect();
                let square = |p: &Raster<f32>, k: usize| {
                    let off = f64::from(p.data()[k]) - average[k];
                    off * off / freedom
                };
                let squares: Vec<f64> = pictures.iter().map(|p| sum(&|k| square(p, k))).collect();
                light.push(Estimate::of(&lights));
                variance.push(Estimate::of(&squares));
            }
        }
        Self { replicates: pictures.len(), size_px: [width, height], light, variance }
    }

    /// What of `actual` chance does not explain, one sentence each, the worst first.
    ///
    /// Each mean of a region is judged by Welch's t-test with the degrees of freedom of the smaller set, and its variance
    /// likewise; all of them together keep to [`FALSE_ALARM`].
    pub fn mismatches(&self, actual: &Self) -> Vec<String> {
        if self.size_px != actual.size_px || self.light.len() != actual.light.len() {
            return vec![format!("the pictures were {:?} px and are {:?}", self.size_px, actual.size_px)];
        }
        let tests = 2 * self.light.len();
        let freedom = self.replicates.min(actual.replicates) - 1;
        let most = student_beyond(normal_beyond(0.5 * FALSE_ALARM / tests as f64), freedom as f64);
        let mut found = Vec::new();
        let figures = [
            ("light", &self.light, &actual.light, ROUNDING),
            ("variance", &self.variance, &actual.variance, ROUNDING * ROUNDING),
        ];
        for (what, expected, actual, rounding) in figures {
            for (k, (a, b)) in expected.iter().zip(actual).enumerate() {
                let t = (b.mean - a.mean) / (a.error * a.error + b.error * b.error).sqrt().max(rounding);
                if t.abs() > most || t.is_nan() {
                    found.push((t.abs(), self.sentence(what, k, a, b, t, most)));
                }
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().map(|(_, sentence)| sentence).collect()
    }

    fn sentence(&self, what: &str, k: usize, was: &Estimate, is: &Estimate, t: f64, most: f64) -> String {
        let columns = self.size_px[0].div_ceil(SIDE_PX);
        let (x, y) = (k % columns * SIDE_PX, k / columns * SIDE_PX);
        format!(
            "the {what} of the region at pixel ({x}, {y}) was {:.6e} and is {:.6e}: {t:+.1} standard errors, of {most:.1} \
             allowed",
            was.mean, is.mean
        )
    }
}

/// The mean of pictures, pixel by pixel.
fn average(pictures: &[Raster<f32>]) -> Vec<f64> {
    let mut sums = vec![0.0; pictures[0].data().len()];
    for picture in pictures {
        sums.iter_mut().zip(picture.data()).for_each(|(s, v)| *s += f64::from(*v));
    }
    sums.iter().map(|s| s / pictures.len() as f64).collect()
}

/// The mean picture, which is kept for inspection.
pub fn mean_picture(pictures: &[Raster<f32>]) -> Raster<f32> {
    let light = average(pictures).into_iter().map(|v| v as f32).collect();
    Raster::from_data(pictures[0].width(), pictures[0].height(), light)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::deviates::Stream;

    /// An edge at `edge_px` with noise of a standard deviation, drawn from a seed.
    fn drawn(seed: u64, edge_px: f64, deviation: f64) -> Vec<Raster<f32>> {
        let (width, height) = (80, 60);
        let pixel = |replicate: u64, k: usize| {
            let light = (edge_px - (k % width) as f64).clamp(0.0, 1.0) * 0.8 + 0.05;
            let noise = Stream::new(seed + replicate, 0, 0, k as u32).normals()[0];
            (light + deviation * noise) as f32
        };
        let picture = |r: u64| Raster::from_data(width, height, (0..width * height).map(|k| pixel(r, k)).collect());
        (0..REPLICATES as u64).map(picture).collect()
    }

    fn regions(seed: u64, edge_px: f64, deviation: f64) -> Regions {
        Regions::of(&drawn(seed, edge_px, deviation))
    }

    #[test]
    fn another_seed_is_the_same_scene() {
        let golden = regions(1, 17.3, 0.02);
        for seed in [1000, 2000, 3000, 4000] {
            assert_eq!(golden.mismatches(&regions(seed, 17.3, 0.02)), [] as [String; 0]);
        }
        assert_eq!(golden.light.len(), 5 * 4);
        // 0.02^2: 256 x 64 numbers give a variance to 1.1 % in one region, 20 regions to 0.25 %.
        let all = mean(&golden.variance.iter().map(|v| v.mean).collect::<Vec<_>>());
        assert!((all / 4e-4 - 1.0).abs() < 5.0 * 0.0025, "{all}");
    }

    /// One region of 16 x 16 px and 64 pictures tells a mean to 0.02 / 128, and two such from each other to 2.2e-4: at 7
    /// errors an edge that moves by 0.05 px and changes 16 pixels of 256 by 0.04, which is 2.5e-3, and noise stronger by a
    /// fifth (a variance of 1.44, known to 1.6 %).
    #[test]
    fn what_moves_or_grows_noisier_fails() {
        let golden = regions(1, 17.3, 0.02);
        let moved = golden.mismatches(&regions(5000, 17.35, 0.02));
        assert!(
            moved.len() == 4 && moved.iter().all(|m| m.contains("light of the region at pixel (16, ")),
            "{moved:?}"
        );
        let noisier = golden.mismatches(&regions(6000, 17.3, 0.024));
        assert!(noisier.len() == 20 && noisier.iter().all(|m| m.contains("variance")), "{noisier:?}");
        let quiet = golden.mismatches(&regions(7000, 17.3, 0.0));
        assert!(quiet.len() >= 20);
    }

    #[test]
    fn pictures_without_noise_must_be_equal() {
        let golden = regions(1, 17.3, 0.0);
        assert!(golden.mismatches(&regions(2, 17.3, 0.0)).is_empty());
        assert_eq!(golden.mismatches(&regions(2, 17.301, 0.0)).len(), 4);
        let mut not_finite = golden.clone();
        not_finite.light[3].mean = f64::NAN;
        assert_eq!(golden.mismatches(&not_finite).len(), 1);
    }

    #[test]
    fn pictures_of_another_size_fail() {
        let small = Regions::of(&[Raster::filled(8, 8, 0.5f32), Raster::filled(8, 8, 0.6)]);
        assert_eq!(regions(1, 17.3, 0.02).mismatches(&small).len(), 1);
    }

    /// Drawn a hundred times, the test keeps to its rate at one that can be counted.
    #[test]
    fn the_false_alarms_are_as_many_as_said() {
        let (mut beyond, mut tests) = (0.0, 0.0);
        let sets: Vec<Regions> = (0..12).map(|k| regions(10_000 * (k + 1), 17.3, 0.02)).collect();
        let most = student_beyond(normal_beyond(0.025), REPLICATES as f64 - 1.0);
        for pair in sets.chunks_exact(2) {
            for (a, b) in [(&pair[0].light, &pair[1].light), (&pair[0].variance, &pair[1].variance)] {
                for (a, b) in a.iter().zip(b) {
                    let t = (a.mean - b.mean) / (a.error * a.error + b.error * b.error).sqrt();
                    beyond += f64::from(u8::from(t.abs() > most));
                    tests += 1.0;
                }
            }
        }
        // 240 tests at 5 %: 12 +- 3.4; five of those.
        let expected: f64 = 0.05 * tests;
        assert!(tests == 240.0 && (beyond - expected).abs() < 5.0 * expected.sqrt(), "{beyond} of {tests}");
    }
}
