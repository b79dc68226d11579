//! Which instrument made a picture, so that no other one's truth is taken for its own.

use crate::scene::Scene;
use crate::system::System;
use serde_json::{Map, Value};
use std::fmt::{Debug, Write};

/// What the truth of a picture depends on: for each part of the scene and of the `system` built from it, its name and a
/// checksum, in hexadecimal. A checksum is that of the part's values as this version of the program writes them; of effects
/// those count that are kept.
pub(super) fn parts(scene: &Scene, system: &System) -> Map<String, Value> {
    let part = |name: &str, value: &dyn Debug| (name.to_owned(), Value::from(checksum(value)));
    [
        part("camera", &scene.camera),
        part("prism", &scene.prism),
        part("board", &scene.board),
        part("effects", system.effects()),
    ]
    .into_iter()
    .collect()
}

/// The parts that are not those of `said`, in words.
pub(super) fn others(scene: &Scene, system: &System, said: &Value) -> Vec<String> {
    parts(scene, system).into_iter().filter(|(name, sum)| said[name] != *sum).map(|(name, _)| name).collect()
}

fn checksum(value: &dyn Debug) -> String {
    let mut sum = Fnv1a::EMPTY;
    // This writer never fails.
    let _ = write!(sum, "{value:?}");
    format!("{:016x}", sum.0)
}

/// The hash FNV-1a of 64 bits (Fowler, Noll, Vo) of what is written.
struct Fnv1a(u64);

impl Fnv1a {
    /// That of nothing.
    const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);
}

impl Write for Fnv1a {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        Ok(())
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
            let mut found = Fnv1a::EMPTY;
            let _ = found.write_str(text);
            assert_eq!(found.0, sum, "{text:?}");
        }
    }
}
