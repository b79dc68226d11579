//! The frame of a plot: two axes around an area, with ticks, values, grid and names.

use super::axis::Axis;
use super::colour::{INK, PALE};
use super::drawing::{Drawing, Item, Label, Stroke};
use super::text::{self, Align, CAP_HEIGHT, Direction, Font, LINE_HEIGHT};
use crate::geom::Rect;
use glam::DVec2;

/// Which way the vertical axis grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Grows {
    /// As in a chart.
    Up,
    /// As in an image.
    Down,
}

/// Fonts and line widths.
#[derive(Debug, Clone, Copy)]
pub(super) struct Style {
    /// Values at the ticks.
    pub(super) values: Font,
    /// Names of the axes.
    pub(super) names: Font,
    /// Width of the frame's line, in px.
    pub(super) line_px: f64,
}

impl Style {
    /// Fonts for values and names of about `size_px`.
    pub(super) fn of_size(size_px: f64) -> Self {
        Self { values: Font::regular(size_px), names: Font::regular(1.08 * size_px), line_px: 0.07 * size_px }
    }

    /// Room that the values and the name take below the plot, in px.
    pub(super) fn room_below(&self) -> f64 {
        (0.6 + CAP_HEIGHT) * self.values.size_px + (LINE_HEIGHT + text::DESCENT) * self.names.size_px
    }

    /// Room that the values and the name of `y` take left of a plot `height` px high, in px.
    pub(super) fn room_left(&self, y: &Axis, height: f64) -> f64 {
        let labels = y.ticks(self.ticks_up(height)).into_iter().filter_map(|tick| tick.label);
        let widest = labels.map(|label| text::width(&label, self.values)).fold(0.0, f64::max);
        widest + 1.0 * self.values.size_px + LINE_HEIGHT * self.names.size_px
    }

    fn ticks_along(&self, width: f64) -> usize {
        (width / (6.0 * self.values.size_px)) as usize
    }

    fn ticks_up(&self, height: f64) -> usize {
        (height / (3.5 * self.values.size_px)) as usize
    }
}

/// A plot's area and its axes.
#[derive(Debug)]
pub(super) struct PlotFrame<'a> {
    /// Where the plot is drawn, in px.
    pub(super) area: Rect,
    /// The horizontal axis.
    pub(super) x: &'a Axis,
    /// The vertical axis.
    pub(super) y: &'a Axis,
    /// Which way the vertical axis grows.
    pub(super) grows: Grows,
}

impl PlotFrame<'_> {
    /// Where (x, y) is drawn, possibly beyond the area; `None` when an axis has no place for it.
    pub(super) fn place(&self, x: f64, y: f64) -> Option<DVec2> {
        Some(self.at(DVec2::new(self.x.share(x)?, self.y.share(y)?)))
    }

    fn at(&self, share: DVec2) -> DVec2 {
        let down = match self.grows {
            Grows::Up => 1.0 - share.y,
            Grows::Down => share.y,
        };
        self.area.min + DVec2::new(share.x, down) * self.area.size()
    }

    /// Draws the grid, to lie under the data.
    pub(super) fn grid(&self, drawing: &mut Drawing, style: &Style) {
        let size = self.area.size();
        let stroke = Stroke::solid(PALE, style.line_px);
        for tick in self.x.ticks(style.ticks_along(size.x)).iter().filter(|tick| tick.label.is_some()) {
            drawing.line(self.at(DVec2::new(tick.share, 0.0)), self.at(DVec2::new(tick.share, 1.0)), stroke);
        }
        for tick in self.y.ticks(style.ticks_up(size.y)).iter().filter(|tick| tick.label.is_some()) {
            drawing.line(self.at(DVec2::new(0.0, tick.share)), self.at(DVec2::new(1.0, tick.share)), stroke);
        }
    }

    /// Draws the frame with ticks, values and the names of the axes; a value that would touch its neighbour is left
    /// out.
    pub(super) fn draw(&self, drawing: &mut Drawing, style: &Style, x_name: &str, y_name: &str) {
        let (area, size, em) = (self.area, self.area.size(), style.values.size_px);
        let stroke = Stroke::solid(INK, style.line_px);
        drawing.frame(&area, stroke);
        let length = |label: &Option<String>| if label.is_some() { 0.35 * em } else { 0.2 * em };

        let mut free_from = f64::NEG_INFINITY;
        for tick in self.x.ticks(style.ticks_along(size.x)) {
            let foot = DVec2::new(self.at(DVec2::new(tick.share, 0.0)).x, area.max.y);
            drawing.line(foot, foot - DVec2::new(0.0, length(&tick.label)), stroke);
            let Some(label) = tick.label else { continue };
            let half = 0.5 * text::width(&label, style.values);
            // The last value may be moved a little, to stay on the sheet.
            let x = foot.x.min(drawing.sheet().max.x - half - 0.1 * em);
            if x - half > free_from {
                let at = DVec2::new(x, foot.y + (0.6 + CAP_HEIGHT) * em);
                drawing.text(label, style.values, INK, at, Align::Middle);
                free_from = x + half + 0.5 * em;
            }
        }
        let mut last = f64::NAN;
        for tick in self.y.ticks(style.ticks_up(size.y)) {
            let foot = DVec2::new(area.min.x, self.at(DVec2::new(0.0, tick.share)).y);
            drawing.line(foot, foot + DVec2::new(length(&tick.label), 0.0), stroke);
            let Some(label) = tick.label else { continue };
            if last.is_nan() || (foot.y - last).abs() > 1.2 * em {
                let at = foot + DVec2::new(-0.5 * em, 0.5 * CAP_HEIGHT * em);
                drawing.text(label, style.values, INK, at, Align::End);
                last = foot.y;
            }
        }

        let below = area.max.y + (0.6 + CAP_HEIGHT) * em + LINE_HEIGHT * style.names.size_px;
        let middle = 0.5 * (area.min + area.max);
        let name = text::shortened(x_name, style.names, size.x);
        drawing.text(name, style.names, INK, DVec2::new(middle.x, below), Align::Middle);
        let name = text::shortened(y_name, style.names, size.y);
        if !name.is_empty() {
            let at = DVec2::new(area.min.x - style.room_left(self.y, size.y) + style.names.size_px, middle.y);
            let (font, colour, align, direction) = (style.names, INK, Align::Middle, Direction::Up);
            drawing.push(Item::Text(Label { text: name, font, colour, at, align, direction }));
        }
    }
}
