//! Numbers that carry derivatives: one formula, written once over [`Differentiable`], gives its value, its gradient or its second
//! derivative along a line, each exact but for rounding (Griewank & Walther, "Evaluating Derivatives", 2008, chapters 3 and 13).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// What a formula is written over: `f64`, [`Dual`] or [`Taylor`].
pub trait Differentiable:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A number that does not change.
    fn constant(value: f64) -> Self;
    /// The number itself.
    fn value(self) -> f64;
    /// Its product with a number that does not change.
    #[must_use]
    fn times(self, factor: f64) -> Self;
    /// Its square root.
    #[must_use]
    fn sqrt(self) -> Self;
}

/// a . b
pub fn dot<N: Differentiable>(a: [N; 3], b: [N; 3]) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a + t b
pub fn along<N: Differentiable>(a: [N; 3], t: N, b: [N; 3]) -> [N; 3] {
    [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]]
}

impl Differentiable for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn times(self, factor: f64) -> Self {
        self * factor
    }

    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
}

/// A number and its partial derivatives by `K` variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<const K: usize> {
    /// The number.
    pub value: f64,
    /// Its derivatives.
    pub by: [f64; K],
}

impl<const K: usize> Dual<K> {
    /// The variable `k` itself, at `value`.
    pub(crate) fn variable(value: f64, k: usize) -> Self {
        let mut by = [0.0; K];
        by[k] = 1.0;
        Self { value, by }
    }

    /// A function of this number, from its value and its slope.
    fn through(self, value: f64, slope: f64) -> Self {
        Self { value, by: self.by.map(|d| slope * d) }
    }

    /// A function of two numbers, from its value and its two slopes.
    fn of_both(self, other: Self, value: f64, slopes: [f64; 2]) -> Self {
        Self { value, by: std::array::from_fn(|k| slopes[0] * self.by[k] + slopes[1] * other.by[k]) }
    }
}

impl<const K: usize> Differentiable for Dual<K> {
    fn constant(value: f64) -> Self {
        Self { value, by: [0.0; K] }
    }

    fn value(self) -> f64 {
        self.value
    }

    fn times(self, factor: f64) -> Self {
        self.through(self.value * factor, factor)
    }

    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.through(root, 0.5 / root)
    }
}

impl<const K: usize> Add for Dual<K> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.of_both(other, self.value + other.value, [1.0, 1.0])
    }
}

impl<const K: usize> Sub for Dual<K> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.of_both(other, self.value - other.value, [1.0, -1.0])
    }
}

impl<const K: usize> Mul for Dual<K> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.of_both(other, self.value * other.value, [other.value, self.value])
    }
}

impl<const K: usize> Div for Dual<K> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let ratio = self.value / other.value;
        self.of_both(other, ratio, [1.0 / other.value, -ratio / other.value])
    }
}

impl<const K: usize> Neg for Dual<K> {
    type Output = Self;
    fn neg(self) -> Self {
        self.times(-1.0)
    }
}

/// A number along a line: its series a + b s + c s^2 in the way s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taylor(pub [f64; 3]);

impl Differentiable for Taylor {
    fn constant(value: f64) -> Self {
        Self([value, 0.0, 0.0])
    }

    fn value(self) -> f64 {
        self.0[0]
    }

    fn times(self, factor: f64) -> Self {
        Self(self.0.map(|c| c * factor))
    }

    fn sqrt(self) -> Self {
        let [a, b, c] = self.0;
        let root = a.sqrt();
        let slope = 0.5 * b / root;
        Self([root, slope, 0.5 * (c - slope * slope) / root])
    }
}

impl Add for Taylor {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl Sub for Taylor {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl Mul for Taylor {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        Self([a * d, a * e + b * d, a * f + b * e + c * d])
    }
}

impl Div for Taylor {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        let p = a / d;
        let q = (b - p * e) / d;
        Self([p, q, (c - p * f - q * e) / d])
    }
}

impl Neg for Taylor {
    type Output = Self;
    fn neg(self) -> Self {
        self.times(-1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (x y - x)/sqrt(x + y^2) - y
    fn formula<N: Differentiable>(x: N, y: N) -> N {
        (x * y - x) / (x + y * y).sqrt() + (-y).times(0.5) - y.times(0.5)
    }

    /// The derivatives by hand at (2, 3).
    #[test]
    fn derivatives_are_those_of_the_textbook() {
        let root = 11.0f64.sqrt();
        let by_x = 2.0 / root - 4.0 / (2.0 * 11.0 * root);
        let by_y = 2.0 / root - 4.0 * 3.0 / (11.0 * root) - 1.0;
        let dual = formula(Dual::<2>::variable(2.0, 0), Dual::variable(3.0, 1));
        assert!((dual.by[0] - by_x).abs() < 1e-15 && (dual.by[1] - by_y).abs() < 1e-15, "{dual:?}");
        assert_eq!(dual.value, formula(2.0, 3.0));

        // Along (x, y) = (2 + s, 3 - 2 s) by the third-order differences of a step that leaves 1e-8.
        let line = |s: f64| formula(2.0 + s, 3.0 - 2.0 * s);
        let Taylor([value, first, second]) = formula(Taylor([2.0, 1.0, 0.0]), Taylor([3.0, -2.0, 0.0]));
        let h = 1e-3;
        assert_eq!(value, line(0.0));
        assert!((first - (by_x - 2.0 * by_y)).abs() < 1e-15);
        assert!((2.0 * second - (line(h) - 2.0 * value + line(-h)) / (h * h)).abs() < 1e-6);
    }
}
