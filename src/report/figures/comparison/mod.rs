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
mod tests {
    use super::*;
    use crate::raster::Raster;
    use crate::report::figures::samples;

    fn rows() -> Vec<FigureRow> {
        let row = |label: &str, a: &str, b: &str| FigureRow { label: label.into(), values: [a.into(), b.into()] };
        vec![
            row("vertical disparity, RMS, px", "16.93", "0.204"),
            row("vertical disparity, largest, px", "38.51", "0.512"),
            row("epipolar slope, largest, mrad", "21.7", "0.31"),
            row("pinhole deviation, horizontal, mean, mm", "0.0604", "0.0034"),
            row("pinhole deviation, vertical, mean, mm", "0.0936", "0.0009"),
            row("straightness of rows and columns, RMS, px", "4.81", "0.12"),
            row("corners found / visible", "510 / 510", "510 / 510"),
        ]
    }

    const VERDICT: &str = "The freeform prism keeps both halves within 0.51 px of a pinhole camera; the flat prism bends \
        lines by up to 15 px. Only the freeform pair can go into a stereo matcher as it is.";

    fn example(then: impl Fn(&ComparisonInput)) {
        let (flat, freeform) = (samples::board(20.0), samples::board(0.5));
        let panels = [
            Panel { name: "flat prism".into(), picture: &flat.0, corners: &flat.1 },
            Panel { name: "freeform prism".into(), picture: &freeform.0, corners: &freeform.1 },
        ];
        then(&ComparisonInput {
            title: "One checkerboard through two prisms: 1 m away, squares of 10 mm".into(),
            arrow_gain: suitable_gain(&panels, 960.0),
            panels,
            seam_px: 960.0,
            figures: rows(),
            verdict: VERDICT.into(),
            width_px: 2000,
        });
    }

    #[test]
    fn a_realistic_comparison_is_sound_at_any_width() {
        example(|input| {
            for width_px in [800, 2000, 2401] {
                let drawing = draw(&ComparisonInput { width_px, ..input.clone() });
                samples::examine(&format!("comparison_{width_px}"), &drawing);
                // The sample's columns are parabolas: 0.8 (20 / 1.22) y^2 with y = 8 squares of 64 px over 540 px.
                for words in ["column −7, left half: up to 11.8 px from straight", "11.8 px"] {
                    assert!(samples::says(&drawing, words), "{words}");
                }
            }
        });
    }

    #[test]
    fn hostile_input_gives_a_sound_figure() {
        let long = "A very long sentence that has no end and goes on – with letters such as 稜鏡 and ß – ".repeat(30);
        let bad =
            |x: f64, e: f64| CornerMark { index: [0, 0], position_px: DVec2::splat(x), error_px: DVec2::splat(e) };
        let corners = [bad(f64::NAN, 1.0), bad(5.0, f64::INFINITY), bad(1e9, 3.0), bad(7.0, 1e200), bad(3.0, -0.0)];
        let pictures =
            [(0, 0), (1, 1), (3, 4000), (4000, 3), (1920, 1080)].map(|(w, h)| Raster::filled(w, h, f32::NAN));
        for (k, picture) in pictures.iter().enumerate() {
            let panel = |corners| Panel { name: long.clone(), picture, corners };
            let drawing = draw(&ComparisonInput {
                title: long.clone(),
                panels: [panel(&corners), panel(&[])],
                seam_px: [f64::NAN, 960.0, -5.0, f64::INFINITY, 1e12][k],
                arrow_gain: [f64::NAN, 0.0, -3.0, f64::INFINITY, 1e300][k],
                figures: vec![FigureRow { label: long.clone(), values: [long.clone(), long.clone()] }; 40],
                verdict: long.clone(),
                width_px: 1000,
            });
            samples::examine(&format!("comparison_hostile_{k}"), &drawing);
        }
    }

    #[test]
    fn an_empty_comparison_is_still_labelled() {
        let picture = Raster::filled(1920, 1080, 0.5);
        let panel = |name: &str| Panel { name: name.into(), picture: &picture, corners: &[] };
        let panels = [panel("flat"), panel("freeform")];
        assert_eq!(suitable_gain(&panels, 960.0), 1.0);
        let drawing = draw(&ComparisonInput {
            title: "Nothing yet".into(),
            panels,
            seam_px: 960.0,
            arrow_gain: 1.0,
            figures: Vec::new(),
            verdict: String::new(),
            width_px: 1600,
        });
        samples::examine("comparison_empty", &drawing);
        for words in ["(a) flat", "(b) freeform", "no corners detected"] {
            assert!(samples::says(&drawing, words), "{words}");
        }
        assert!(!samples::says(&drawing, "length of the corner error"), "there is no length");
    }

    #[test]
    fn corners_without_a_number_are_counted_and_the_others_drawn() {
        let picture = Raster::filled(100, 50, 0.5);
        let mark =
            |x: f64, e: f64| CornerMark { index: [0, 0], position_px: DVec2::splat(x), error_px: DVec2::splat(e) };
        let corners = [mark(10.0, 3.0), mark(20.0, f64::NAN), mark(f64::NAN, 1.0), mark(30.0, 4.0)];
        let panel = Panel { name: "flat".into(), picture: &picture, corners: &corners };
        let drawing = draw(&ComparisonInput {
            title: String::new(),
            panels: [panel.clone(), panel],
            seam_px: 50.0,
            arrow_gain: 1.0,
            figures: Vec::new(),
            verdict: String::new(),
            width_px: 1600,
        });
        // RMS of 3 and 4 times the root of 2, by hand: 5.
        assert!(samples::says(&drawing, "2 corners (+ 2 without a number), error RMS 5.00 px, largest 5.66 px"));
    }

    #[test]
    fn the_gain_makes_the_longer_arrows_about_two_squares_long() {
        let mark = |i: i32, e: f64| CornerMark {
            index: [i, 0],
            position_px: DVec2::new(60.0 * f64::from(i), 10.0),
            error_px: DVec2::new(0.0, e),
        };
        let picture = Raster::filled(1, 1, 0.0);
        for (error, gain) in [(11.0, 10.0), (0.05, 2000.0), (40.0, 2.0), (500.0, 1.0), (0.0, 1.0)] {
            let corners: Vec<CornerMark> = (0..9).map(|i| mark(i, error)).collect();
            let panel = Panel { name: String::new(), picture: &picture, corners: &corners };
            assert_eq!(suitable_gain(&[panel.clone(), panel], 1e9), gain, "{error}");
        }
    }
}
