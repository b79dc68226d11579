//! The marks of a chart: markers, lines, error bars and the Pareto front.

use super::input::{ChartSeries, Look, Point};
use crate::plot::colour::{ACCENT, Rgb, SERIES, WHITE, mixed};
use crate::plot::drawing::{Drawing, Item, Stroke};
use crate::plot::frame::PlotFrame;
use glam::DVec2;

/// Draws one series; ends with the number of points that have no place within the frame.
pub(super) fn draw_series(drawing: &mut Drawing, frame: &PlotFrame, em: f64, series: &ChartSeries, k: usize) -> usize {
    let colour = SERIES[k % SERIES.len()];
    let places: Vec<Option<DVec2>> = series.points.iter().map(|p| frame.place(p.x, p.y)).collect();
    if let Some(stroke) = line_of(series.look, colour, em) {
        let line: Vec<DVec2> = places.iter().map(|place| place.unwrap_or(DVec2::NAN)).collect();
        drawing.line_within(&frame.area, &line, stroke);
    }
    let near = frame.area.grown(0.01);
    for (point, place) in series.points.iter().zip(&places) {
        let Some(at) = place.filter(|&p| near.contains(p)) else { continue };
        if let Some([low, high]) = point.y_range {
            error_bar(drawing, frame, em, at, [low, high].map(|y| frame.place(point.x, y)), colour);
        }
    }
    if matches!(series.look, Look::Markers | Look::MarkersAndLine) {
        for &at in places.iter().flatten().filter(|&&p| near.contains(p)) {
            marker(drawing, at, k, em);
        }
    }
    places.iter().filter(|place| place.is_none_or(|p| !near.contains(p))).count()
}

pub(super) fn line_of(look: Look, colour: Rgb, em: f64) -> Option<Stroke> {
    match look {
        Look::Markers => None,
        Look::Line | Look::MarkersAndLine => Some(Stroke::solid(colour, 0.12 * em)),
        Look::DashedLine => Some(Stroke::dashed(colour, 0.1 * em, [0.5 * em, 0.35 * em])),
    }
}

/// A bar between the places of its ends; an end without a place (zero on a logarithmic axis) is at the frame's edge.
fn error_bar(drawing: &mut Drawing, frame: &PlotFrame, em: f64, at: DVec2, ends: [Option<DVec2>; 2], colour: Rgb) {
    let stroke = Stroke::solid(colour, 0.09 * em);
    let cap = DVec2::new(0.25 * em, 0.0);
    let edge = [frame.area.max.y, frame.area.min.y];
    let [low, high] = [0, 1].map(|k| DVec2::new(at.x, ends[k].map_or(edge[k], |p| p.y)));
    drawing.line_within(&frame.area, &[low, high], stroke);
    for end in ends.into_iter().flatten() {
        drawing.line_within(&frame.area, &[end - cap, end + cap], stroke);
    }
}

/// The marker of series `k`: eleven colours and five shapes, so that the first 55 series all differ.
pub(super) fn marker(drawing: &mut Drawing, at: DVec2, k: usize, em: f64) {
    for (size, colour) in [(0.36 * em, WHITE), (0.3 * em, SERIES[k % SERIES.len()])] {
        let polygon = |corners: &[(f64, f64)]| {
            Item::Polygon(corners.iter().map(|&(x, y)| at + DVec2::new(x, y) * size).collect(), colour)
        };
        drawing.push(match k % 5 {
            0 => Item::Disc(at, size, colour),
            1 => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
            2 => polygon(&[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)]),
            3 => polygon(&[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)]),
            _ => polygon(&[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)]),
        });
    }
}

/// The steps of the Pareto front: what lies right of and above them is beaten.
pub(super) fn draw_front(drawing: &mut Drawing, frame: &PlotFrame, em: f64, front: &[Point]) {
    drawing.line_within(&frame.area, &front_steps(frame, front), front_stroke(em));
}

pub(super) fn front_steps(frame: &PlotFrame, front: &[Point]) -> Vec<DVec2> {
    let places: Vec<DVec2> = front.iter().filter_map(|p| frame.place(p.x, p.y)).collect();
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return Vec::new() };
    let mut steps = vec![DVec2::new(first.x, frame.area.min.y)];
    for pair in places.windows(2) {
        steps.extend([pair[0], DVec2::new(pair[1].x, pair[0].y)]);
    }
    steps.extend([*last, DVec2::new(frame.area.max.x, last.y)]);
    steps
}

pub(super) fn front_stroke(em: f64) -> Stroke {
    Stroke::solid(mixed(ACCENT, WHITE, 0.6), 0.45 * em)
}
