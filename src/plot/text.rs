//! Words in a figure: their size, their outline, and how they are shortened or broken to fit.
//!
//! The glyphs are baked into the program (`glyphs`), so that a figure has the same pixels on every machine.

use super::glyphs::{Glyph, UNITS_PER_EM, Weight, bold, regular};
use crate::geom::Rect;
use glam::DVec2;
use tiny_skia::{Path, PathBuilder};

/// Height of a capital letter over the baseline, in em.
pub(crate) const CAP_HEIGHT: f64 = 0.729;
/// What every glyph keeps within, above and below the baseline, in em (accented capitals, descenders).
pub const ASCENT: f64 = 0.95;
/// See [`ASCENT`].
pub(crate) const DESCENT: f64 = 0.24;
/// Distance between the baselines of two lines, in em.
pub(crate) const LINE_HEIGHT: f64 = 1.35;
/// Width of the box that stands for a character without a glyph, in em.
const BOX_WIDTH: f64 = 0.6;

/// Which point of the text its position names, along the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// The position is where the text starts.
    Start,
    /// The position is the middle of the text.
    Middle,
    /// The position is where the text ends.
    End,
}

/// Which way the line of text runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// To the right.
    Right,
    /// Upwards, as the name of a vertical axis.
    Up,
}

/// Size and weight of letters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Font {
    /// Em, in px.
    pub size_px: f64,
    /// Thickness.
    pub weight: Weight,
}

impl Font {
    /// Body text of `size_px`.
    pub const fn regular(size_px: f64) -> Self {
        Self { size_px, weight: Weight::Regular }
    }

    /// A heading of `size_px`.
    pub const fn bold(size_px: f64) -> Self {
        Self { size_px, weight: Weight::Bold }
    }
}

/// Width of one line of text, in px.
pub fn width(text: &str, font: Font) -> f64 {
    text.chars().map(|c| advance(c, font.weight)).sum::<f64>() * font.size_px
}

/// The rectangle that a line of text keeps within, in px, with its anchor at `at` on the baseline.
pub fn bounds(text: &str, font: Font, at: DVec2, align: Align, direction: Direction) -> Rect {
    let (size, length) = (font.size_px, width(text, font));
    let start = -length * share_before(align);
    match direction {
        Direction::Right => {
            Rect { min: at + DVec2::new(start, -ASCENT * size), max: at + DVec2::new(start + length, DESCENT * size) }
        }
        Direction::Up => {
            Rect { min: at + DVec2::new(-ASCENT * size, -start - length), max: at + DVec2::new(DESCENT * size, -start) }
        }
    }
}

/// The filled outline of a line of text, in px; `None` when nothing of it is visible.
///
/// A character without a glyph is drawn as a box.
pub fn outline(text: &str, font: Font, at: DVec2, align: Align, direction: Direction) -> Option<Path> {
    let mut pen = Pen { path: PathBuilder::new(), scale: font.size_px as f32 / UNITS_PER_EM, at, direction };
    let mut along = -width(text, font) * share_before(align);
    for c in text.chars() {
        match glyph(c, font.weight) {
            Some(glyph) => pen.glyph(glyph.outline, (along / font.size_px) as f32 * UNITS_PER_EM),
            None => pen.glyph(MISSING, (along / font.size_px) as f32 * UNITS_PER_EM),
        }
        along += advance(c, font.weight) * font.size_px;
    }
    pen.path.finish()
}

/// The text, or as much of it as fits into `room_px`, then an ellipsis; empty when not even that fits.
pub(crate) fn shortened(text: &str, font: Font, room_px: f64) -> String {
    if width(text, font) <= room_px {
        return text.to_owned();
    }
    let mut kept = String::new();
    for c in text.chars() {
        kept.push(c);
        if width(&kept, font) + width("…", font) > room_px {
            kept.pop();
            kept.push('…');
            break;
        }
    }
    if width(&kept, font) <= room_px { kept } else { String::new() }
}

/// The text broken at spaces into lines of at most `room_px`, at most `lines` of them; what does not fit is cut off
/// with an ellipsis.
pub(crate) fn wrapped(text: &str, font: Font, room_px: f64, lines: usize) -> Vec<String> {
    let mut broken: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match broken.last_mut() {
            Some(line) if broken_fits(line, word, font, room_px) => {
                line.push(' ');
                line.push_str(word);
            }
            _ => broken.push(word.to_owned()),
        }
    }
    if broken.len() > lines {
        let rest = broken.split_off(lines.saturating_sub(1)).join(" ");
        broken.push(rest);
    }
    broken.iter().take(lines).map(|line| shortened(line, font, room_px)).collect()
}

fn broken_fits(line: &str, word: &str, font: Font, room_px: f64) -> bool {
    width(line, font) + width(" ", font) + width(word, font) <= room_px
}

/// A box, in the notation of the baked outlines: outer edge, then the hole the other way round.
const MISSING: &str = "150 0m0 1493l930 0l0 -1493lz-800 130m670 0l0 1233l-670 0lz";

/// Share of the text's length that lies before its anchor.
fn share_before(align: Align) -> f64 {
    match align {
        Align::Start => 0.0,
        Align::Middle => 0.5,
        Align::End => 1.0,
    }
}

fn glyph(character: char, weight: Weight) -> Option<&'static Glyph> {
    let find = |table: &'static [Glyph]| {
        table.binary_search_by_key(&character, |glyph| glyph.character).ok().map(|found| &table[found])
    };
    match weight {
        Weight::Regular => find(regular()),
        Weight::Bold => find(bold()).or_else(|| find(regular())),
    }
}

/// Distance to the next glyph's origin, in em.
fn advance(character: char, weight: Weight) -> f64 {
    glyph(character, weight).map_or(BOX_WIDTH, |glyph| f64::from(glyph.advance) / f64::from(UNITS_PER_EM))
}

/// Puts outlines in font units (y up) into a path in px (y down).
struct Pen {
    path: PathBuilder,
    scale: f32,
    at: DVec2,
    direction: Direction,
}

impl Pen {
    fn place(&self, x: f32, y: f32) -> (f32, f32) {
        let (along, up) = (x * self.scale, y * self.scale);
        match self.direction {
            Direction::Right => (self.at.x as f32 + along, self.at.y as f32 - up),
            Direction::Up => (self.at.x as f32 - up, self.at.y as f32 - along),
        }
    }

    /// Adds one outline, its origin `along` font units along the line.
    fn glyph(&mut self, outline: &str, along: f32) {
        let mut last = (along, 0.0);
        for step in outline.split_inclusive(|c: char| c.is_ascii_lowercase()) {
            let (numbers, kind) = step.split_at(step.len() - 1);
            let mut numbers = numbers.split(' ').filter_map(|n| n.parse::<f32>().ok());
            let mut point = || {
                let (x, y) = (last.0 + numbers.next()?, last.1 + numbers.next()?);
                last = (x, y);
                Some(self.place(x, y))
            };
            match (kind, point(), point()) {
                ("m", Some(p), _) => self.path.move_to(p.0, p.1),
                ("l", Some(p), _) => self.path.line_to(p.0, p.1),
                ("q", Some(c), Some(p)) => self.path.quad_to(c.0, c.1, p.0, p.1),
                _ => self.path.close(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FONT: Font = Font::regular(20.0);

    #[test]
    fn tables_are_sorted_and_hold_ascii() {
        for table in [regular(), bold()] {
            assert!(table.windows(2).all(|pair| pair[0].character < pair[1].character));
            assert!((' '..='~').all(|c| table.iter().any(|glyph| glyph.character == c)));
        }
        assert!("µ±×°·…αλσΔ←→≤⁻⁹₂ö".chars().all(|c| glyph(c, Weight::Bold).is_some()));
    }

    #[test]
    fn every_glyph_keeps_within_its_bounds() {
        for (table, weight) in [(regular(), Weight::Regular), (bold(), Weight::Bold)] {
            for g in table {
                let text = g.character.to_string();
                for direction in [Direction::Right, Direction::Up] {
                    let font = Font { size_px: 100.0, weight };
                    let room = bounds(&text, font, DVec2::new(300.0, 300.0), Align::Middle, direction).grown(8.0);
                    if let Some(path) = outline(&text, font, DVec2::new(300.0, 300.0), Align::Middle, direction) {
                        let b = path.bounds();
                        assert!(
                            room.contains(DVec2::new(b.left().into(), b.top().into()))
                                && room.contains(DVec2::new(b.right().into(), b.bottom().into())),
                            "{text} {direction:?}: {b:?} leaves {room:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn an_h_is_as_high_as_a_capital_and_stands_on_the_baseline() {
        let b = outline("H", Font::regular(100.0), DVec2::new(10.0, 200.0), Align::Start, Direction::Right)
            .expect("H is visible")
            .bounds();
        assert!((f64::from(b.bottom()) - 200.0).abs() < 1e-3);
        assert!((f64::from(b.height()) - 100.0 * CAP_HEIGHT).abs() < 0.1);
    }

    #[test]
    fn alignment_moves_the_text_by_its_width() {
        let at = DVec2::new(100.0, 50.0);
        let left = |align| bounds("prism", FONT, at, align, Direction::Right).min.x;
        assert_eq!(left(Align::Start), 100.0);
        assert!((left(Align::End) - (100.0 - width("prism", FONT))).abs() < 1e-12);
        assert!((left(Align::Middle) - 0.5 * (left(Align::Start) + left(Align::End))).abs() < 1e-12);
    }

    #[test]
    fn an_unknown_character_is_a_box() {
        let path = outline("稜", FONT, DVec2::ZERO, Align::Start, Direction::Right).expect("the box is visible");
        assert!(path.bounds().width() > 5.0);
        assert!((width("稜", FONT) - 12.0).abs() < 1e-12);
        assert!(outline(" ", FONT, DVec2::ZERO, Align::Start, Direction::Right).is_none());
    }

    #[test]
    fn shortened_and_wrapped_text_fits() {
        let text = "The freeform prism keeps every line straight to within a tenth of a pixel";
        for room in [0.0, 5.0, 20.0, 33.0, 150.0, 2000.0] {
            assert!(width(&shortened(text, FONT, room), FONT) <= room);
            let lines = wrapped(text, FONT, room, 2);
            assert!(lines.len() <= 2 && lines.iter().all(|line| width(line, FONT) <= room), "{lines:?}");
        }
        assert_eq!(shortened(text, FONT, 2000.0), text);
        assert_eq!(wrapped(text, FONT, 400.0, 9).join(" "), text);
    }
}
