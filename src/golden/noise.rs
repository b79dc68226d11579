//! Goldens of what is random: two sets of pictures, other frames of one specimen of a sensor, are of one scene when their
//! means and their noise agree as well as chance allows, region by region and pooled over dark and bright pixels.
//!
//! Each set is summed up by its own spread from picture to picture, so that neither white nor normal noise is assumed:
//! only that means and variances of many pixels are nearly normal. The specimen is fixed: its pattern is the same in both
//! sets, and what it adds is told from noise by what two frames have in common.

use crate::num::stats::{mean, normal_beyond, student_beyond};
use crate::raster::Raster;
use serde::{Deserialize, Serialize};

/// A right program fails a case with this probability, were its random numbers drawn anew; they are not, as a seed fixes
/// them, so it fails only by chance on the day on which the way of drawing changes.
pub const FALSE_ALARM: f64 = 1e-6;
/// Pictures to be drawn of a case.
pub(crate) const REPLICATES: usize = 64;
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
    /// Of all pixels that are darker without noise than the middle between the darkest and the brightest, and of the others.
    pub pools: [Pool; 2],
}

/// What the pixels of one brightness are like, held against the picture without noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pool {
    /// Mean light, less that without noise.
    pub light: Estimate,
    /// Mean over the pixels of their variance from picture to picture.
    pub variance: Estimate,
    /// Mean square of what all pictures have in common and the one without noise has not: the pattern of the specimen.
    pub pattern: Estimate,
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

impl Pool {
    /// Of the given pixels, with the mean picture.
    fn of(pictures: &[Raster<f32>], quiet: &Raster<f32>, average: &[f64], pixels: &[usize]) -> Self {
        let n = pictures.len() as f64;
        let over = |f: &dyn Fn(usize) -> f64| pixels.iter().map(|&k| f(k)).sum::<f64>() / pixels.len().max(1) as f64;
        let ideal = |k: usize| f64::from(quiet.data()[k]);
        let each = |f: &dyn Fn(&Raster<f32>, usize) -> f64| -> Vec<f64> {
            pictures.iter().map(|picture| over(&|k| f(picture, k))).collect()
        };
        let light = each(&|p, k| f64::from(p.data()[k]) - ideal(k));
        let variance = each(&|p, k| {
            let off = f64::from(p.data()[k]) - average[k];
            off * off * n / (n - 1.0)
        });
        // Products of each picture with the mean of the others, and the pseudo-values of their mean by the jackknife.
        let products = each(&|p, k| {
            let own = f64::from(p.data()[k]) - ideal(k);
            own * (n * (average[k] - ideal(k)) - own) / (n - 1.0)
        });
        let all = mean(&products);
        let pseudo = |product: &f64| n * all - (n - 1.0) * (n * all - 2.0 * product) / (n - 2.0);
        let pattern: Vec<f64> = products.iter().map(pseudo).collect();
        Self { light: Estimate::of(&light), variance: Estimate::of(&variance), pattern: Estimate::of(&pattern) }
    }
}

impl Regions {
    /// Sums up pictures of one scene by one specimen, each a frame of its own, given the one without noise.
    ///
    /// # Panics
    /// When there are fewer than three, or they differ in size.
    pub fn of(pictures: &[Raster<f32>], quiet: &Raster<f32>) -> Self {
        assert!(pictures.len() > 2, "noise and pattern show in three pictures or more");
        let (width, height) = (pictures[0].width(), pictures[0].height());
        let of_size = |p: &Raster<f32>| (p.width(), p.height()) == (width, height);
        assert!(pictures.iter().all(of_size) && of_size(quiet), "pictures of one size");
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
        let (low, high) = (quiet.data().iter()).fold((1.0f32, 0.0f32), |(low, high), v| (low.min(*v), high.max(*v)));
        let pools = [false, true].map(|bright| {
            let is_of = |k: &usize| (quiet.data()[*k] > 0.5 * (low + high)) == bright;
            let pixels: Vec<usize> = (0..width * height).filter(is_of).collect();
            Pool::of(pictures, quiet, &average, &pixels)
        });
        Self { replicates: pictures.len(), size_px: [width, height], light, variance, pools }
    }

    /// What of `actual` chance does not explain, one sentence each, the worst first.
    ///
    /// Each mean of a region or pool is judged by Welch's t-test with the degrees of freedom of the smaller set, its variance
    /// and its pattern likewise; all of them together keep to [`FALSE_ALARM`].
    pub fn mismatches(&self, actual: &Self) -> Vec<String> {
        let counts = |regions: &Self| (regions.size_px, regions.light.len(), regions.variance.len());
        if counts(self) != counts(actual) || self.replicates < 3 {
            let were = format!(
                "the pictures were {} of {:?} px in {} regions",
                self.replicates,
                self.size_px,
                self.light.len()
            );
            return vec![format!("{were}, and are {} of {:?} px", actual.replicates, actual.size_px)];
        }
        let tests = 2 * self.light.len() + 6;
        let freedom = self.replicates.min(actual.replicates) - 1;
        let most = student_beyond(normal_beyond(0.5 * FALSE_ALARM / tests as f64), freedom as f64);
        let mut found = Vec::new();
        let mut compare = |what: &str, place: &dyn Fn() -> String, [a, b]: [&Estimate; 2], rounding: f64| {
            let t = (b.mean - a.mean) / (a.error * a.error + b.error * b.error).sqrt().max(rounding);
            if t.abs() > most || t.is_nan() {
                let (was, is) = (a.mean, b.mean);
                let sentence = format!(
                    "the {what} of {} was {was:.6e} and is {is:.6e}: {t:+.1} standard errors, of {most:.1} allowed",
                    place()
                );
                found.push((t.abs(), sentence));
            }
        };

        // Region by region.
        for (k, pair) in self.light.iter().zip(&actual.light).enumerate() {
            compare("light", &|| self.region(k), [pair.0, pair.1], ROUNDING);
        }
        for (k, pair) in self.variance.iter().zip(&actual.variance).enumerate() {
            compare("variance", &|| self.region(k), [pair.0, pair.1], ROUNDING * ROUNDING);
        }

        // Pooled.
        for (name, [a, b]) in
            [("dark", [&self.pools[0], &actual.pools[0]]), ("bright", [&self.pools[1], &actual.pools[1]])]
        {
            let place = || format!("all {name} pixels");
            compare("light", &place, [&a.light, &b.light], ROUNDING);
            compare("variance", &place, [&a.variance, &b.variance], ROUNDING * ROUNDING);
            compare("pattern", &place, [&a.pattern, &b.pattern], ROUNDING * ROUNDING);
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().map(|(_, sentence)| sentence).collect()
    }

    /// Where region `k` is.
    fn region(&self, k: usize) -> String {
        let columns = self.size_px[0].div_ceil(SIDE_PX);
        format!("the region at pixel ({}, {})", k % columns * SIDE_PX, k / columns * SIDE_PX)
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
pub(crate) fn mean_picture(pictures: &[Raster<f32>]) -> Raster<f32> {
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
        Regions::of(&drawn(seed, edge_px, deviation), &drawn(seed, edge_px, 0.0)[0])
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
        assert!(noisier.len() == 22 && noisier.iter().all(|m| m.contains("variance")), "{noisier:?}");
        // Pooled, 4800 x 64 numbers tell a variance to 0.26 %: 3 % more noise is 6 % more of it.
        let noisier = golden.mismatches(&regions(8000, 17.3, 0.0206));
        assert!(noisier.iter().any(|m| m.contains("variance of all")), "{noisier:?}");
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
        let small = Regions::of(&[0.5, 0.6, 0.7].map(|v| Raster::filled(8, 8, v)), &Raster::filled(8, 8, 0.5f32));
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
