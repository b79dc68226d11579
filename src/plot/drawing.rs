//! A figure as a list of shapes, drawn in order: what every figure is laid out into, and what both back ends
//! ([`crate::plot::canvas`] for pixels, [`crate::plot::svg`] for text) draw.
//!
//! Positions are px from the top left, y down; pixel (i, j) covers `[i, i+1) x [j, j+1)`.

use super::colour::Rgb;
use super::text::{self, Align, Direction, Font};
use crate::geom::Rect;
use crate::raster::Raster;
use glam::DVec2;

/// Largest width and height of a figure, in px: the rasteriser's coordinates end at 8191.
pub const LARGEST_SIDE_PX: u32 = 8000;

/// A line's style.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Colour.
    pub colour: Rgb,
    /// Width in px; a pixel back end draws at least 1.
    pub width_px: f64,
    /// Length of a dash and of the gap after it, in px; `None` for a whole line.
    pub dash_px: Option<[f64; 2]>,
}

impl Stroke {
    /// A whole line.
    pub const fn solid(colour: Rgb, width_px: f64) -> Self {
        Self { colour, width_px, dash_px: None }
    }

    /// A dashed line.
    pub(crate) const fn dashed(colour: Rgb, width_px: f64, dash_px: [f64; 2]) -> Self {
        Self { colour, width_px, dash_px: Some(dash_px) }
    }
}

/// A line of text.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// The words.
    pub text: String,
    /// Size and weight.
    pub font: Font,
    /// Colour.
    pub colour: Rgb,
    /// Anchor on the baseline.
    pub at: DVec2,
    /// Where on the line the anchor is.
    pub align: Align,
    /// Which way the line runs.
    pub direction: Direction,
}

impl Label {
    /// The rectangle that the text keeps within.
    pub fn bounds(&self) -> Rect {
        text::bounds(&self.text, self.font, self.at, self.align, self.direction)
    }
}

/// One shape.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// A filled rectangle.
    Fill(Rect, Rgb),
    /// A line through points.
    Line(Vec<DVec2>, Stroke),
    /// A filled polygon, closed without repeating its first point.
    Polygon(Vec<DVec2>, Rgb),
    /// A disc: centre, radius.
    Disc(DVec2, f64, Rgb),
    /// A line of text.
    Text(Label),
    /// A picture stretched over a rectangle, each of its pixels a rectangle of one colour.
    Picture(Rect, Raster<Rgb>),
}

/// A figure: a white sheet of `width_px` x `height_px` and what is on it, in the order of drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    width_px: u32,
    height_px: u32,
    items: Vec<Item>,
}

impl Drawing {
    /// An empty sheet; each side is held within 1..=[`LARGEST_SIDE_PX`].
    pub fn new(width_px: u32, height_px: u32) -> Self {
        let side = |px: u32| px.clamp(1, LARGEST_SIDE_PX);
        Self { width_px: side(width_px), height_px: side(height_px), items: Vec::new() }
    }

    /// The same shapes on a sheet of another height, held within 1..=[`LARGEST_SIDE_PX`].
    #[must_use]
    pub(crate) fn with_height(self, height_px: u32) -> Self {
        Self { items: self.items, ..Self::new(self.width_px, height_px) }
    }

    /// Width in px.
    pub fn width_px(&self) -> u32 {
        self.width_px
    }

    /// Height in px.
    pub fn height_px(&self) -> u32 {
        self.height_px
    }

    /// All shapes, in the order of drawing.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// The whole sheet.
    pub fn sheet(&self) -> Rect {
        Rect { min: DVec2::ZERO, max: DVec2::new(self.width_px.into(), self.height_px.into()) }
    }

    /// Adds a shape.
    pub fn push(&mut self, item: Item) {
        self.items.push(item);
    }

    /// Adds a line from `a` to `b`.
    pub fn line(&mut self, a: DVec2, b: DVec2, stroke: Stroke) {
        self.push(Item::Line(vec![a, b], stroke));
    }

    /// Adds all that is on another sheet, its upper left corner at `at`.
    pub(crate) fn embed(&mut self, other: &Self, at: DVec2) {
        let rect = |r: &Rect| Rect { min: r.min + at, max: r.max + at };
        let points = |points: &[DVec2]| points.iter().map(|p| *p + at).collect();
        self.items.extend(other.items.iter().map(|item| match item {
            Item::Fill(area, colour) => Item::Fill(rect(area), *colour),
            Item::Line(line, stroke) => Item::Line(points(line), *stroke),
            Item::Polygon(corners, colour) => Item::Polygon(points(corners), *colour),
            Item::Disc(centre, radius, colour) => Item::Disc(*centre + at, *radius, *colour),
            Item::Text(label) => Item::Text(Label { at: label.at + at, ..label.clone() }),
            Item::Picture(area, picture) => Item::Picture(rect(area), picture.clone()),
        }));
    }

    /// Adds the part of the line through `points` that lies within `clip`.
    pub(crate) fn line_within(&mut self, clip: &Rect, points: &[DVec2], stroke: Stroke) {
        for part in clipped(clip, points) {
            self.push(Item::Line(part, stroke));
        }
    }

    /// Adds the outline of a rectangle.
    pub fn frame(&mut self, rect: &Rect, stroke: Stroke) {
        let Rect { min, max } = *rect;
        self.push(Item::Line(vec![min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y), min], stroke));
    }

    /// Adds text that runs to the right; nothing when it is empty.
    pub fn text(&mut self, text: impl Into<String>, font: Font, colour: Rgb, at: DVec2, align: Align) {
        let text = text.into();
        if !text.is_empty() {
            self.push(Item::Text(Label { text, font, colour, at, align, direction: Direction::Right }));
        }
    }

    /// Adds an arrow that ends in a filled head at `tip`; the head is at most `head_px` long and at most half of the
    /// arrow, so that a short arrow still shows its direction.
    pub fn arrow(&mut self, tail: DVec2, tip: DVec2, stroke: Stroke, head_px: f64) {
        let length = (tip - tail).length();
        let head = head_px.min(0.5 * length);
        let Some(along) = (tip - tail).try_normalize() else { return };
        let (neck, side) = (tip - along * head, along.perp() * (0.38 * head + 0.5 * stroke.width_px));
        self.line(tail, neck + along * (0.2 * head), stroke);
        self.push(Item::Polygon(vec![tip, neck + side, neck - side], stroke.colour));
    }
}

/// The parts of the line through `points` that lie within `clip`, each a line of its own. A point that is not finite
/// breaks the line.
pub fn clipped(clip: &Rect, points: &[DVec2]) -> Vec<Vec<DVec2>> {
    let mut parts: Vec<Vec<DVec2>> = Vec::new();
    for pair in points.windows(2) {
        let Some((a, b)) = clipped_segment(clip, pair[0], pair[1]) else { continue };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&a) => part.push(b),
            _ => parts.push(vec![a, b]),
        }
    }
    parts
}

/// The part of the segment from `a` to `b` within `clip` (Liang and Barsky 1984).
fn clipped_segment(clip: &Rect, a: DVec2, b: DVec2) -> Option<(DVec2, DVec2)> {
    if !(a.is_finite() && b.is_finite()) {
        return None;
    }
    let d = b - a;
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (towards, room) in
        [(-d.x, a.x - clip.min.x), (d.x, clip.max.x - a.x), (-d.y, a.y - clip.min.y), (d.y, clip.max.y - a.y)]
    {
        if towards == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if towards < 0.0 {
            enter = enter.max(room / towards);
        } else {
            leave = leave.min(room / towards);
        }
    }
    let end = |t: f64| (a + d * t).clamp(clip.min, clip.max);
    (enter <= leave).then(|| (if enter == 0.0 { a } else { end(enter) }, if leave == 1.0 { b } else { end(leave) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Rect = Rect { min: DVec2::ZERO, max: DVec2::new(10.0, 5.0) };

    #[test]
    fn a_line_is_cut_at_the_border_and_stays_one_line_inside() {
        let line = [DVec2::new(-10.0, 2.0), DVec2::new(5.0, 2.0), DVec2::new(5.0, 20.0)];
        assert_eq!(clipped(&BOX, &line), vec![vec![DVec2::new(0.0, 2.0), DVec2::new(5.0, 2.0), DVec2::new(5.0, 5.0)]]);
    }

    #[test]
    fn a_line_outside_or_without_number_is_gone() {
        let far = DVec2::new(1e300, 1e300);
        assert!(clipped(&BOX, &[DVec2::new(-1.0, -1.0), DVec2::new(-1.0, 9.0)]).is_empty());
        assert!(clipped(&BOX, &[DVec2::new(1.0, 1.0), DVec2::NAN, DVec2::new(2.0, 2.0)]).is_empty());
        assert!(clipped(&BOX, &[-far, far]).iter().flatten().all(|&p| BOX.contains(p)));
    }

    #[test]
    fn a_short_arrow_keeps_its_direction_and_none_has_none() {
        let mut drawing = Drawing::new(100, 100);
        drawing.arrow(DVec2::splat(50.0), DVec2::new(51.0, 50.0), Stroke::solid([0; 3], 1.0), 10.0);
        let Some(Item::Polygon(head, _)) = drawing.items().last() else { panic!("an arrow ends in a head") };
        assert!(head.iter().all(|p| p.x >= 50.5 && p.x <= 51.0));
        let count = drawing.items().len();
        drawing.arrow(DVec2::splat(50.0), DVec2::splat(50.0), Stroke::solid([0; 3], 1.0), 10.0);
        assert_eq!(drawing.items().len(), count);
    }

    #[test]
    fn a_sheet_has_a_bounded_size() {
        let drawing = Drawing::new(0, u32::MAX);
        assert_eq!((drawing.width_px(), drawing.height_px()), (1, LARGEST_SIDE_PX));
    }
}
