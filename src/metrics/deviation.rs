//! Deviations of points, and why a metric may not exist.

use crate::num::lsq;
use glam::DVec2;

/// Why a figure has no value.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Unmeasurable {
    /// Fewer items than the definition needs.
    #[error("too few {what}: {found}, and at least {needed} needed")]
    TooFew {
        /// What is counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many the definition needs.
        needed: usize,
    },
    /// A NaN or an infinity in the input.
    #[error("{what} {index} is not finite")]
    NotFinite {
        /// What is at fault.
        what: &'static str,
        /// Its place in the input, from 0.
        index: usize,
    },
    /// The items do not determine the answer.
    #[error("{0}")]
    Degenerate(&'static str),
    /// A point that the camera cannot see.
    #[error("point {index} lies at or behind the camera's centre")]
    BehindCamera {
        /// Its place in the input, from 0.
        index: usize,
    },
    /// A ray that never meets the plane or the axis in question.
    #[error("ray {index} runs parallel to it")]
    Parallel {
        /// Its place in the input, from 0.
        index: usize,
    },
    /// There is no pinhole to compare with, and why.
    #[error("no pinhole: {0}")]
    NoPinhole(&'static str),
    /// The fit behind the figure failed.
    #[error("the fit failed: {0}")]
    Fit(#[from] lsq::Failure),
}

/// Sizes of a set of residual vectors, in the unit of the vectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// N, the count of vectors.
    pub n: usize,
    /// Mean vector (bias).
    pub mean: DVec2,
    /// Mean of |horizontal| and mean of |vertical|, over N: the design paper's "reprojection error".
    pub mean_abs: DVec2,
    /// sqrt(sum |e|^2 / N).
    pub rms: f64,
    /// Largest |e|.
    pub max: f64,
}

impl Deviation {
    /// The sizes of `residuals`, summed in their order.
    ///
    /// # Errors
    /// [`Unmeasurable::TooFew`] of none, [`Unmeasurable::NotFinite`].
    pub fn of(residuals: &[DVec2]) -> Result<Self, Unmeasurable> {
        at_least("residuals", residuals.len(), 1)?;
        all_finite("residual", residuals, |e| e.is_finite())?;
        let n = residuals.len() as f64;
        Ok(Self {
            n: residuals.len(),
            mean: residuals.iter().sum::<DVec2>() / n,
            mean_abs: residuals.iter().map(|e| e.abs()).sum::<DVec2>() / n,
            rms: (residuals.iter().map(|e| e.length_squared()).sum::<f64>() / n).sqrt(),
            max: residuals.iter().fold(0.0, |m: f64, e| m.max(e.length())),
        })
    }

    /// The same deviation in another unit: from px to mm on the sensor by the pixel pitch.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            n: self.n,
            mean: self.mean * factor,
            mean_abs: self.mean_abs * factor.abs(),
            rms: self.rms * factor.abs(),
            max: self.max * factor.abs(),
        }
    }

    /// The sizes of two sets of residuals taken together.
    #[must_use]
    pub fn pooled(&self, other: &Self) -> Self {
        let (a, b) = (self.n as f64, other.n as f64);
        let mean = |x: DVec2, y: DVec2| (x * a + y * b) / (a + b);
        Self {
            n: self.n + other.n,
            mean: mean(self.mean, other.mean),
            mean_abs: mean(self.mean_abs, other.mean_abs),
            rms: ((self.rms * self.rms * a + other.rms * other.rms * b) / (a + b)).sqrt(),
            max: self.max.max(other.max),
        }
    }

    /// sqrt(sum |e|^2 / 2N): what ROS `camera_check` prints as reprojection RMS, smaller by sqrt(2).
    pub fn rms_of_components(&self) -> f64 {
        self.rms / std::f64::consts::SQRT_2
    }
}

pub(super) fn at_least(what: &'static str, found: usize, needed: usize) -> Result<(), Unmeasurable> {
    if found < needed { Err(Unmeasurable::TooFew { what, found, needed }) } else { Ok(()) }
}

pub(super) fn all_finite<T>(what: &'static str, items: &[T], finite: impl Fn(&T) -> bool) -> Result<(), Unmeasurable> {
    match items.iter().position(|item| !finite(item)) {
        Some(index) => Err(Unmeasurable::NotFinite { what, index }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviation_of_two_vectors_by_hand() {
        let d = Deviation::of(&[DVec2::new(3.0, -4.0), DVec2::new(-1.0, 0.0)]).unwrap();
        assert_eq!((d.n, d.mean, d.mean_abs, d.max), (2, DVec2::new(1.0, -2.0), DVec2::new(2.0, 2.0), 5.0));
        assert!((d.rms - 13f64.sqrt()).abs() < 1e-15);
        let scaled = Deviation::of(&[DVec2::new(-6.0, 8.0), DVec2::new(2.0, 0.0)]).unwrap();
        assert_eq!(d.scaled(-2.0), scaled);
        // ROS: four scalars 3, -4, -1, 0.
        assert!((d.rms_of_components() - (26.0f64 / 4.0).sqrt()).abs() < 1e-15);
    }

    /// Two unequal sets taken together are the set of all.
    #[test]
    fn pooled_sets_are_the_joined_set() {
        let few = [DVec2::new(3.0, -4.0), DVec2::new(-1.0, 0.5)];
        let many =
            [DVec2::new(0.5, 0.25), DVec2::new(-0.125, 1.0), DVec2::new(2.0, 2.0), DVec2::new(0.0, -0.75), DVec2::X];
        let [a, b] = [&few[..], &many[..]].map(|set| Deviation::of(set).unwrap());
        let joined = Deviation::of(&[&few[..], &many[..]].concat()).unwrap();
        for pooled in [a.pooled(&b), b.pooled(&a)] {
            assert_eq!((pooled.n, pooled.max), (7, 5.0));
            assert!((pooled.rms - joined.rms).abs() < 1e-15);
            assert!((pooled.mean - joined.mean).length() < 1e-15);
            assert!((pooled.mean_abs - joined.mean_abs).length() < 1e-15);
        }
    }

    #[test]
    fn nothing_and_nan_are_named() {
        assert_eq!(Deviation::of(&[]), Err(Unmeasurable::TooFew { what: "residuals", found: 0, needed: 1 }));
        let one = Deviation::of(&[DVec2::ZERO, DVec2::new(0.0, f64::NAN)]);
        assert_eq!(one, Err(Unmeasurable::NotFinite { what: "residual", index: 1 }));
    }
}
