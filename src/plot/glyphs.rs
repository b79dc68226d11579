//! Outlines of the glyphs of the figures: `glyphs.txt`, which tools/bake_glyphs.py makes, parsed once.

use std::sync::OnceLock;

/// Font units per em.
pub(super) const UNITS_PER_EM: f32 = 2048.0;

/// One character's shape.
#[derive(Debug)]
pub(super) struct Glyph {
    /// The character.
    pub(super) character: char,
    /// Distance to the next glyph's origin, in font units.
    pub(super) advance: u16,
    /// `x y m`, `x y l`, `x y x y q` (quadratic curve), `z`: each point from the one before (the first from the
    /// origin on the baseline), in font units, y up.
    pub(super) outline: &'static str,
}

/// DejaVu Sans, in the order of the characters.
pub(super) fn regular() -> &'static [Glyph] {
    &tables()[0]
}

/// DejaVu Sans Bold, which has fewer characters, in their order.
pub(super) fn bold() -> &'static [Glyph] {
    &tables()[1]
}

fn tables() -> &'static [Vec<Glyph>; 2] {
    static TABLES: OnceLock<[Vec<Glyph>; 2]> = OnceLock::new();
    TABLES.get_or_init(|| {
        let (regular, bold) = include_str!("glyphs.txt").split_once("[bold]").expect("the file has two tables");
        [regular, bold].map(|table| table.lines().filter_map(parse).collect())
    })
}

/// The glyph of a line; `None` of a heading or a comment.
fn parse(line: &'static str) -> Option<Glyph> {
    let mut fields = line.strip_prefix("U+")?.splitn(3, ' ');
    let character = char::from_u32(u32::from_str_radix(fields.next()?, 16).ok()?)?;
    Some(Glyph { character, advance: fields.next()?.parse().ok()?, outline: fields.next()? })
}

/// Thickness of the letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// Body text.
    Regular,
    /// Headings.
    Bold,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figures are compared byte by byte: no outline may change unseen.
    #[test]
    fn every_glyph_is_read_and_none_has_changed() {
        let tables = [regular(), bold()];
        assert_eq!(tables.map(<[Glyph]>::len), [225, 95]);
        // The hash FNV-1a of 64 bits of a line `character advance outline` for each glyph.
        let mut sum = 0xcbf2_9ce4_8422_2325u64;
        for glyph in tables.into_iter().flatten() {
            let line = format!("{} {} {}\n", glyph.character, glyph.advance, glyph.outline);
            line.bytes().for_each(|byte| sum = (sum ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
        }
        assert_eq!(sum, 0xea66a86224f6c177);
    }
}
