//! Several numbers that go through the same operations at once.
//!
//! Plain arrays whose operations are loops over the lanes: the compiler turns them into vector instructions of the
//! width that [`widest`] found on this machine. Each lane does the very operations of scalar code in the same order,
//! and no multiplication is fused with an addition, so the bits are those of scalar code, on every machine.

use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Lanes of a packet: two AVX registers of f64, so that one computes while the other waits for its result.
pub const LANES: usize = 8;

/// [`LANES`] numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub struct Lanes(pub [f64; LANES]);

/// [`LANES`] answers, each all ones or all zeros.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(32))]
pub struct Mask(pub [u64; LANES]);

/// A computation to be compiled once for each width of vectors: everything that `run` calls must be inlined into it.
pub trait Kernel {
    /// What it computes.
    type Out;
    /// The computation. Mark it `#[inline(always)]`.
    fn run(self) -> Self::Out;
}

/// Runs `kernel` with the widest vectors of this machine.
#[allow(unsafe_code, reason = "a function for AVX may be called only where it was found, one line above")]
pub fn widest<K: Kernel>(kernel: K) -> K::Out {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx512f")
        && std::arch::is_x86_feature_detected!("avx512dq")
        && std::arch::is_x86_feature_detected!("avx512vl")
    {
        #[target_feature(enable = "avx512f,avx512dq,avx512vl")]
        fn with_avx512<K: Kernel>(kernel: K) -> K::Out {
            kernel.run()
        }
        // SAFETY: AVX-512 is there.
        return unsafe { with_avx512(kernel) };
    }
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        #[target_feature(enable = "avx2")]
        fn with_avx2<K: Kernel>(kernel: K) -> K::Out {
            kernel.run()
        }
        // SAFETY: AVX2 is there.
        return unsafe { with_avx2(kernel) };
    }
    kernel.run()
}

macro_rules! lanewise {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            #[allow(clippy::assign_op_pattern, reason = "the macro is given the operator alone")]
            fn $method(mut self, other: Self) -> Self {
                for (a, b) in self.0.iter_mut().zip(other.0) {
                    *a = *a $op b;
                }
                self
            }
        }
    };
}
lanewise!(Add, add, +);
lanewise!(Sub, sub, -);
lanewise!(Mul, mul, *);
lanewise!(Div, div, /);

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for v in &mut self.0 {
            *v = -*v;
        }
        self
    }
}

impl Lanes {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(v: f64) -> Self {
        Self([v; LANES])
    }

    /// `f(i)` in lane i.
    #[inline(always)]
    pub fn of(f: impl Fn(usize) -> f64) -> Self {
        let mut lanes = Self::splat(0.0);
        for i in 0..LANES {
            lanes.0[i] = f(i);
        }
        lanes
    }

    /// The first [`LANES`] of `v`.
    #[inline(always)]
    pub fn load(v: &[f64]) -> Self {
        let v = &v[..LANES];
        Self::of(|i| v[i])
    }

    /// Writes them as f32; `out` may hold fewer.
    #[inline(always)]
    pub fn store(self, out: &mut [f32]) {
        if out.len() >= LANES {
            let out = &mut out[..LANES];
            for (o, v) in out.iter_mut().zip(self.0) {
                *o = v as f32;
            }
        } else {
            for (o, v) in out.iter_mut().zip(self.0) {
                *o = v as f32;
            }
        }
    }

    /// The square roots.
    #[inline(always)]
    pub fn sqrt(mut self) -> Self {
        for v in &mut self.0 {
            *v = v.sqrt();
        }
        self
    }

    /// The magnitudes.
    #[inline(always)]
    pub fn abs(mut self) -> Self {
        for v in &mut self.0 {
            *v = v.abs();
        }
        self
    }

    /// The smaller of each two; `other` where self is NaN.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.lt(other).select(self, other)
    }

    /// The larger of each two; `other` where self is NaN.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        other.lt(self).select(self, other)
    }

    /// The numbers with their signs turned where `mask`.
    #[inline(always)]
    pub(crate) fn negated_where(mut self, mask: Mask) -> Self {
        for i in 0..LANES {
            self.0[i] = f64::from_bits(self.0[i].to_bits() ^ (mask.0[i] & (1 << 63)));
        }
        self
    }

    #[inline(always)]
    fn compare(self, other: Self, holds: impl Fn(f64, f64) -> bool) -> Mask {
        let mut mask = Mask([0; LANES]);
        for i in 0..LANES {
            mask.0[i] = if holds(self.0[i], other.0[i]) { !0 } else { 0 };
        }
        mask
    }

    /// Where self <= other; false for NaN.
    #[inline(always)]
    pub fn le(self, other: Self) -> Mask {
        self.compare(other, |a, b| a <= b)
    }

    /// Where self < other; false for NaN.
    #[inline(always)]
    pub(crate) fn lt(self, other: Self) -> Mask {
        self.compare(other, |a, b| a < b)
    }

    /// e to the power of each, to 1e-14 of it; beyond -700 and 700 that of these.
    #[inline(always)]
    pub fn exp(self) -> Self {
        // Adding this rounds to a whole number, which the last bits then hold.
        const ROUNDING: f64 = 6_755_399_441_055_744.0;
        const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
        // 1 / 12!, 1 / 11!, .. 1
        const TERMS: [f64; 13] = reciprocal_factorials([12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0]);
        let x = self.max(Self::splat(-700.0)).min(Self::splat(700.0));
        let rounded = x * Self::splat(std::f64::consts::LOG2_E) + Self::splat(ROUNDING);
        let power = rounded - Self::splat(ROUNDING);
        let rest = (x - power * Self::splat(LN_2[0])) - power * Self::splat(LN_2[1]);
        let mut out = Self::splat(TERMS[0]);
        for term in &TERMS[1..] {
            out = out * rest + Self::splat(*term);
        }
        // Multiply by 2 to that power, through the exponent's bits.
        for (v, rounded) in out.0.iter_mut().zip(rounded.0) {
            *v *= f64::from_bits((rounded.to_bits() << 52).wrapping_add(1023 << 52));
        }
        out
    }

    /// The sines of angles in -pi/2..=pi/2, to 1e-15.
    #[inline(always)]
    pub fn sin(self) -> Self {
        // 1 / 19!, 1 / 17!, .. 1
        const TERMS: [f64; 10] = reciprocal_factorials([19, 17, 15, 13, 11, 9, 7, 5, 3, 1]);
        let square = -(self * self);
        let mut out = Self::splat(TERMS[0]);
        for term in &TERMS[1..] {
            out = out * square + Self::splat(*term);
        }
        out * self
    }

    /// The sum of the lanes, in a fixed order.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
}

/// 1 / n! of each n.
const fn reciprocal_factorials<const N: usize>(of: [u32; N]) -> [f64; N] {
    let mut out = [1.0; N];
    let mut i = 0;
    while i < N {
        let mut factor = 2;
        while factor <= of[i] {
            out[i] /= factor as f64;
            factor += 1;
        }
        i += 1;
    }
    out
}

impl Mask {
    /// True in every lane, or in none.
    #[inline(always)]
    pub fn splat(v: bool) -> Self {
        Self([if v { !0 } else { 0 }; LANES])
    }

    /// Whether no lane is true.
    #[inline(always)]
    pub fn none(self) -> bool {
        self.0.iter().fold(0, |any, m| any | m) == 0
    }

    /// Whether every lane is true.
    #[inline(always)]
    pub fn all(self) -> bool {
        self.0.iter().fold(!0, |all, m| all & m) == !0
    }

    /// `yes` where true, else `no`.
    #[inline(always)]
    pub fn select(self, yes: Lanes, no: Lanes) -> Lanes {
        let mut out = no;
        for i in 0..LANES {
            out.0[i] = f64::from_bits((yes.0[i].to_bits() & self.0[i]) | (no.0[i].to_bits() & !self.0[i]));
        }
        out
    }
}

impl BitAnd for Mask {
    type Output = Self;
    #[inline(always)]
    fn bitand(mut self, other: Self) -> Self {
        for i in 0..LANES {
            self.0[i] &= other.0[i];
        }
        self
    }
}

impl BitOr for Mask {
    type Output = Self;
    #[inline(always)]
    fn bitor(mut self, other: Self) -> Self {
        for i in 0..LANES {
            self.0[i] |= other.0[i];
        }
        self
    }
}

impl Not for Mask {
    type Output = Self;
    #[inline(always)]
    fn not(mut self) -> Self {
        for v in &mut self.0 {
            *v = !*v;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_choose_lane_by_lane() {
        let of = |v: [f64; 4]| Lanes::of(|i| v[i % 4]);
        let (a, b) = (of([1.0, 2.0, f64::NAN, -0.0]), of([2.0, 1.0, 1.0, 0.0]));
        assert_eq!(a.lt(b).select(a, b).0[..2], [1.0, 1.0]);
        assert_eq!(a.lt(b).0[..4], [!0, 0, 0, 0]);
        assert_eq!(a.le(b).0[..4], [!0, 0, 0, !0]);
        assert_eq!(b.negated_where(a.lt(b)).0[..4], [-2.0, 1.0, 1.0, 0.0]);
        assert_eq!((a.min(b).0[2], a.max(b).0[1]), (1.0, 2.0));
        assert!(Mask::splat(true).all() && Mask::splat(false).none() && !a.lt(b).all() && !a.lt(b).none());
    }

    #[test]
    fn wide_vectors_round_as_scalars_do() {
        struct Mixed([Lanes; 3]);
        impl Kernel for Mixed {
            type Out = Lanes;
            #[inline(always)]
            fn run(self) -> Lanes {
                let [a, b, c] = self.0;
                ((a * b + c) / (a - b)).sqrt()
            }
        }
        let lanes = |k: usize| Lanes::of(|i| 1.0 + libm::sin((7 * i + k) as f64).abs());
        for k in 0..1000 {
            let [a, b, c] = [lanes(k), lanes(k + 1), lanes(3 * k)];
            let wide = widest(Mixed([a, b, c]));
            for i in 0..LANES {
                let scalar = ((a.0[i] * b.0[i] + c.0[i]) / (a.0[i] - b.0[i])).sqrt();
                assert_eq!(wide.0[i].to_bits(), scalar.to_bits());
            }
        }
    }

    #[test]
    fn exponentials_and_sines_are_right_to_their_stated_error() {
        for k in -9000..=9000 {
            let x = f64::from(k) * 0.0777 + 0.003;
            let exp = libm::exp(x.clamp(-700.0, 700.0));
            let theirs = libm::sin(x / 700.0 * std::f64::consts::FRAC_PI_2);
            let own = Lanes::splat(x / 700.0 * std::f64::consts::FRAC_PI_2).sin().0;
            assert!((Lanes::splat(x).exp().0[3] / exp - 1.0).abs() < 1e-14, "{x}");
            assert!((own[5] - theirs).abs() < 1e-15, "{x}");
        }
        assert_eq!(Lanes::splat(0.0).exp().0, [1.0; LANES]);
        assert_eq!(Lanes::of(|i| i as f64).sum(), 28.0);
    }
}
