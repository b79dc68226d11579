//! The error budget: for each step from the ideal to the measured corner a panel, in which every corner is a dot in the
//! colour of the step's length there.

use crate::geom::Rect;
use crate::num::stats;
use crate::plot::axis::{Axis, Scale};
use crate::plot::colour::{GREY, INK, Map, PALE};
use crate::plot::drawing::{Drawing, Item, Stroke};
use crate::plot::text::{Align, Font};
use crate::plot::{colour_bar, text};
use glam::DVec2;

/// A corner of a panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Where it is in the picture, in px.
    pub at: DVec2,
    /// The length that its colour tells, in px.
    pub size: f64,
}

/// One step of one design.
#[derive(Debug, Clone, PartialEq)]
pub struct BudgetPanel {
    /// Name of the step.
    pub name: String,
    /// Its corners; none where the design has no such step.
    pub dots: Vec<Dot>,
}

/// A row of the figure: a design.
#[derive(Debug, Clone, PartialEq)]
pub struct BudgetRow {
    /// Name: "flat prism".
    pub name: String,
    /// Columns and rows of its picture.
    pub picture_px: DVec2,
    /// Column of the seam between the halves.
    pub seam_px: f64,
    /// Its steps, the last of them their sum.
    pub panels: Vec<BudgetPanel>,
}

/// The figure.
#[derive(Debug, Clone, PartialEq)]
pub struct BudgetInput {
    /// Heading.
    pub title: String,
    /// The designs.
    pub rows: Vec<BudgetRow>,
    /// Width of the figure in px; held within 600..=4000.
    pub width_px: u32,
}

/// Decades of a step's colours at most: smaller lengths have the colour of the smallest.
const DECADES: f64 = 1e3;

/// Lays the figure out, with a logarithmic scale of colours for each step, the same for all designs.
pub fn draw(input: &BudgetInput) -> Drawing {
    let width_px = input.width_px.clamp(600, 4000);
    let width = f64::from(width_px);
    let em = width / 110.0;
    let mut drawing = Drawing::new(width_px, 1);
    let (title, names, values) = (Font::bold(1.25 * em), Font::bold(em), Font::regular(em));
    let heading = text::shortened(&input.title, title, width - 2.0 * em);
    drawing.text(heading, title, INK, DVec2::new(em, em + title.size_px), Align::Start);

    let columns = input.rows.iter().map(|row| row.panels.len()).max().unwrap_or(0).max(1);
    let gap = 2.2 * em;
    let side = (width - 2.0 * em - gap * (columns - 1) as f64) / columns as f64;
    let scales: Vec<Option<Axis>> = (0..columns).map(|k| scale_of(input, k)).collect();
    let mut y = 2.0 * em + title.size_px;
    for row in &input.rows {
        let shape = row.picture_px.max(DVec2::ONE);
        let size = DVec2::new(side, (side * shape.y / shape.x).clamp(0.2 * side, 2.0 * side)).floor();
        y += 1.6 * em;
        drawing.text(text::shortened(&row.name, names, width - 2.0 * em), names, INK, DVec2::new(em, y), Align::Start);
        y += 2.0 * em;
        for (k, panel) in row.panels.iter().enumerate() {
            let min = DVec2::new(em + k as f64 * (side + gap), y).round();
            let area = Rect { min, max: min + size };
            let sign = match k {
                0 => "",
                _ if k + 1 == row.panels.len() => "=",
                _ => "+",
            };
            drawing.text(sign, names, INK, DVec2::new(min.x - 0.5 * gap, min.y + 0.5 * size.y), Align::Middle);
            drawing.text(
                text::shortened(&panel.name, values, side),
                values,
                INK,
                min - DVec2::new(0.0, 0.4 * em),
                Align::Start,
            );
            draw_panel(&mut drawing, row, panel, &area, scales[k].as_ref(), em);
        }
        y += size.y + 2.0 * em;
    }
    y += 0.8 * em;
    let mut end = y;
    for (k, scale) in scales.iter().enumerate() {
        let Some(scale) = scale else { continue };
        // Narrower than the panels: the words under its ends are centred there.
        let min = DVec2::new(em + k as f64 * (side + gap) + 0.14 * side, y).round();
        let bar = Rect { min, max: (min + DVec2::new(0.72 * side, 0.9 * em)).round() };
        let small = Font::regular(0.8 * em);
        end = end.max(colour_bar::draw(&mut drawing, &bar, scale, Map::Marks, "length of this step, px", small));
    }
    drawing.with_height(libm::ceil(end + em) as u32)
}

/// The colours of the step in column `k` over all designs, three decades at most; `None` where no design has such a step.
fn scale_of(input: &BudgetInput, k: usize) -> Option<Axis> {
    let dots = || input.rows.iter().filter_map(|row| row.panels.get(k)).flat_map(|panel| &panel.dots);
    let sizes = || dots().map(|dot| dot.size).filter(|size| size.is_finite() && *size > 0.0);
    let largest = sizes().fold(0.0, f64::max);
    (largest > 0.0).then(|| Axis::around(Scale::Log, sizes().map(|size| size.max(largest / DECADES))))
}

fn draw_panel(
    drawing: &mut Drawing,
    row: &BudgetRow,
    panel: &BudgetPanel,
    area: &Rect,
    colours: Option<&Axis>,
    em: f64,
) {
    let line = Stroke::solid(PALE, 0.1 * em);
    let place = |at: DVec2| area.min + at / row.picture_px.max(DVec2::ONE) * area.size();
    let seam = place(DVec2::new(row.seam_px, 0.0)).x;
    drawing.line(DVec2::new(seam, area.min.y), DVec2::new(seam, area.max.y), line);
    drawing.frame(area, Stroke::solid(GREY, 0.08 * em));
    for dot in &panel.dots {
        let at = place(dot.at);
        if area.contains(at) {
            let share = colours.and_then(|colours| colours.share(dot.size));
            let colour = share.map_or(PALE, |share| Map::Marks.colour(share.clamp(0.0, 1.0)));
            drawing.push(Item::Disc(at, 0.26 * em, colour));
        }
    }
    let sizes: Vec<f64> = panel.dots.iter().map(|dot| dot.size).collect();
    let font = Font::regular(0.9 * em);
    let summary = match sizes.len() {
        0 => "no such step".to_owned(),
        _ => format!("RMS {}, largest {} px", short(stats::rms(&sizes)), short(stats::max_abs(&sizes))),
    };
    let below = DVec2::new(area.min.x, area.max.y + 1.2 * em);
    drawing.text(text::shortened(&summary, font, area.size().x), font, GREY, below, Align::Start);
}

fn short(value: f64) -> String {
    crate::plot::axis::significant(value, 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::examine;

    fn input(scale: f64) -> BudgetInput {
        let dots = |size: f64| -> Vec<Dot> {
            let place = |k: usize| DVec2::new(40.0 + 64.0 * (k % 29) as f64, 50.0 + 64.0 * (k / 29) as f64);
            (0..29 * 16).map(|k| Dot { at: place(k), size: size * (place(k) / 1000.0).length_squared() }).collect()
        };
        let steps = [("optics", 0.7), ("fit", 3e-4), ("detector", 3e-6), ("sampling", 2e-8), ("measured − ideal", 0.7)];
        let row = |name: &str, fit: bool| BudgetRow {
            name: name.into(),
            picture_px: DVec2::new(1920.0, 1080.0),
            seam_px: 960.0,
            panels: steps
                .iter()
                .map(|(step, size)| BudgetPanel {
                    name: (*step).into(),
                    dots: if *step == "fit" && !fit { Vec::new() } else { dots(size * scale) },
                })
                .collect(),
        };
        BudgetInput {
            title: "Where the error of a corner comes from".into(),
            rows: vec![row("flat prism", false), row("freeform prism", true)],
            width_px: 2000,
        }
    }

    #[test]
    fn a_budget_is_sound() {
        let drawing = draw(&input(1.0));
        examine::examine("budget", &drawing);
        assert!(examine::says(&drawing, "no such step") && examine::says(&drawing, "="));
    }

    #[test]
    fn hostile_input_gives_a_sound_figure() {
        for scale in [0.0, f64::NAN, f64::INFINITY, 1e300] {
            let mut odd = input(scale);
            odd.title = "a name without any end ".repeat(40);
            odd.rows[0].name = odd.title.clone();
            odd.rows[1].picture_px = DVec2::new(1.0, 5000.0);
            examine::examine("budget_hostile", &draw(&odd));
        }
        let empty = BudgetInput { rows: Vec::new(), width_px: 0, ..input(1.0) };
        examine::examine("budget_empty", &draw(&empty));
    }
}
