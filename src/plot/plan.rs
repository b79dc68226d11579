//! Plans: lines in a plane, drawn to scale, one panel below the other.

use super::axis::{Axis, Scale};
use super::colour::{INK, Rgb, WHITE};
use super::drawing::{Drawing, Item, Stroke};
use super::frame::{Grows, PlotFrame, Style};
use super::text::{self, Align, Direction, Font};
use crate::geom::Rect;
use glam::DVec2;

/// Highest panel over its width.
const TALLEST: f64 = 0.75;

/// A line of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanLine {
    /// Its points, in the unit of the axes.
    pub points: Vec<DVec2>,
    /// Its colour.
    pub colour: Rgb,
    /// Its width, as a share of a thin line's.
    pub weight: f64,
    /// Whether it is dashed.
    pub dashed: bool,
}

/// A panel: a part of the plane, with one scale for both axes.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanPanel {
    /// Name: "from above".
    pub name: String,
    /// What is shown at least, y up; it is widened to the panel's shape.
    pub area: Rect,
    /// Names of the axes with their unit.
    pub axes: [String; 2],
    /// The lines.
    pub lines: Vec<PlanLine>,
    /// Words at places.
    pub words: Vec<(DVec2, String)>,
}

/// Lays the panels out, `width_px` (held within 400..=4000) wide.
pub fn draw(title: &str, panels: &[PlanPanel], width_px: u32) -> Drawing {
    let width_px = width_px.clamp(400, 4000);
    let (width, em) = (f64::from(width_px), f64::from(width_px) / 95.0);
    let style = Style::of_size(em);
    let mut drawing = Drawing::new(width_px, 1);
    let font = Font::bold(1.3 * em);
    drawing.text(text::shortened(title, font, width - 2.0 * em), font, INK, DVec2::new(em, 2.2 * em), Align::Start);
    let mut top = 3.2 * em;
    for panel in panels {
        top = draw_panel(&mut drawing, &style, em, top, panel);
    }
    drawing.with_height(libm::ceil(top) as u32)
}

/// Draws a panel from `top` on, and ends with where the next one begins.
fn draw_panel(drawing: &mut Drawing, style: &Style, em: f64, top: f64, panel: &PlanPanel) -> f64 {
    let width = f64::from(drawing.width_px());
    let name = Font::bold(em);
    drawing.text(panel.name.clone(), name, INK, DVec2::new(em, top + 1.2 * em), Align::Start);

    // Find the scale: the width is used, but for an area that would become too high.
    let left = em + 8.0 * em;
    let size = panel.area.size().max(DVec2::splat(f64::MIN_POSITIVE));
    let room = width - left - 2.0 * em;
    let per_px = (size.x / room).max(size.y / (TALLEST * room));
    let (middle, half) = (0.5 * (panel.area.min + panel.area.max), 0.5 * DVec2::new(room * per_px, size.y));
    let shown = Rect { min: middle - half, max: middle + half };
    let [x, y] = [0, 1].map(|k| Axis::new(Scale::Linear, shown.min[k], shown.max[k]));
    let min = DVec2::new(left, top + 2.0 * em).round();
    let area = Rect { min, max: min + shown.size() / per_px };
    let frame = PlotFrame { area, x: &x, y: &y, grows: Grows::Up };

    // Draw the lines, then the words over them.
    let place = |p: &DVec2| frame.place(p.x, p.y).unwrap_or(DVec2::NAN);
    for line in &panel.lines {
        let width_px = 0.09 * em * line.weight;
        let stroke = match line.dashed {
            false => Stroke::solid(line.colour, width_px),
            true => Stroke::dashed(line.colour, width_px, [0.5 * em, 0.4 * em]),
        };
        drawing.line_within(&area, &line.points.iter().map(place).collect::<Vec<_>>(), stroke);
    }
    let font = Font::regular(em);
    for (at, words) in &panel.words {
        let at = place(at) + DVec2::new(0.4 * em, -0.4 * em);
        let bounds = text::bounds(words, font, at, Align::Start, Direction::Right);
        if area.contains(bounds.min) && area.contains(bounds.max) {
            drawing.push(Item::Fill(bounds, WHITE));
            drawing.text(words.clone(), font, INK, at, Align::Start);
        }
    }
    frame.draw(drawing, style, &panel.axes[0], &panel.axes[1]);
    area.max.y + style.room_below() + 1.5 * em
}
