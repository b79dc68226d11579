//! Charts of y over x: series of points and lines on linear or logarithmic axes.

mod labels;
mod legend;
mod marks;
mod input;

pub use input::{AxisInput, ChartInput, ChartSeries, Front, Look, Point};

use super::axis::{Axis, Scale};
use super::colour::{GREY, INK};
use super::drawing::Drawing;
use super::frame::{Grows, PlotFrame, Style};
use super::text::{self, Align, Font};
use crate::geom::Rect;
use glam::DVec2;
use legend::Legend;

/// Lays the chart out. Points without a place on the axes are left out and counted in the figure.
pub fn draw(input: &ChartInput) -> Drawing {
    let [width_px, height_px] = input.size_px.map(|px| px.clamp(300, 4000));
    let mut drawing = Drawing::new(width_px, height_px);
    let sheet = drawing.sheet().max;
    let em = (sheet.min_element() / 38.0).max(9.0);
    let (style, title) = (Style::of_size(em), Font::bold(1.25 * em));
    let [x, y] = axes(input);

    let heading = text::shortened(&input.title, title, sheet.x - 2.0 * em);
    drawing.text(heading, title, INK, DVec2::new(em, em + title.size_px), Align::Start);
    let note = text::shortened(&input.note, style.values, sheet.x - 2.0 * em);
    let below = if note.is_empty() { 0.0 } else { text::LINE_HEIGHT * em };
    drawing.text(note, style.values, GREY, DVec2::new(em, em + title.size_px + below), Align::Start);
    let [top, bottom] = [2.0 * em + title.size_px + below, sheet.y - style.room_below() - 1.8 * em];
    let legend = Legend::of(input, style.values, 0.3 * sheet.x);
    let area = Rect {
        min: DVec2::new(style.room_left(&y, bottom - top) + 0.8 * em, top),
        max: DVec2::new(sheet.x - legend.width - 1.6 * em, bottom),
    };
    let frame = PlotFrame { area, x: &x, y: &y, grows: Grows::Up };

    frame.grid(&mut drawing, &style);
    let front = if input.front == Front::SmallIsGood { front(input) } else { Vec::new() };
    marks::draw_front(&mut drawing, &frame, em, &front);
    frame.draw(&mut drawing, &style, &input.x.name, &input.y.name);
    let mut left_out = 0;
    for (k, series) in input.series.iter().enumerate() {
        left_out += marks::draw_series(&mut drawing, &frame, em, series, k);
    }
    labels::draw(&mut drawing, &frame, em, &input.series, &front);
    legend.draw(&mut drawing, DVec2::new(area.max.x + em, area.min.y), bottom);

    let count: usize = input.series.iter().map(|series| series.points.len()).sum();
    if count == left_out {
        let middle = 0.5 * (area.min + area.max);
        drawing.text("no data", style.names, GREY, middle, Align::Middle);
    }
    if left_out > 0 {
        let words = format!("{left_out} of {count} points have no place on these axes");
        let words = text::shortened(&words, style.values, sheet.x - 2.0 * em);
        drawing.text(words, style.values, GREY, DVec2::new(sheet.x - em, sheet.y - 0.6 * em), Align::End);
    }
    drawing
}

/// The points of the Pareto front, from small to large x; see [`Front::SmallIsGood`].
pub fn front(input: &ChartInput) -> Vec<Point> {
    let taking_part = input.series.iter().filter(|s| matches!(s.look, Look::Markers | Look::MarkersAndLine));
    let mut points: Vec<Point> =
        taking_part.flat_map(|s| s.points.iter().copied()).filter(|p| p.x.is_finite() && p.y.is_finite()).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut best = f64::INFINITY;
    points.retain(|p| {
        let better = p.y < best;
        best = best.min(p.y);
        better
    });
    points
}

/// Both axes, around the data where no range is set.
fn axes(input: &ChartInput) -> [Axis; 2] {
    let points = || input.series.iter().flat_map(|series| &series.points);
    let xs = points().map(|p| p.x).collect::<Vec<f64>>();
    let ys = points().flat_map(|p| [p.y].into_iter().chain(p.y_range.into_iter().flatten())).collect::<Vec<f64>>();
    let axis = |asked: &AxisInput, values: Vec<f64>| match asked.range {
        Some([low, high]) => Axis::new(asked.scale, low, high),
        None => Axis::around(asked.scale, with_margin(asked.scale, &values)),
    };
    [axis(&input.x, xs), axis(&input.y, ys)]
}

/// The smallest and the largest value with a place on the scale, moved apart so that no marker lies on the frame; a
/// linear axis that begins at or above 0 does not go below.
fn with_margin(scale: Scale, values: &[f64]) -> Vec<f64> {
    const SHARE: f64 = 0.03;
    let axis = Axis::around(scale, values.iter().copied());
    let placed = values.iter().filter(|&&v| axis.share(v).is_some_and(|share| (0.0..=1.0).contains(&share)));
    let (low, high) = placed.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)));
    if low > high {
        return Vec::new();
    }
    let spread = match scale {
        Scale::Linear => {
            let margin = SHARE * (high - low);
            [if low >= 0.0 { (low - margin).max(0.0) } else { low - margin }, high + margin]
        }
        Scale::Log => {
            let factor = libm::pow(high / low, SHARE);
            [low / factor, high * factor]
        }
    };
    spread.to_vec()
}

#[cfg(test)]
mod tests;
