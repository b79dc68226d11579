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

pub use measured_and_true::{MeasuredAndTrue, Numbers};

pub mod line;
pub mod stereo;
pub mod pixel_map;
pub mod epipolar;
pub mod straightness;
pub mod pinhole;
pub mod reprojection;
pub mod ray_bundle;
mod measured_and_true;
mod deviation;
mod observation;

pub use deviation::{Deviation, Unmeasurable};
pub use observation::{Observation, Pair};

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use glam::DVec2;

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
