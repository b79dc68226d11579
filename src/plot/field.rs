//! Maps of a field: errors as arrows at their places (the paper's Fig. 5), and values as colours. No command draws them
//! yet: they are for the analyses of an error over the image.

use super::axis::{Axis, Scale};
use super::colour::{GREY, INK, Map};
use super::drawing::{Drawing, Item, Stroke};
use super::frame::{Grows, PlotFrame, Style};
use super::text::{Align, CAP_HEIGHT, Font, LINE_HEIGHT};
use super::{axis, colour_bar, picture, text};
use crate::geom::Rect;
use crate::num::stats;
use crate::raster::Raster;
use glam::DVec2;

/// Width and height of a heat map over two quantities, to each other.
const CHART_SHAPE: DVec2 = DVec2::new(3.0, 2.0);

/// An error at a place of the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arrow {
    /// The place, in the unit of the axes.
    pub at: DVec2,
    /// The error, in the unit of the axes.
    pub error: DVec2,
}

/// The errors of one design.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct QuiverPanel {
    /// Name: "flat prism".
    pub name: String,
    /// The errors.
    pub arrows: Vec<Arrow>,
    /// How many times its length an error is drawn.
    pub gain: f64,
}

/// Error vectors over the image, one panel beside the other, with one colour scale.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct QuiverInput {
    /// Heading.
    pub title: String,
    /// The area shown, in the unit of the axes, y down; the same in each panel.
    pub area: Rect,
    /// Unit of the places and the errors: "px".
    pub unit: String,
    /// The panels, at most four.
    pub panels: Vec<QuiverPanel>,
    /// Width of the figure in px; held within 400..=4000.
    pub width_px: u32,
}

/// What a heat map lies over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HeatMapPlane {
    /// A plane with one unit, y down: an image or a surface.
    Image,
    /// Two quantities, each with a unit of its own, y up.
    Chart,
}

/// Values over a plane as colours.
#[derive(Debug, Clone)]
pub(crate) struct HeatMapInput<'a> {
    /// Heading.
    pub title: String,
    /// The values, row by row from the smallest y; NaN where there is none.
    pub values: &'a Raster<f64>,
    /// The area that the values cover, in the units of the axes.
    pub area: Rect,
    /// What the area is.
    pub plane: HeatMapPlane,
    /// Names of the axes with their unit.
    pub axes: [String; 2],
    /// What the colour means, with its unit.
    pub caption: String,
    /// The colours; a diverging map is centred on 0.
    pub map: Map,
    /// Width of the figure in px; held within 400..=4000.
    pub width_px: u32,
}

/// Lays the error vectors out. Arrows that are not numbers or lie outside the area are left out and counted.
pub(crate) fn draw_quiver(input: &QuiverInput) -> Drawing {
    let panels = &input.panels[..input.panels.len().min(4)];
    let width_px = input.width_px.clamp(400, 4000);
    let columns = panels.len().max(1);
    let em = f64::from(width_px) / (60.0 + 10.0 * columns as f64);
    let mut page = Page::new(width_px, em, &input.title);
    let area = checked(input.area);
    let [x, y] = [0, 1].map(|k| Axis::new(Scale::Linear, area.min[k], area.max[k]));
    let sizes: Vec<f64> = panels.iter().flat_map(|p| p.arrows.iter().filter(|a| shown(a, &area))).map(size).collect();
    let errors = magnitudes(&sizes);

    let room = (f64::from(width_px) - em) / columns as f64 - page.style.room_left(&y, em * 30.0) - 1.5 * em;
    let plot = fitted(area.size(), DVec2::new(room, 1.4 * room));
    let top = page.y + 1.6 * em;
    for (k, panel) in panels.iter().enumerate() {
        let left = em + k as f64 * (f64::from(width_px) - em) / columns as f64 + page.style.room_left(&y, plot.y);
        let min = DVec2::new(left, top).round();
        let frame = PlotFrame { area: Rect { min, max: min + plot }, x: &x, y: &y, grows: Grows::Down };
        quiver_panel(&mut page.drawing, &page.style, &frame, panel, &area, &errors, &input.unit);
    }
    page.y = top + plot.y + page.style.room_below() + 2.4 * em;
    page.bar(&errors, Map::Marks, &format!("length of the error, {}{}", input.unit, all_panels(columns)));
    page.finished()
}

/// Lays the heat map out. Values that are not numbers are left pale and counted.
pub(crate) fn draw_heat_map(input: &HeatMapInput) -> Drawing {
    let width_px = input.width_px.clamp(400, 4000);
    let em = f64::from(width_px) / 55.0;
    let mut page = Page::new(width_px, em, &input.title);
    let area = checked(input.area);
    let [x, y] = [0, 1].map(|k| Axis::new(Scale::Linear, area.min[k], area.max[k]));
    let finite = || input.values.data().iter().copied().filter(|v| v.is_finite());
    let colours = match input.map {
        Map::Diverging => {
            let largest = Axis::around(Scale::Linear, finite().map(f64::abs).chain([0.0])).high();
            Axis::new(Scale::Linear, -largest, largest)
        }
        Map::Sequential | Map::Marks => Axis::around(Scale::Linear, finite()),
    };
    let left = em + page.style.room_left(&y, em * 30.0);
    let room = f64::from(width_px) - left - 2.0 * em;
    let (shape, grows) = match input.plane {
        HeatMapPlane::Image => (area.size(), Grows::Down),
        HeatMapPlane::Chart => (CHART_SHAPE, Grows::Up),
    };
    let plot = fitted(shape, DVec2::new(room, 1.2 * room));
    let min = DVec2::new(left, page.y).round();
    let frame = PlotFrame { area: Rect { min, max: min + plot }, x: &x, y: &y, grows };
    let values = match grows {
        Grows::Down => input.values.clone(),
        Grows::Up => upside_down(input.values),
    };
    let shares = thinned(&values, plot).map(|v| colours.share(v).unwrap_or(f64::NAN));
    page.drawing.push(Item::Picture(frame.area, picture::mapped(&shares, input.map)));
    frame.draw(&mut page.drawing, &page.style, &input.axes[0], &input.axes[1]);
    if finite().next().is_none() {
        let middle = 0.5 * (frame.area.min + frame.area.max);
        page.drawing.text("no data", page.style.names, GREY, middle, Align::Middle);
    }
    page.y = frame.area.max.y + page.style.room_below() + 1.2 * em;
    page.bar(&colours, input.map, &input.caption);
    match input.values.data().len() - finite().count() {
        0 => {}
        count => page.note(&format!("{count} of {} values are no numbers (pale)", input.values.data().len())),
    }
    page.finished()
}

/// A sheet that is filled from the top down.
struct Page {
    drawing: Drawing,
    style: Style,
    em: f64,
    /// The lower edge of what is drawn.
    y: f64,
}

impl Page {
    fn new(width_px: u32, em: f64, title: &str) -> Self {
        let mut drawing = Drawing::new(width_px, 1);
        let font = Font::bold(1.25 * em);
        let title = text::shortened(title, font, f64::from(width_px) - 2.0 * em);
        drawing.text(title, font, INK, DVec2::new(em, em + font.size_px), Align::Start);
        Self { drawing, style: Style::of_size(em), em, y: 2.0 * em + font.size_px }
    }

    fn bar(&mut self, axis: &Axis, map: Map, caption: &str) {
        let width = f64::from(self.drawing.width_px());
        let bar = Rect {
            min: DVec2::new(0.2 * width, self.y).round(),
            max: DVec2::new(0.8 * width, self.y + 0.9 * self.em).round(),
        };
        self.y = colour_bar::draw(&mut self.drawing, &bar, axis, map, caption, self.style.values);
    }

    fn note(&mut self, words: &str) {
        self.y += LINE_HEIGHT * self.em;
        let words = text::shortened(words, self.style.values, f64::from(self.drawing.width_px()) - 2.0 * self.em);
        self.drawing.text(words, self.style.values, GREY, DVec2::new(self.em, self.y), Align::Start);
        self.y += text::DESCENT * self.em;
    }

    fn finished(self) -> Drawing {
        self.drawing.with_height(libm::ceil(self.y + self.em) as u32)
    }
}

fn quiver_panel(
    drawing: &mut Drawing,
    style: &Style,
    frame: &PlotFrame,
    panel: &QuiverPanel,
    area: &Rect,
    errors: &Axis,
    unit: &str,
) {
    let em = style.values.size_px;
    let places: Vec<&Arrow> = panel.arrows.iter().filter(|arrow| shown(arrow, area)).collect();
    let gain = format!("arrows × {}", axis::short(panel.gain));
    let head = frame.area.min - DVec2::new(0.0, 0.6 * em);
    let gain_at = DVec2::new(frame.area.max.x, head.y);
    let room = frame.area.size().x;
    let gain = text::shortened(&gain, style.values, 0.5 * room);
    let bold = Font::bold(style.names.size_px);
    let name = text::shortened(&panel.name, bold, room - text::width(&gain, style.values) - 0.5 * em);
    drawing.text(name, bold, INK, head, Align::Start);
    drawing.text(gain, style.values, GREY, gain_at, Align::End);
    frame.draw(drawing, style, &format!("u, {unit}"), &format!("v, {unit}"));
    for arrow in &places {
        let tip = arrow.at + arrow.error * panel.gain;
        let (Some(from), Some(to)) = (frame.place(arrow.at.x, arrow.at.y), frame.place(tip.x, tip.y)) else { continue };
        let share = errors.share(size(arrow)).unwrap_or(0.0);
        let stroke = Stroke::solid(Map::Marks.colour(share), 0.1 * em);
        if frame.area.contains(to) {
            drawing.arrow(from, to, stroke, 0.55 * em);
        } else {
            drawing.line_within(&frame.area, &[from, to], stroke);
        }
        drawing.push(Item::Disc(from, 0.12 * em, stroke.colour));
    }
    if places.is_empty() {
        let middle = 0.5 * (frame.area.min + frame.area.max);
        drawing.text("no data", style.names, GREY, middle, Align::Middle);
    }
    let sizes: Vec<f64> = places.iter().map(|arrow| size(arrow)).collect();
    let left_out = match panel.arrows.len() - places.len() {
        0 => String::new(),
        count => format!(", {count} left out"),
    };
    let [rms, largest] = [stats::rms(&sizes), stats::max_abs(&sizes)].map(|v| axis::significant(v, 3));
    let summary = format!("n = {}{left_out}, RMS {rms} {unit}, largest {largest} {unit}", places.len());
    let below = frame.area.max.y + style.room_below() + CAP_HEIGHT * em + 0.2 * em;
    let summary = text::shortened(&summary, style.values, room);
    drawing.text(summary, style.values, GREY, DVec2::new(frame.area.min.x, below), Align::Start);
}

/// Whether an arrow has a place: it is a number and starts within the area.
fn shown(arrow: &Arrow, area: &Rect) -> bool {
    area.contains(arrow.at) && arrow.error.is_finite()
}

fn size(arrow: &Arrow) -> f64 {
    arrow.error.length()
}

/// The colour axis of lengths: logarithmic when they go over more than a decade and a half, three decades at most.
fn magnitudes(sizes: &[f64]) -> Axis {
    let largest = stats::max_abs(sizes);
    let low = stats::quantile(sizes, 0.05).unwrap_or(0.0).max(1e-3 * largest);
    if low > 0.0 && largest > 30.0 * low {
        Axis::around(Scale::Log, [low, largest])
    } else {
        Axis::around(Scale::Linear, [0.0, if largest > 0.0 { largest } else { 1.0 }])
    }
}

fn all_panels(columns: usize) -> &'static str {
    if columns > 1 { " (all panels)" } else { "" }
}

/// The area, or one of side 1 where it has no extent.
fn checked(area: Rect) -> Rect {
    let sound = area.min.is_finite() && area.max.is_finite() && area.size().min_element() > 0.0;
    let sound = sound && area.min.abs().max(area.max.abs()).max_element() < 1e12;
    if sound { area } else { Rect { min: DVec2::ZERO, max: DVec2::ONE } }
}

/// The largest size with the proportions of `area` that fits into `room`; whole px. Proportions beyond 5 : 1 are drawn
/// as 5 : 1, so that the axes stay readable.
fn fitted(area: DVec2, room: DVec2) -> DVec2 {
    let area = area.max(DVec2::splat(0.2 * area.max_element()));
    (area * (room / area).min_element()).floor().max(DVec2::splat(20.0))
}

/// The same rows from the last to the first.
fn upside_down(values: &Raster<f64>) -> Raster<f64> {
    let rows = (0..values.height()).rev().flat_map(|j| values.row(j).iter().copied());
    Raster::from_data(values.width(), values.height(), rows.collect())
}

/// Not more values than the plot has pixels: every n-th of them.
fn thinned(values: &Raster<f64>, plot: DVec2) -> Raster<f64> {
    let count = |have: usize, room: f64| have.min(room.max(1.0) as usize);
    let (width, height) = (count(values.width(), plot.x), count(values.height(), plot.y));
    if (width, height) == (values.width(), values.height()) {
        return values.clone();
    }
    let from = |k: usize, shown: usize, have: usize| (2 * k + 1) * have / (2 * shown);
    let pixels = (0..height).flat_map(|j| (0..width).map(move |i| (i, j)));
    let data = pixels.map(|(i, j)| values.get(from(i, width, values.width()), from(j, height, values.height())));
    Raster::from_data(width, height, data.collect())
}

#[cfg(test)]
#[path = "field_tests.rs"]
mod tests;
