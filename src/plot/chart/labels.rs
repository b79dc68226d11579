//! Words beside the points of a chart, where they cover nothing.

use super::input::{ChartSeries, Look, Point};
use super::marks::front_steps;
use crate::geom::Rect;
use crate::plot::colour::{INK, SERIES, WHITE, mixed};
use crate::plot::drawing::{Drawing, Item, Stroke, clipped};
use crate::plot::frame::PlotFrame;
use crate::plot::text::{self, Align, CAP_HEIGHT, Direction, Font};
use glam::DVec2;

/// Half the room that a marker takes, in em.
const MARKER: f64 = 0.45;

/// From this distance on a thin line leads from a label to its point, in em.
const LEADER: f64 = 0.95;

/// Draws the labels of all series, in their order: each where it crosses fewest lines among the places around its point
/// at which it covers neither a marker nor other words nor the frame; the steps of the `front` are lines too. The paper
/// below words is white, so that nothing strikes them through.
pub(super) fn draw(drawing: &mut Drawing, frame: &PlotFrame, em: f64, series: &[ChartSeries], front: &[Point]) {
    let font = Font::regular(0.85 * em);
    let marked = |s: &&ChartSeries| matches!(s.look, Look::Markers | Look::MarkersAndLine);
    let places = |s: &ChartSeries| s.points.iter().map(|p| frame.place(p.x, p.y)).collect::<Vec<Option<DVec2>>>();
    // Ticks reach into the area.
    let room = frame.area.grown(-0.5 * em);
    let inside = |p: &DVec2| frame.area.grown(0.01).contains(*p);
    let markers = series.iter().filter(marked).flat_map(places).flatten().filter(inside);
    let mut taken: Vec<Rect> = markers.map(|p| around(p, MARKER * em)).collect();
    let lines: Vec<Vec<DVec2>> = series
        .iter()
        .filter(|s| s.look != Look::Markers)
        .map(|s| places(s).into_iter().map(|place| place.unwrap_or(DVec2::NAN)).collect())
        .chain([front_steps(frame, front)])
        .collect();
    for (k, s) in series.iter().enumerate().filter(|(_, s)| marked(s)) {
        let colour = mixed(SERIES[k % SERIES.len()], INK, 0.35);
        for (label, at) in s.labels.iter().zip(places(s)) {
            let Some(at) = at.filter(inside).filter(|_| !label.is_empty()) else { continue };
            let free = |(anchor, align): &(DVec2, Align)| {
                let bounds = text::bounds(label, font, *anchor, *align, Direction::Right);
                let within = room.contains(bounds.min) && room.contains(bounds.max);
                within && !taken.iter().any(|other| overlap(&bounds, other))
            };
            let crossed = |(anchor, align): &(DVec2, Align)| {
                let bounds = text::bounds(label, font, *anchor, *align, Direction::Right);
                lines.iter().map(|line| clipped(&bounds, line).len()).sum::<usize>()
            };
            let Some((anchor, align)) = around_point(at, em, font).into_iter().filter(free).min_by_key(crossed) else {
                continue;
            };
            let bounds = text::bounds(label, font, anchor, align, Direction::Right);
            taken.push(bounds);
            // Lead from a word that is not close by to its point.
            let nearest = at.clamp(bounds.min, bounds.max);
            if nearest.distance(at) > LEADER * em {
                drawing.line(at, nearest, Stroke::solid(colour, 0.07 * em));
            }
            drawing.push(Item::Fill(bounds, WHITE));
            drawing.text(label.clone(), font, colour, anchor, align);
        }
    }
}

/// Anchors of a label of the point at `at`, the best first: close to it, then farther away.
fn around_point(at: DVec2, em: f64, font: Font) -> Vec<(DVec2, Align)> {
    [0.62, 1.3, 2.0].into_iter().flat_map(|gap| at_distance(at, gap * em, em, font)).collect()
}

fn at_distance(at: DVec2, gap: f64, em: f64, font: Font) -> [(DVec2, Align); 8] {
    let (beside, half) = (1.05 * MARKER * em, 0.5 * CAP_HEIGHT * font.size_px);
    let (up, down) = (-gap - text::DESCENT * font.size_px, gap + text::ASCENT * font.size_px);
    [
        (gap, half, Align::Start),
        (-gap, half, Align::End),
        (0.0, up, Align::Middle),
        (0.0, down, Align::Middle),
        (beside, 0.8 * up, Align::Start),
        (beside, 0.8 * down, Align::Start),
        (-beside, 0.8 * up, Align::End),
        (-beside, 0.8 * down, Align::End),
    ]
    .map(|(x, y, align)| (at + DVec2::new(x, y), align))
}

fn around(p: DVec2, reach: f64) -> Rect {
    Rect { min: p - reach, max: p + reach }
}

fn overlap(a: &Rect, b: &Rect) -> bool {
    a.min.x < b.max.x && b.min.x < a.max.x && a.min.y < b.max.y && b.min.y < a.max.y
}
