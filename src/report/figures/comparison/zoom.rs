//! The lower half of the comparison: the line that the first picture bends most, in both pictures, enlarged across the
//! line but not along it, as if one looked along the line, so that a bend of a pixel shows.

use super::bend::{Bend, LineDirection, LineName, worst};
use super::input::Panel;
use super::layout::Layout;
use crate::geom::Rect;
use crate::plot::colour::{ACCENT, GREY, INK, SERIES, WHITE};
use crate::plot::drawing::{Drawing, Item, Stroke};
use crate::plot::text::{Align, CAP_HEIGHT};
use crate::plot::{axis, picture, text};
use glam::DVec2;
use std::collections::BTreeMap;

/// Height of a window in the figure over its width.
const PROPORTION: f64 = 0.45;
/// Width of the window across the line, in sizes of the bend, and its least width in px of the picture.
const ACROSS: f64 = 8.0;
const LEAST_ACROSS_PX: f64 = 12.0;
/// The measured line's colour.
const MEASURED: [u8; 3] = SERIES[0];

/// A window for each panel, of one size: as long as the line, and so narrow that its bend shows.
pub(super) struct Zoom {
    /// The line that the first panel bends most.
    pub(super) line: LineName,
    /// The windows in px of the pictures, each around the panel's own line; whole px.
    pub(super) windows: Vec<Rect>,
}

impl Zoom {
    /// The windows; `None` when the first panel has no line, or a picture has no pixels.
    pub(super) fn of(lines: &[BTreeMap<LineName, Bend>], panels: &[Panel]) -> Option<Self> {
        let first = worst(lines.first()?)?;
        let [start, end] = first.ends_px();
        let step = start.distance(end) / (first.corners_px.len() - 1) as f64;
        let across = (ACROSS * first.size_px()).max(LEAST_ACROSS_PX);
        let margin = match first.line.along {
            LineDirection::Row => DVec2::new(step, across),
            LineDirection::Column => DVec2::new(across, step),
        };
        let whole = |k: usize| DVec2::new(panels[k].picture.width() as f64, panels[k].picture.height() as f64);
        let size = (0..panels.len()).map(whole).fold(((end - start).abs() + margin).ceil(), DVec2::min);
        let window = |k: usize| {
            let [start, end] = lines[k].get(&first.line).unwrap_or(first).ends_px();
            let min = (0.5 * (start + end - size)).round().clamp(DVec2::ZERO, whole(k) - size);
            Rect { min, max: min + size }
        };
        (size.min_element() >= 1.0).then(|| Self { line: first.line, windows: (0..panels.len()).map(window).collect() })
    }

    /// Draws the window of panel `k` from `top` on; ends with its lower edge.
    pub(super) fn draw(
        &self,
        drawing: &mut Drawing,
        layout: &Layout,
        panel: &Panel,
        k: usize,
        top: f64,
        bend: Option<&Bend>,
    ) -> f64 {
        let (left, unit, source) = (layout.left[k % 2], layout.unit, self.windows[k]);
        let min = DVec2::new(left, top.round());
        let area = Rect { min, max: min + DVec2::new(layout.column, (PROPORTION * layout.column).round()) };
        let [x, y] = source.min.to_array().map(|v| v as usize);
        let [width, height] = source.size().to_array().map(|v| v as usize);
        let [shown_width, shown_height] = area.size().to_array().map(|v| v as usize);
        let cut = picture::cut_out(panel.picture, x, y, width, height);
        let shown = picture::grey(&picture::area_averaged(&cut, shown_width, shown_height));
        drawing.push(Item::Picture(area, shown));

        let caption = match bend {
            Some(bend) => {
                self.draw_line(drawing, layout, &area, k, bend);
                format!("{}: up to {} px from straight", bend.line.words(), axis::significant(bend.size_px(), 3))
            }
            None => format!("{}: not detected here", self.line.words()),
        };
        drawing.frame(&area, Stroke::solid(ACCENT, 3.0 * unit));
        let y = area.max.y + 1.5 * layout.body.size_px;
        let times = area.size() / source.size();
        let across = match self.line.along {
            LineDirection::Row => times.y,
            LineDirection::Column => times.x,
        };
        let scale = format!("{width} × {height} px, {} × across the line", axis::significant(across, 2));
        drawing.text(&scale, layout.small, GREY, DVec2::new(area.max.x, y), Align::End);
        let room = area.size().x - text::width(&scale, layout.small) - layout.small.size_px;
        let caption = text::shortened(&caption, layout.body, room);
        drawing.text(caption, layout.body, INK, DVec2::new(left, y), Align::Start);
        y + text::DESCENT * layout.body.size_px
    }

    /// The key of both windows from `top` on; ends with its lower edge.
    pub(super) fn key(drawing: &mut Drawing, layout: &Layout, top: f64) -> f64 {
        let (unit, font) = (layout.unit, layout.small);
        let y = top + 1.3 * font.size_px;
        let mut x = layout.left[0];
        let signs = [
            (measured(unit), "through the detected corners of the line"),
            (straight(unit), "straight between its end corners"),
        ];
        for (stroke, words) in signs {
            let middle = y - 0.5 * CAP_HEIGHT * font.size_px;
            drawing.line(DVec2::new(x, middle), DVec2::new(x + 58.0 * unit, middle), stroke);
            x += 70.0 * unit;
            drawing.text(words, font, INK, DVec2::new(x, y), Align::Start);
            x += text::width(words, font) + 34.0 * unit;
        }
        y + text::DESCENT * font.size_px
    }

    /// The line through the corners, the straight line between its ends, and the distance between the two.
    fn draw_line(&self, drawing: &mut Drawing, layout: &Layout, area: &Rect, k: usize, bend: &Bend) {
        let (unit, source) = (layout.unit, self.windows[k]);
        let place = |p: DVec2| area.min + (p - source.min) * (area.size() / source.size());
        let corners: Vec<DVec2> = bend.corners_px.iter().map(|&p| place(p)).collect();
        let ends = bend.ends_px().map(place);
        for (line, stroke) in [(&corners[..], measured(unit)), (&ends[..], straight(unit))] {
            drawing.line_within(area, line, Stroke::solid(WHITE, stroke.width_px + 2.0 * unit));
            drawing.line_within(area, line, stroke);
        }
        for &corner in corners.iter().filter(|&&p| area.contains(p)) {
            drawing.push(Item::Disc(corner, 6.5 * unit, WHITE));
            drawing.push(Item::Disc(corner, 5.0 * unit, MEASURED));
        }
        let [from, to] = [bend.straight_px, bend.farthest_px].map(place);
        if from.distance(to) > 24.0 * unit && area.contains(from) && area.contains(to) {
            dimension(drawing, layout, area, bend, [from, to]);
        }
    }
}

/// The distance from the straight line, with its size written beside the farthest corner.
fn dimension(drawing: &mut Drawing, layout: &Layout, area: &Rect, bend: &Bend, [from, to]: [DVec2; 2]) {
    let (unit, font) = (layout.unit, layout.strong);
    drawing.line(from, to, Stroke::solid(WHITE, 7.0 * unit));
    drawing.line(from, to, Stroke::solid(INK, 3.0 * unit));
    let words = format!("{} px", axis::significant(bend.size_px(), 3));
    let size = DVec2::new(text::width(&words, font) + font.size_px, 1.5 * font.size_px);
    // Away from the straight line, beyond the corner.
    let outward = (to - from).signum();
    let middle = to + outward * (0.5 * size + 14.0 * unit);
    let min = (middle - 0.5 * size).min(area.max - size).max(area.min);
    drawing.push(Item::Fill(Rect { min, max: min + size }, WHITE));
    let foot = DVec2::new(min.x + 0.5 * size.x, min.y + 0.5 * (size.y + CAP_HEIGHT * font.size_px));
    drawing.text(words, font, INK, foot, Align::Middle);
}

fn measured(unit: f64) -> Stroke {
    Stroke::solid(MEASURED, 2.5 * unit)
}

fn straight(unit: f64) -> Stroke {
    Stroke::dashed(ACCENT, 2.5 * unit, [14.0 * unit, 8.0 * unit])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::figures::comparison::bends;
    use crate::report::figures::samples;

    #[test]
    fn both_windows_hold_their_line_and_lie_in_the_picture() {
        let boards = [20.0, 0.5].map(samples::board);
        let panels =
            boards.each_ref().map(|(picture, corners)| Panel { name: String::new(), picture, corners, seam_px: 960.0 });
        let lines = panels.each_ref().map(|panel| bends(panel.corners, panel.seam_px));
        let zoom = Zoom::of(&lines, &panels).expect("there are bent lines");
        let whole = Rect { min: DVec2::ZERO, max: DVec2::new(1920.0, 1080.0) };
        for (window, lines) in zoom.windows.iter().zip(&lines) {
            assert!(whole.contains(window.min) && whole.contains(window.max), "{window:?}");
            assert_eq!(window.size(), zoom.windows[0].size());
            assert!(lines[&zoom.line].corners_px.iter().all(|&p| window.contains(p)), "{window:?}");
        }
    }
}
