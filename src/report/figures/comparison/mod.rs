//! `comparison.png`: what two prisms do to the same board, side by side.

mod bend;
mod layout;
mod overview;
mod zoom;
mod input;
mod corner_mark;

use crate::num::stats;
use crate::plot::axis::{Axis, Scale};
use crate::plot::colour::{GREY, INK};
use crate::plot::drawing::{Drawing, Stroke};
use crate::plot::text::{self, Align, LINE_HEIGHT};
pub use corner_mark::CornerMark;
use glam::DVec2;
use input::sizes;
pub use input::{ComparisonInput, FigureRow, Panel, suitable_gain};
use layout::Layout;

pub use bend::{Bend, LineDirection, LineName, bends, worst};

/// Lays the comparison out.
pub fn draw(input: &ComparisonInput) -> Drawing {
    let layout = Layout::new(input.width_px);
    let mut drawing = Drawing::new(layout.width_px, 1);
    let errors = error_axis(input);
    let lines = input.panels.each_ref().map(|panel| bends(panel.corners, input.seam_px));
    let zoom = zoom::Zoom::of(&lines, &input.panels);

    let mut y = layout.margin + layout.title.size_px;
    let title = text::shortened(&input.title, layout.title, layout.right_edge() - layout.margin);
    drawing.text(title, layout.title, INK, DVec2::new(layout.margin, y), Align::Start);

    let top = y + layout.gap;
    for k in [0, 1] {
        y = y.max(overview::draw(&mut drawing, &layout, input, k, top, &errors, zoom.as_ref()));
    }
    y = overview::key(&mut drawing, &layout, input, y + 0.8 * layout.gap, &errors, zoom.as_ref());
    if let Some(zoom) = &zoom {
        let top = y + layout.gap;
        for k in [0, 1] {
            let line = lines[k].get(&zoom.line);
            y = y.max(zoom.draw(&mut drawing, &layout, &input.panels[k], k, top, line));
        }
        y = zoom::Zoom::key(&mut drawing, &layout, y);
    }
    let top = y + layout.gap;
    let end = table(&mut drawing, &layout, input, top);
    let beside = (end.x + layout.margin).max(layout.left[1]);
    y = end.y.max(verdict(&mut drawing, &layout, input, beside, top));
    drawing.with_height(libm::ceil(y + layout.margin) as u32)
}

/// The colour axis of the errors, one for both panels: logarithmic when one panel's median is below a tenth of the
/// other's, so that the smaller errors show too, over three decades at most.
fn error_axis(input: &ComparisonInput) -> Axis {
    let panels = input.panels.each_ref().map(sizes);
    let all: Vec<f64> = panels.concat();
    let median = |k: usize| stats::quantile(&panels[k], 0.5).unwrap_or(0.0);
    let (small, large) = (median(0).min(median(1)), median(0).max(median(1)));
    let largest = stats::max_abs(&all);
    if small > 0.0 && small < 0.1 * large {
        let low = stats::quantile(&all, 0.05).unwrap_or(0.0).max(1e-3 * largest);
        Axis::around(Scale::Log, [low, largest])
    } else {
        Axis::around(Scale::Linear, [0.0, if largest > 0.0 { largest } else { 1.0 }])
    }
}

/// The table of figures at the left, as wide as its words need; ends with its lower edge and its right edge.
fn table(drawing: &mut Drawing, layout: &Layout, input: &ComparisonInput, top: f64) -> DVec2 {
    const LARGEST_ROWS: usize = 24;
    let (left, font, em) = (layout.left[0], layout.body, layout.body.size_px);
    let rows = &input.figures[..input.figures.len().min(LARGEST_ROWS)];
    let widest = |words: &mut dyn Iterator<Item = f64>, room: f64| words.fold(0.0, f64::max).min(room);
    let labels = widest(&mut rows.iter().map(|row| text::width(&row.label, font)), 0.65 * layout.column);
    let values = [0, 1].map(|k| {
        let name = text::width(&input.panels[k].name, layout.strong);
        let values = rows.iter().map(|row| text::width(&row.values[k], font));
        widest(&mut values.chain([name]), 0.45 * layout.column)
    });
    let first_end = left + labels + 1.5 * em + values[0];
    let ends = [first_end, first_end + 1.5 * em + values[1]];
    let rule = |drawing: &mut Drawing, y: f64, width_px: f64| {
        let stroke = Stroke::solid(INK, width_px * layout.unit);
        drawing.line(DVec2::new(left, y), DVec2::new(ends[1], y), stroke);
    };
    rule(drawing, top, 2.0);
    let mut y = top + 1.4 * em;
    for k in [0, 1] {
        let name = text::shortened(&input.panels[k].name, layout.strong, values[k]);
        drawing.text(name, layout.strong, INK, DVec2::new(ends[k], y), Align::End);
    }
    let kind = text::shortened("measured, where not marked true", layout.small, labels);
    drawing.text(kind, layout.small, GREY, DVec2::new(left, y), Align::Start);
    rule(drawing, y + 0.45 * em, 1.2);
    y += 0.1 * em;
    for row in rows {
        y += 1.6 * em;
        drawing.text(text::shortened(&row.label, font, labels), font, INK, DVec2::new(left, y), Align::Start);
        for k in [0, 1] {
            let value = text::shortened(&row.values[k], font, values[k]);
            drawing.text(value, font, INK, DVec2::new(ends[k], y), Align::End);
        }
    }
    rule(drawing, y + 0.45 * em, 2.0);
    DVec2::new(ends[1], y + 0.5 * em)
}

/// The conclusion in what is left of the page beside the table; ends with its lower edge.
fn verdict(drawing: &mut Drawing, layout: &Layout, input: &ComparisonInput, left: f64, top: f64) -> f64 {
    let mut y = top + layout.head.size_px;
    if input.verdict.trim().is_empty() {
        return y;
    }
    drawing.text("Verdict", layout.strong, GREY, DVec2::new(left, y), Align::Start);
    for line in text::wrapped(&input.verdict, layout.head_regular(), layout.right_edge() - left, 12) {
        y += LINE_HEIGHT * layout.head.size_px;
        drawing.text(line, layout.head_regular(), INK, DVec2::new(left, y), Align::Start);
    }
    y + text::DESCENT * layout.head.size_px
}

#[cfg(test)]
mod tests;
