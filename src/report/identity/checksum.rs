//! Values, summed up.

use crate::num::poly2::Poly2;
use glam::{DVec2, DVec3};

/// The hash FNV-1a of 64 bits (Fowler, Noll, Vo) of canonical values, one after the other.
#[derive(Debug)]
pub(super) struct Checksum(u64);

impl Checksum {
    /// That of what `values` adds, in hexadecimal.
    pub(super) fn of(values: impl FnOnce(&mut Self)) -> String {
        let mut sum = Self(0xcbf2_9ce4_8422_2325);
        values(&mut sum);
        format!("{:016x}", sum.0)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// Numbers, of a count that is always the same.
    pub(super) fn numbers(&mut self, values: impl IntoIterator<Item = f64>) {
        // A zero has one sign.
        values.into_iter().for_each(|value| self.bytes(&(value + 0.0).to_le_bytes()));
    }

    /// One number.
    pub(super) fn number(&mut self, value: f64) {
        self.numbers([value]);
    }

    /// A count.
    pub(super) fn count(&mut self, value: usize) {
        self.number(value as f64);
    }

    /// A seed: both halves, for an f64 does not hold them as one.
    pub(super) fn seed(&mut self, value: u64) {
        self.numbers([(value >> 32) as f64, (value & 0xffff_ffff) as f64]);
    }

    /// Yes or no.
    pub(super) fn flag(&mut self, value: bool) {
        self.count(usize::from(value));
    }

    /// A word.
    pub(super) fn word(&mut self, word: &str) {
        self.bytes(word.as_bytes());
        // No byte of UTF-8.
        self.bytes(&[0xff]);
    }

    /// A list, each item by `add`.
    pub(super) fn list<T>(&mut self, items: &[T], add: impl Fn(&mut Self, &T)) {
        self.count(items.len());
        items.iter().for_each(|item| add(self, item));
    }

    /// What may be missing.
    pub(super) fn option<T>(&mut self, value: Option<T>, add: impl FnOnce(&mut Self, T)) {
        self.flag(value.is_some());
        if let Some(value) = value {
            add(self, value);
        }
    }

    /// A point of a plane.
    pub(super) fn plane_point(&mut self, point: DVec2) {
        self.numbers(point.to_array());
    }

    /// A point of space.
    pub(super) fn point(&mut self, point: DVec3) {
        self.numbers(point.to_array());
    }

    /// A polynomial: degree, centre, scale, and its coefficients by growing power of y, for each by growing power of x.
    pub(super) fn polynomial(&mut self, polynomial: &Poly2) {
        self.count(polynomial.degree());
        self.numbers(polynomial.centre());
        self.numbers(polynomial.scale());
        polynomial.terms().for_each(|(_, _, coefficient)| self.number(coefficient));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the reference implementation's own test suite.
    #[test]
    fn checksums_are_those_of_fnv_1a() {
        for (text, sum) in [("", "cbf29ce484222325"), ("a", "af63dc4c8601ec8c"), ("foobar", "85944171f73967e8")] {
            assert_eq!(Checksum::of(|values| values.bytes(text.as_bytes())), sum, "{text:?}");
        }
    }

    #[test]
    fn values_are_canonical_and_do_not_run_into_one_another() {
        let number = |value: f64| Checksum::of(|values| values.number(value));
        assert!(number(0.0) == number(-0.0) && number(1.0) != number(1.0 + f64::EPSILON));
        let words = |words: &[&str]| Checksum::of(|values| values.list(words, |values, word| values.word(word)));
        assert!(words(&["ab", "c"]) != words(&["a", "bc"]) && words(&[]) != words(&[""]));
        let seed = |value: u64| Checksum::of(|values| values.seed(value));
        assert_ne!(seed(u64::MAX), seed(u64::MAX - 1));
    }
}
