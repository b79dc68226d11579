//! The legend of a chart.

use super::input::{ChartInput, Front, Look};
use super::marks::{front_stroke, line_of, marker};
use crate::plot::colour::{GREY, INK, SERIES};
use crate::plot::drawing::Drawing;
use crate::plot::text::{self, Align, CAP_HEIGHT, Font, LINE_HEIGHT};
use glam::DVec2;

/// The names of the series, to the right of the plot.
pub(super) struct Legend {
    font: Font,
    /// Width with the space for its signs, in px; 0 without entries.
    pub(super) width: f64,
    /// Name and number of each series with a name; `None` for the front.
    entries: Vec<(String, Option<(usize, Look)>)>,
}

impl Legend {
    pub(super) fn of(input: &ChartInput, font: Font, room: f64) -> Self {
        let em = font.size_px;
        let named = input.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty());
        let mut entries: Vec<_> = named.map(|(k, series)| (series.name.clone(), Some((k, series.look)))).collect();
        if input.front == Front::SmallIsGood {
            entries.push(("Pareto front".to_owned(), None));
        }
        let room = room - 2.6 * em;
        for (name, _) in &mut entries {
            *name = text::shortened(name, font, room);
        }
        let widest = entries.iter().map(|(name, _)| text::width(name, font)).fold(0.0, f64::max);
        let width = if entries.is_empty() { 0.0 } else { widest + 2.6 * em };
        Self { font, width, entries }
    }

    pub(super) fn draw(&self, drawing: &mut Drawing, at: DVec2, bottom: f64) {
        let em = self.font.size_px;
        let lines = ((bottom - at.y) / (LINE_HEIGHT * em)) as usize;
        for (line, (name, entry)) in self.entries.iter().enumerate().take(lines) {
            let y = at.y + (0.5 + LINE_HEIGHT * line as f64) * em;
            let [left, right] = [0.0, 1.9].map(|x| DVec2::new(at.x + x * em, y));
            let words = DVec2::new(at.x + 2.4 * em, y + 0.5 * CAP_HEIGHT * em);
            if line + 1 == lines && self.entries.len() > lines {
                let more = format!("… and {} more", self.entries.len() - line);
                drawing.text(text::shortened(&more, self.font, self.width), self.font, GREY, words, Align::Start);
                break;
            }
            match entry {
                None => drawing.line(left, right, front_stroke(em)),
                Some((k, look)) => {
                    if let Some(stroke) = line_of(*look, SERIES[k % SERIES.len()], em) {
                        drawing.line(left, right, stroke);
                    }
                    if matches!(look, Look::Markers | Look::MarkersAndLine) {
                        marker(drawing, 0.5 * (left + right), *k, em);
                    }
                }
            }
            drawing.text(name.clone(), self.font, INK, words, Align::Start);
        }
    }
}
