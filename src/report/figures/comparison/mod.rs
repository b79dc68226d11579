//! `comparison.png`: what prisms do to a board, side by side.

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

/// The conclusion stands beside the table where there is this much room, as a share of a column.
const LEAST_BESIDE: f64 = 0.5;

/// Lays the comparison out.
pub fn draw(input: &ComparisonInput) -> Drawing {
    let layout = Layout::new(input.width_px, input.panels.len());
    let mut drawing = Drawing::new(layout.width_px, 1);
    let errors = error_axis(input);
    let zoom = zoom::Zoom::of(&input.panels);
    let (panels, columns) = (input.panels.len(), layout.left.len());
    let rows = || (0..panels).step_by(columns).map(|first| first..(first + columns).min(panels));

    let mut y = layout.margin + layout.title.size_px;
    let title = text::shortened(&input.title, layout.title, layout.right_edge() - layout.margin);
    drawing.text(title, layout.title, INK, DVec2::new(layout.margin, y), Align::Start);

    for row in rows() {
        let top = y + layout.gap;
        for k in row {
            y = y.max(overview::draw(&mut drawing, &layout, input, k, top, &errors, zoom.as_ref()));
        }
    }
    y = overview::key(&mut drawing, &layout, input, y + 0.8 * layout.gap, &errors, zoom.as_ref());
    if let Some(zoom) = &zoom {
        for row in rows() {
            let top = y + layout.gap;
            for k in row {
                y = y.max(zoom.draw(&mut drawing, &layout, &input.panels[k], k, top));
            }
        }
        y = zoom::Zoom::key(&mut drawing, &layout, y);
    }
    let top = y + layout.gap;
    let end = if input.figures.is_empty() { DVec2::new(0.0, y) } else { table(&mut drawing, &layout, input, top) };
    let beside = (end.x + layout.margin).max(layout.right_half);
    y = if input.figures.is_empty() {
        verdict(&mut drawing, &layout, input, layout.left[0], y + 0.5 * layout.gap)
    } else if layout.right_edge() - beside > LEAST_BESIDE * layout.half {
        end.y.max(verdict(&mut drawing, &layout, input, beside, top))
    } else {
        verdict(&mut drawing, &layout, input, layout.left[0], end.y + 0.5 * layout.gap)
    };
    drawing.with_height(libm::ceil(y + layout.margin) as u32)
}

/// The colour axis of the errors, one for all panels: logarithmic when one panel's median is below a tenth of
/// another's, so that the smaller errors show too, over three decades at most.
fn error_axis(input: &ComparisonInput) -> Axis {
    let panels: Vec<Vec<f64>> = input.panels.iter().map(sizes).collect();
    let all: Vec<f64> = panels.concat();
    let medians = || panels.iter().map(|sizes| stats::quantile(sizes, 0.5).unwrap_or(0.0));
    let (small, large) = (medians().fold(f64::INFINITY, f64::min), medians().fold(0.0, f64::max));
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
    const LARGEST_ROWS: usize = 32;
    let (left, font, em) = (layout.left[0], layout.body, layout.body.size_px);
    let rows = &input.figures[..input.figures.len().min(LARGEST_ROWS)];
    let widest = |words: &mut dyn Iterator<Item = f64>, room: f64| words.fold(0.0, f64::max).min(room);
    let labels = widest(&mut rows.iter().map(|row| text::width(&row.label, font)), 0.65 * layout.half);
    let panels = input.panels.len();
    let room = (layout.right_edge() - left - labels) / panels as f64 - 1.5 * em;
    let values = (0..panels).map(|k| {
        let name = text::width(&input.panels[k].name, layout.strong);
        let values = rows.iter().map(|row| text::width(&row.values[k], font));
        widest(&mut values.chain([name]), room.min(0.45 * layout.half))
    });
    let columns: Vec<(f64, f64)> = values
        .scan(left + labels, |end, width| {
            *end += 1.5 * em + width;
            Some((*end, width))
        })
        .collect();
    let right = columns.last().map_or(left + labels, |column| column.0);
    let rule = |drawing: &mut Drawing, y: f64, width_px: f64| {
        let stroke = Stroke::solid(INK, width_px * layout.unit);
        drawing.line(DVec2::new(left, y), DVec2::new(right, y), stroke);
    };
    rule(drawing, top, 2.0);
    let mut y = top + 1.4 * em;
    for (panel, &(end, width)) in input.panels.iter().zip(&columns) {
        let name = text::shortened(&panel.name, layout.strong, width);
        drawing.text(name, layout.strong, INK, DVec2::new(end, y), Align::End);
    }
    let kind = text::shortened("measured, where not marked true", layout.small, labels);
    drawing.text(kind, layout.small, GREY, DVec2::new(left, y), Align::Start);
    rule(drawing, y + 0.45 * em, 1.2);
    y += 0.1 * em;
    for row in rows {
        y += 1.6 * em;
        drawing.text(text::shortened(&row.label, font, labels), font, INK, DVec2::new(left, y), Align::Start);
        for (value, &(end, width)) in row.values.iter().zip(&columns) {
            drawing.text(text::shortened(value, font, width), font, INK, DVec2::new(end, y), Align::End);
        }
    }
    rule(drawing, y + 0.45 * em, 2.0);
    DVec2::new(right, y + 0.5 * em)
}

/// The conclusion in what is left of the page beside the table; ends with its lower edge.
fn verdict(drawing: &mut Drawing, layout: &Layout, input: &ComparisonInput, left: f64, top: f64) -> f64 {
    if input.verdict.trim().is_empty() {
        return top;
    }
    let mut y = top + layout.head.size_px;
    drawing.text("Verdict", layout.strong, GREY, DVec2::new(left, y), Align::Start);
    for line in text::wrapped(&input.verdict, layout.head_regular(), layout.right_edge() - left, 24) {
        y += LINE_HEIGHT * layout.head.size_px;
        drawing.text(line, layout.head_regular(), INK, DVec2::new(left, y), Align::Start);
    }
    y + text::DESCENT * layout.head.size_px
}

#[cfg(test)]
mod tests;
