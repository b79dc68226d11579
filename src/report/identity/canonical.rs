//! Canonical JSON, summed up.

use crate::num::poly2::Poly2;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::fmt::{self, Write};

/// A value.
#[derive(Debug)]
pub(super) enum Canonical<'a> {
    Number(f64),
    Flag(bool),
    Word(String),
    List(Vec<Canonical<'a>>),
    Object(CanonicalObject<'a>),
    /// A list of triples, which may be long.
    Points(&'a [DVec3]),
}

/// Values by their keys.
#[derive(Debug, Default)]
pub(super) struct CanonicalObject<'a>(BTreeMap<&'static str, Canonical<'a>>);

impl<'a> CanonicalObject<'a> {
    /// With a value more.
    pub(super) fn with(mut self, key: &'static str, value: impl Into<Canonical<'a>>) -> Self {
        self.0.insert(key, value.into());
        self
    }

    /// With a value more where there is one.
    pub(super) fn maybe(self, key: &'static str, value: Option<impl Into<Canonical<'a>>>) -> Self {
        match value {
            Some(value) => self.with(key, value),
            None => self,
        }
    }

    /// The hash FNV-1a of 64 bits (Fowler, Noll, Vo) of its text, in hexadecimal.
    pub(super) fn checksum(&self) -> String {
        let mut hash = Fnv(FNV_START);
        self.write(&mut hash).expect("a hash takes any text");
        format!("{:016x}", hash.0)
    }

    fn write(&self, out: &mut impl Write) -> fmt::Result {
        for (k, (key, value)) in self.0.iter().enumerate() {
            write!(out, "{}\"{key}\":", if k == 0 { '{' } else { ',' })?;
            value.write(out)?;
        }
        out.write_str(if self.0.is_empty() { "{}" } else { "}" })
    }
}

impl fmt::Display for CanonicalObject<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f)
    }
}

impl Canonical<'_> {
    fn write(&self, out: &mut impl Write) -> fmt::Result {
        match self {
            Self::Number(value) => number(out, *value),
            Self::Flag(value) => write!(out, "{value}"),
            Self::Word(word) => out.write_str(&serde_json::Value::from(word.as_str()).to_string()),
            Self::Object(object) => object.write(out),
            Self::List(items) => list(out, items, |out, item| item.write(out)),
            Self::Points(points) => list(out, points, |out, point| list(out, &point.to_array(), |o, v| number(o, *v))),
        }
    }
}

fn number(out: &mut impl Write, value: f64) -> fmt::Result {
    debug_assert!(value.is_finite(), "JSON has no {value}");
    // A zero has one sign.
    write!(out, "{:e}", value + 0.0)
}

fn list<W: Write, T>(out: &mut W, items: &[T], write: impl Fn(&mut W, &T) -> fmt::Result) -> fmt::Result {
    out.write_char('[')?;
    for (k, item) in items.iter().enumerate() {
        if k > 0 {
            out.write_char(',')?;
        }
        write(out, item)?;
    }
    out.write_char(']')
}

/// The hash FNV-1a of 64 bits of words of 32 bits, byte by byte from the lowest, in hexadecimal.
pub(super) fn checksum_of_bits(words: impl Iterator<Item = u32>) -> String {
    checksum_of_bytes(words.flat_map(u32::to_le_bytes))
}

/// The hashes FNV-1a of 64 bits of the first, the second and the third numbers of triples, each byte by byte from the lowest, in
/// hexadecimal: three at a time, since each byte waits for the one before it.
pub(super) fn checksums_of_columns<const BYTES: usize>(triples: impl Iterator<Item = [[u8; BYTES]; 3]>) -> String {
    let mut hashes = [const { Fnv(FNV_START) }; 3];
    for triple in triples {
        for k in 0..BYTES {
            hashes.iter_mut().zip(&triple).for_each(|(hash, bytes)| hash.add(bytes[k]));
        }
    }
    hashes.map(|hash| format!("{:016x}", hash.0)).join(" ")
}

/// The hash FNV-1a of 64 bits of bytes, in hexadecimal.
pub fn checksum_of_bytes(bytes: impl Iterator<Item = u8>) -> String {
    let mut hash = Fnv(FNV_START);
    bytes.for_each(|byte| hash.add(byte));
    format!("{:016x}", hash.0)
}

struct Fnv(u64);

/// The hash of nothing.
const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

impl Fnv {
    fn add(&mut self, byte: u8) {
        self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
}

impl Write for Fnv {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| self.add(byte));
        Ok(())
    }
}

impl From<f64> for Canonical<'_> {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<u32> for Canonical<'_> {
    fn from(value: u32) -> Self {
        Self::Number(f64::from(value))
    }
}

impl From<usize> for Canonical<'_> {
    fn from(value: usize) -> Self {
        Self::Number(value as f64)
    }
}

impl From<bool> for Canonical<'_> {
    fn from(value: bool) -> Self {
        Self::Flag(value)
    }
}

impl From<&str> for Canonical<'_> {
    fn from(word: &str) -> Self {
        Self::Word(word.to_owned())
    }
}

impl<const N: usize> From<[f64; N]> for Canonical<'_> {
    fn from(values: [f64; N]) -> Self {
        Self::List(values.into_iter().map(Self::Number).collect())
    }
}

impl From<DVec2> for Canonical<'_> {
    fn from(point: DVec2) -> Self {
        point.to_array().into()
    }
}

impl From<DVec3> for Canonical<'_> {
    fn from(point: DVec3) -> Self {
        point.to_array().into()
    }
}

impl<'a> From<CanonicalObject<'a>> for Canonical<'a> {
    fn from(object: CanonicalObject<'a>) -> Self {
        Self::Object(object)
    }
}

impl FromIterator<f64> for Canonical<'_> {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        Self::List(values.into_iter().map(Self::Number).collect())
    }
}

impl<'a> FromIterator<CanonicalObject<'a>> for Canonical<'a> {
    fn from_iter<I: IntoIterator<Item = CanonicalObject<'a>>>(objects: I) -> Self {
        Self::List(objects.into_iter().map(Self::Object).collect())
    }
}

impl From<&Poly2> for Canonical<'_> {
    /// Coefficients come by growing power of y, for each by growing power of x.
    fn from(polynomial: &Poly2) -> Self {
        let coefficients = polynomial.terms().map(|(_, _, coefficient)| Self::Number(coefficient)).collect();
        CanonicalObject::default()
            .with("degree", polynomial.degree())
            .with("centre", polynomial.centre())
            .with("scale", polynomial.scale())
            .with("coefficients", Self::List(coefficients))
            .into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the reference implementation's own test suite.
    #[test]
    fn checksums_are_those_of_fnv_1a() {
        for (text, sum) in
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)]
        {
            let mut hash = Fnv(FNV_START);
            hash.write_str(text).unwrap();
            assert_eq!(hash.0, sum, "{text:?}");
        }
    }

    #[test]
    fn columns_have_checksums_of_their_own() {
        let triples = [[1u32, 2, 3], [4, 5, 6]];
        let columns = [[1, 4], [2, 5], [3, 6]].map(|column| checksum_of_bits(column.into_iter()));
        assert_eq!(checksums_of_columns(triples.iter().map(|t| t.map(u32::to_le_bytes))), columns.join(" "));
    }

    #[test]
    fn the_text_is_canonical_and_is_json() {
        let inner = CanonicalObject::default().with("b", "a \"word\"").with("a", -0.0);
        let points = [DVec3::new(35.0, 0.1 + 0.2, 1e-300), DVec3::NEG_X];
        let object = CanonicalObject::default()
            .with("z", inner)
            .with("list", [1.0, 480.0])
            .with("flag", true)
            .with("points", Canonical::Points(&points))
            .maybe("missing", None::<f64>)
            .maybe("there", Some(5e-324));
        let expected = concat!(
            r#"{"flag":true,"list":[1e0,4.8e2],"points":[[3.5e1,3.0000000000000004e-1,1e-300],[-1e0,0e0,0e0]],"#,
            r#""there":5e-324,"z":{"a":0e0,"b":"a \"word\""}}"#
        );
        assert_eq!(object.to_string(), expected);
        let read: serde_json::Value = serde_json::from_str(expected).unwrap();
        assert_eq!(read["points"][0][1].as_f64(), Some(0.1 + 0.2));
        assert_eq!(CanonicalObject::default().to_string(), "{}");
    }
}
