//! Noise for the tests of metrics.

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
