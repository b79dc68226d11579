//! The measures of the comparison: two columns, and everything in proportion to the width.

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
    /// Left edges of the two columns; whole px, so that pictures keep their pixels.
    pub(super) left: [f64; 2],
    /// Width of a column; whole px.
    pub(super) column: f64,
    pub(super) title: Font,
    pub(super) head: Font,
    pub(super) strong: Font,
    pub(super) body: Font,
    pub(super) small: Font,
}

impl Layout {
    /// The measures of a figure of this width, which is held within 800..=4000.
    pub(super) fn new(width_px: u32) -> Self {
        let width_px = width_px.clamp(800, 4000);
        let unit = f64::from(width_px) / 2000.0;
        let margin = (48.0 * unit).round();
        let column = ((f64::from(width_px) - 3.0 * margin) / 2.0).floor();
        Self {
            width_px,
            unit,
            margin,
            gap: 34.0 * unit,
            left: [margin, 2.0 * margin + column],
            column,
            title: Font::bold(34.0 * unit),
            head: Font::bold(25.0 * unit),
            strong: Font::bold(22.0 * unit),
            body: Font::regular(22.0 * unit),
            small: Font::regular(20.0 * unit),
        }
    }

    /// The right edge of the right column.
    pub(super) fn right_edge(&self) -> f64 {
        self.left[1] + self.column
    }

    /// Body text as large as a heading.
    pub(super) fn head_regular(&self) -> Font {
        Font::regular(self.head.size_px)
    }
}
