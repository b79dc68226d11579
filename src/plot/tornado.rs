//! Tornado charts: what each cause changes, the largest first.

use super::axis::significant;
use super::colour::{ACCENT, GREY, INK, PALE, SERIES};
use super::drawing::{Drawing, Item, Stroke};
use super::text::{self, Align, Font};
use crate::geom::Rect;
use glam::DVec2;

/// What a cause does.
#[derive(Debug, Clone, PartialEq)]
pub struct TornadoBar {
    /// The cause.
    pub name: String,
    /// The figure with it, and with its opposite, where there is one.
    pub ends: [Option<f64>; 2],
}

/// The causes that act on one figure.
#[derive(Debug, Clone, PartialEq)]
pub struct TornadoPanel {
    /// Whose figure.
    pub name: String,
    /// The figure without any cause.
    pub middle: f64,
    /// The causes, in any order.
    pub bars: Vec<TornadoBar>,
}

impl TornadoBar {
    /// How far its ends are from `middle`; infinite where one has no figure.
    fn reach(&self, middle: f64) -> f64 {
        self.ends.iter().map(|end| end.map_or(f64::INFINITY, |end| (end - middle).abs())).fold(0.0, f64::max)
    }
}

/// Lays the panels out, one below the other, `width_px` (held within 600..=4000) wide.
pub fn draw(title: &str, panels: &[TornadoPanel], width_px: u32) -> Drawing {
    let width_px = width_px.clamp(600, 4000);
    let (width, em) = (f64::from(width_px), f64::from(width_px) / 80.0);
    let mut drawing = Drawing::new(width_px, 1);
    let heading = Font::bold(1.3 * em);
    drawing.text(
        text::shortened(title, heading, width - 2.0 * em),
        heading,
        INK,
        DVec2::new(em, 2.2 * em),
        Align::Start,
    );
    let mut top = 3.4 * em;
    for panel in panels {
        top = draw_panel(&mut drawing, em, top, panel);
    }
    drawing.with_height(libm::ceil(top + em) as u32)
}

/// Draws a panel from `top` on, and ends with where the next one begins.
fn draw_panel(drawing: &mut Drawing, em: f64, top: f64, panel: &TornadoPanel) -> f64 {
    let width = f64::from(drawing.width_px());
    let (bold, plain) = (Font::bold(em), Font::regular(0.9 * em));
    let heading = format!("{}: {} without errors", panel.name, significant(panel.middle, 3));
    drawing.text(text::shortened(&heading, bold, width - 2.0 * em), bold, INK, DVec2::new(em, top + em), Align::Start);

    // Lay out: names, then numbers of the smaller end, bars, numbers of the larger end.
    let mut bars: Vec<&TornadoBar> = panel.bars.iter().collect();
    bars.sort_by(|a, b| b.reach(panel.middle).total_cmp(&a.reach(panel.middle)));
    let names = bars.iter().map(|bar| text::width(&bar.name, plain)).fold(0.0, f64::max).min(0.35 * width);
    let figures = bars.iter().flat_map(|bar| bar.ends.iter().flatten()).copied();
    let (low, high) =
        figures.fold((panel.middle, panel.middle), |(low, high): (f64, f64), v| (low.min(v), high.max(v)));
    let number = 5.5 * em;
    let area = Rect {
        min: DVec2::new(2.0 * em + names + number, top + 1.8 * em),
        max: DVec2::new(width - em - number, top + 1.8 * em + 1.5 * em * bars.len() as f64),
    };
    let span = if high > low { high - low } else { 1.0 };
    let place = |value: f64| area.min.x + (value - low) / span * area.size().x;

    // Draw the bars from the figure without errors on, the error's own above its opposite's.
    for (k, bar) in bars.iter().enumerate() {
        let y = area.min.y + 1.5 * em * k as f64;
        let base = y + 1.05 * em;
        let name = text::shortened(&bar.name, plain, names);
        drawing.text(name, plain, INK, DVec2::new(em, base), Align::Start);
        for (end, (colour, offset)) in bar.ends.iter().zip([(ACCENT, 0.1), (SERIES[0], 0.7)]) {
            let Some(end) = end else { continue };
            let (a, b) = (place(panel.middle).min(place(*end)), place(panel.middle).max(place(*end)));
            let from = DVec2::new(a, y + offset * em);
            drawing.push(Item::Fill(Rect { min: from, max: DVec2::new(b.max(a + 0.5), from.y + 0.55 * em) }, colour));
        }
        let shown = |end: Option<f64>| end.map_or("none".to_owned(), |end| significant(end, 3));
        let numbers = Font::regular(0.75 * em);
        let [plus, minus] = bar.ends.map(shown);
        let right = area.max.x + 0.5 * em;
        drawing.text(format!("+ {plus}"), numbers, ACCENT, DVec2::new(right, base), Align::Start);
        drawing.text(format!("− {minus}"), numbers, SERIES[0], DVec2::new(area.min.x - 0.5 * em, base), Align::End);
    }
    let middle = place(panel.middle);
    drawing.line(DVec2::new(middle, area.min.y), DVec2::new(middle, area.max.y), Stroke::solid(GREY, 1.0));
    drawing.frame(&area, Stroke::solid(PALE, 1.0));
    area.max.y + 1.5 * em
}
