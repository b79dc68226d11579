#!/usr/bin/env python3
"""Bakes the outlines of the glyphs that the figures use into src/plot/glyphs.txt.

Run once, by hand, when a character is added; the build needs neither Python nor a font. A test of
`src/plot/glyphs.rs` holds the count and the checksum of the outlines:

    pip install fonttools
    apt-get install fonts-dejavu-core
    python3 tools/bake_glyphs.py

The outlines are those of DejaVu Sans and DejaVu Sans Bold 2.37 (https://dejavu-fonts.github.io/), a derivative of
Bitstream Vera. Their licence allows copies, subsets and changed forms in other software as long as its notice goes
along (src/plot/GLYPHS-LICENSE.txt) and a changed font is not named after Bitstream or Vera.
"""

from pathlib import Path

from fontTools.pens.basePen import BasePen
from fontTools.ttLib import TTFont

FONTS = Path("/usr/share/fonts/truetype/dejavu")
TARGET = Path(__file__).resolve().parent.parent / "src/plot/glyphs.txt"

ASCII = "".join(map(chr, range(0x20, 0x7F)))
LATIN = "".join(map(chr, range(0xC0, 0x100)))
SYMBOLS = "µ±×÷°·…–—′″" "αβγδεθκλμνπρσφωΔΣΩ" "←↑→↓↔↕" "≤≥≈≠∞√∂−∥⊥" "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻ⁿ" "₀₁₂₃₄₅₆₇₈₉"


class Outline(BasePen):
    """Writes an outline as text: x y m, x y l, x y x y q, z, each point from the one before, in font units, y up."""

    def __init__(self, glyphs):
        super().__init__(glyphs)
        self.steps = []
        self.last = (0, 0)

    def _write(self, step, *points):
        text = ""
        for x, y in ((round(x), round(y)) for x, y in points):
            text += f" {x - self.last[0]} {y - self.last[1]}"
            self.last = (x, y)
        self.steps.append(text[1:] + step)

    def _moveTo(self, p):
        self._write("m", p)

    def _lineTo(self, p):
        self._write("l", p)

    def _qCurveToOne(self, control, p):
        self._write("q", control, p)

    def _curveToOne(self, *points):
        raise ValueError("a TrueType outline has no cubic curves")

    def _closePath(self):
        self.steps.append("z")


def table(heading, file, characters):
    font = TTFont(FONTS / file)
    names, glyphs, units = font.getBestCmap(), font.getGlyphSet(), font["head"].unitsPerEm
    assert units == 2048, units
    rows = []
    for character in sorted(set(characters)):
        pen = Outline(glyphs)
        glyph = glyphs[names[ord(character)]]
        glyph.draw(pen)
        rows.append(f"U+{ord(character):04X} {round(glyph.width)} {''.join(pen.steps)}\n")
    return f"{heading}\n{''.join(rows)}"


HEADER = """\
# Outlines of the glyphs of the figures. Made by tools/bake_glyphs.py from DejaVu Sans 2.37; do not edit by hand.
# The notice of the font's licence is in GLYPHS-LICENSE.txt beside this file.
# A line for each glyph, in the order of the characters: code point, advance, outline.
"""

if __name__ == "__main__":
    regular = table("[regular] DejaVu Sans", "DejaVuSans.ttf", ASCII + LATIN + SYMBOLS)
    bold = table("[bold] DejaVu Sans Bold; other characters are taken from the regular weight", "DejaVuSans-Bold.ttf", ASCII)
    TARGET.write_text(HEADER + regular + bold, encoding="utf-8")
    print(f"{TARGET.name}: {TARGET.stat().st_size} bytes")
