//! Points to numbers: how far a stereo pair is from ideal, and each half from a pinhole.
//!
//! It takes matched corners, rays and pinholes, and knows nothing of the simulator, so it judges a photograph as well.
//!
//! Conventions of every figure here, unless its own line says otherwise:
//! - image positions are px in the pixel-edge convention (pixel (i, j) covers `[i, i+1) x [j, j+1)`), each relative to
//!   the top left corner of its own half; world positions are mm;
//! - a residual is *found minus ideal*;
//! - `rms` is sqrt(sum |e|^2 / N) over N vectors, not the sqrt(sum |e|^2 / 2N) over scalars that ROS prints
//!   (see [`Deviation::rms_of_components`]);
//! - too little, collinear, or non-finite input is an [`Unmeasurable`] that says which, never a NaN.

use glam::{DVec2, DVec3};

pub use both::Both;

use crate::num::lsq;

mod both;
pub mod line;
pub mod stereo;
pub mod pixel_map;
pub mod epipolar;
pub mod straightness;
pub mod pinhole;
pub mod virtual_camera;
pub mod reprojection;

/// A board corner found in both halves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Column and row of the corner on the board.
    pub index: [i32; 2],
    /// Position in the left half, in px from that half's own origin.
    pub left_px: DVec2,
    /// Position in the right half, in px from that half's own origin.
    pub right_px: DVec2,
}

/// A known point and where one half sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// The point in the world, in mm.
    pub point_mm: DVec3,
    /// Its image, in px from the half's own origin.
    pub image_px: DVec2,
}

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
    /// A ray that never meets the plane or the axis asked about.
    #[error("ray {index} runs parallel to it")]
    Parallel {
        /// Its place in the input, from 0.
        index: usize,
    },
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

fn at_least(what: &'static str, found: usize, needed: usize) -> Result<(), Unmeasurable> {
    if found < needed { Err(Unmeasurable::TooFew { what, found, needed }) } else { Ok(()) }
}

fn all_finite<T>(what: &'static str, items: &[T], finite: impl Fn(&T) -> bool) -> Result<(), Unmeasurable> {
    match items.iter().position(|item| !finite(item)) {
        Some(index) => Err(Unmeasurable::NotFinite { what, index }),
        None => Ok(()),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Independent normal deviates of unit variance: a 64-bit mixer (splitmix64) and the polar method.
    pub(crate) struct Noise(pub(crate) u64);

    impl Noise {
        pub(crate) fn uniform(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        }

        pub(crate) fn normal(&mut self) -> DVec2 {
            loop {
                let v = DVec2::new(2.0 * self.uniform() - 1.0, 2.0 * self.uniform() - 1.0);
                let s = v.length_squared();
                if s > 0.0 && s < 1.0 {
                    return v * (-2.0 * libm::log(s) / s).sqrt();
                }
            }
        }
    }

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

    #[test]
    fn nothing_and_nan_are_named() {
        assert_eq!(Deviation::of(&[]), Err(Unmeasurable::TooFew { what: "residuals", found: 0, needed: 1 }));
        let one = Deviation::of(&[DVec2::ZERO, DVec2::new(0.0, f64::NAN)]);
        assert_eq!(one, Err(Unmeasurable::NotFinite { what: "residual", index: 1 }));
    }
}
