//! The key of a colour map: a horizontal bar with ticks and unit.

use super::axis::Axis;
use super::colour::{INK, Map};
use super::drawing::{Drawing, Item, Stroke};
use super::text::{Align, CAP_HEIGHT, Font};
use super::{picture, text};
use crate::geom::Rect;
use crate::raster::Raster;
use glam::DVec2;

/// Draws the bar over `bar`, its ticks and their values below, and `caption` (what the colour means, with its unit)
/// below these; ends with the lower edge of what was drawn, in px.
pub fn draw(drawing: &mut Drawing, bar: &Rect, axis: &Axis, map: Map, caption: &str, font: Font) -> f64 {
    let steps = (bar.size().x.max(1.0) as usize).min(1024);
    let shares = Raster::from_data(steps, 1, (0..steps).map(|i| (i as f64 + 0.5) / steps as f64).collect());
    drawing.push(Item::Picture(*bar, picture::mapped(&shares, map)));
    let line = Stroke::solid(INK, 0.06 * font.size_px);
    drawing.frame(bar, line);
    let under = bar.max.y + (0.45 + CAP_HEIGHT) * font.size_px;
    let mut free_from = f64::NEG_INFINITY;
    for tick in axis.ticks(8) {
        let at = DVec2::new(bar.min.x + tick.share * bar.size().x, bar.max.y);
        let length = if tick.label.is_some() { 0.3 } else { 0.18 } * font.size_px;
        drawing.line(at, at + DVec2::new(0.0, length), line);
        let half = tick.label.as_ref().map_or(0.0, |label| 0.5 * text::width(label, font));
        if let Some(label) = tick.label.filter(|_| at.x - half > free_from) {
            drawing.text(label, font, INK, DVec2::new(at.x, under), Align::Middle);
            free_from = at.x + half + 0.4 * font.size_px;
        }
    }
    let caption_at = DVec2::new(0.5 * (bar.min.x + bar.max.x), under + text::LINE_HEIGHT * font.size_px);
    drawing.text(text::shortened(caption, font, bar.size().x * 1.2), font, INK, caption_at, Align::Middle);
    caption_at.y + text::DESCENT * font.size_px
}
