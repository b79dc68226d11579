//! The measures of the comparison: columns of panels, and everything in proportion to the width.

use crate::plot::text::Font;

/// Measures in px.
pub(super) struct Layout {
    pub(super) width_px: u32,
    /// One px of a figure 2000 px wide.
    pub(super) unit: f64,
    /// Empty border, and the space between the columns.
    pub(super) margin: f64,
    /// Space between the blocks of a column.
    pub(super) gap: f64,
    /// Left edges of the columns of panels; whole px, so that pictures keep their pixels.
    pub(super) left: Vec<f64>,
    /// Width of a column; whole px.
    pub(super) column: f64,
    /// Left edge and width of the right half of the page, for what stands beside something else.
    pub(super) right_half: f64,
    pub(super) half: f64,
    pub(super) title: Font,
    pub(super) head: Font,
    pub(super) strong: Font,
    pub(super) body: Font,
    pub(super) small: Font,
}

impl Layout {
    /// The measures of a figure of this width, which is held within 800..=4000, with so many panels: three stand in one row,
    /// any other number in rows of two.
    pub(super) fn new(width_px: u32, panels: usize) -> Self {
        let width_px = width_px.clamp(800, 4000);
        let unit = f64::from(width_px) / 2000.0;
        let margin = (48.0 * unit).round();
        let in_columns = |n: f64| ((f64::from(width_px) - (n + 1.0) * margin) / n).floor();
        let columns = if panels == 3 { 3 } else { 2 };
        let (column, half) = (in_columns(columns as f64), in_columns(2.0));
        Self {
            width_px,
            unit,
            margin,
            gap: 34.0 * unit,
            left: (0..columns).map(|k| margin + k as f64 * (margin + column)).collect(),
            column,
            right_half: 2.0 * margin + half,
            half,
            title: Font::bold(34.0 * unit),
            head: Font::bold(25.0 * unit),
            strong: Font::bold(22.0 * unit),
            body: Font::regular(22.0 * unit),
            small: Font::regular(20.0 * unit),
        }
    }

    /// The right edge of the page's content.
    pub(super) fn right_edge(&self) -> f64 {
        self.right_half + self.half
    }

    /// Body text as large as a heading.
    pub(super) fn head_regular(&self) -> Font {
        Font::regular(self.head.size_px)
    }
}

/// The letter of panel `k`.
pub(super) fn letter(k: usize) -> char {
    char::from(b'a' + (k % 26) as u8)
}
