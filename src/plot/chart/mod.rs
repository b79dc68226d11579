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
mod tests {
    use super::*;
    use crate::plot::colour::WHITE;
    use crate::plot::drawing::Item;
    use crate::plot::svg;
    use crate::report::figures::samples;

    fn axis(name: &str, scale: Scale) -> AxisInput {
        AxisInput { name: name.into(), scale, range: None }
    }

    fn series(name: &str, look: Look, points: &[(f64, f64)]) -> ChartSeries {
        let labels = points.iter().map(|(x, _)| format!("at {x}")).collect();
        ChartSeries { name: name.into(), look, points: points.iter().map(|&(x, y)| Point::new(x, y)).collect(), labels }
    }

    fn cost() -> ChartInput {
        ChartInput {
            title: "What accuracy costs: one frame of 1920 × 1080 px".into(),
            note: "on a machine of that name".into(),
            x: axis("time for one frame, s (2 threads)", Scale::Log),
            y: axis("largest corner error, px", Scale::Log),
            series: vec![
                series("every pixel traced", Look::MarkersAndLine, &[(0.9, 2e-6), (1.4, 3e-8), (3.1, 9e-10)]),
                series(
                    "interpolated map",
                    Look::MarkersAndLine,
                    &[(0.04, 3e-3), (0.06, 4e-5), (0.11, 7e-8), (0.4, 2e-10)],
                ),
                series("f32 packets", Look::Markers, &[(0.08, 8e-4), (0.12, 7e-4)]),
                series("64 samples a pixel", Look::Markers, &[(2.2, 4e-3), (9.0, 1.1e-3), (36.0, 2.4e-4)]),
                series("1 / √time", Look::DashedLine, &[(2.0, 4.2e-3), (60.0, 7.7e-4)]),
            ],
            front: Front::SmallIsGood,
            size_px: [1400, 900],
        }
    }

    fn convergence() -> ChartInput {
        let steps = [91.0, 45.0, 22.0, 11.0, 5.5, 2.0, 1.0];
        let order = |name: &str, scale: f64, order: i32| {
            let error = |h: f64| (0..order).fold(scale, |e, _| e * h / 91.0).max(2e-13);
            series(name, Look::MarkersAndLine, &steps.map(|h| (h, error(h))))
        };
        ChartInput {
            title: "Distance of the back-extended rays from the virtual centre".into(),
            note: String::new(),
            x: axis("step, µm", Scale::Log),
            y: axis("mean distance, mm", Scale::Log),
            series: vec![order("Euler", 0.4, 1), order("midpoint", 2e-4, 2), order("RK4", 3e-9, 4)],
            front: Front::None,
            size_px: [1200, 800],
        }
    }

    #[test]
    fn realistic_charts_are_sound_and_the_same_in_svg() {
        let mut bars = convergence();
        bars.title = "Slope with error bars".into();
        (bars.x.scale, bars.y.scale) = (Scale::Linear, Scale::Linear);
        (bars.x.name, bars.y.name) = ("field angle, °".into(), "epipolar slope, mrad".into());
        bars.series = vec![ChartSeries {
            name: "measured".into(),
            look: Look::Markers,
            points: (-8..=8)
                .map(|k| {
                    let y = 0.3 * f64::from(k) - 0.02 * f64::from(k * k);
                    Point { x: f64::from(k), y, y_range: Some([y - 0.4, y + 0.25]) }
                })
                .collect(),
            labels: Vec::new(),
        }];
        for (name, input) in [("chart_cost", cost()), ("chart_convergence", convergence()), ("chart_bars", bars)] {
            let drawing = draw(&input);
            samples::examine(name, &drawing);
            let text = svg::write(&drawing, &input.title);
            assert_eq!(text, svg::write(&draw(&input), &input.title));
            samples::keep(&format!("{name}.svg"), text.as_bytes());
            for words in [&input.x.name, &input.y.name, &input.title, &input.series[0].name] {
                assert!(text.contains(words.as_str()), "{words}");
            }
        }
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let front: Vec<(f64, f64)> = front(&cost()).iter().map(|p| (p.x, p.y)).collect();
        // By eye from the table: the interpolated map, and from 0.4 s on nothing is better than its last point.
        assert_eq!(front, [(0.04, 3e-3), (0.06, 4e-5), (0.11, 7e-8), (0.4, 2e-10)]);
    }

    #[test]
    fn of_equal_points_one_is_on_the_front() {
        let mut input = cost();
        input.series =
            vec![series("", Look::Markers, &[(1.0, 2.0), (1.0, 2.0), (1.0, 3.0), (2.0, 2.0), (3.0, f64::NAN)])];
        assert_eq!(front(&input), [Point::new(1.0, 2.0)]);
    }

    #[test]
    fn points_without_a_place_are_counted() {
        let mut input = cost();
        input.series = vec![series("a", Look::MarkersAndLine, &[(1.0, 1.0), (-1.0, 1.0), (2.0, f64::NAN), (3.0, 4.0)])];
        let drawing = draw(&input);
        assert!(samples::says(&drawing, "2 of 4 points have no place on these axes"));
        input.x.range = Some([0.5, 2.0]);
        assert!(samples::says(&draw(&input), "3 of 4 points have no place on these axes"));
        let markers = drawing.items().iter().filter(|item| matches!(item, Item::Disc(_, _, WHITE))).count();
        assert_eq!(markers, 3, "two points and the legend");
    }

    #[test]
    fn crowded_values_on_an_axis_are_thinned() {
        let mut input = cost();
        for range in [[1e-7, 9e-7], [1.1e-12, 8e-12], [1e-90, 1e90]] {
            (input.x.range, input.y.range) = (Some(range), Some(range));
            input.size_px = [420, 300];
            samples::examine("chart_crowded", &draw(&input));
        }
    }

    #[test]
    fn points_are_named_where_there_is_room() {
        let mut input = cost();
        let drawing = draw(&input);
        for words in ["at 0.9", "at 0.04", "at 36"] {
            assert!(samples::says(&drawing, words), "{words}");
        }
        assert!(!samples::says(&drawing, "at 60"), "a line has no markers to name");
        // A hundred points in one place: words beside the first few, none over another.
        input.series = vec![series("crowd", Look::Markers, &[(1.0, 1.0); 100])];
        let drawing = draw(&input);
        samples::examine("chart_crowd", &drawing);
        assert!(samples::says(&drawing, "at 1"));
    }

    #[test]
    fn an_empty_chart_is_labelled() {
        let mut input = cost();
        input.series.clear();
        let drawing = draw(&input);
        samples::examine("chart_empty", &drawing);
        for words in [&input.title, &input.x.name, &input.y.name, "no data"] {
            assert!(samples::says(&drawing, words), "{words}");
        }
    }

    #[test]
    fn hostile_input_gives_a_sound_chart() {
        let long = "a name without any end ".repeat(40);
        let values = [f64::NAN, f64::INFINITY, -1e300, 0.0, 1e-300, 1.0, f64::MAX];
        let points: Vec<Point> =
            values.iter().flat_map(|&x| values.map(|y| Point { x, y, y_range: Some([y, x]) })).collect();
        let labels = vec![long.clone(), "short".to_owned(), String::new()];
        let one = ChartSeries { name: long.clone(), look: Look::MarkersAndLine, points, labels };
        for size_px in [[0, 0], [300, 900], [900, 300], [640, 480]] {
            for scale in [Scale::Linear, Scale::Log] {
                for range in [None, Some([f64::NAN, 1.0]), Some([5.0, -5.0])] {
                    let axis = AxisInput { name: long.clone(), scale, range };
                    let input = ChartInput {
                        title: long.clone(),
                        note: long.clone(),
                        x: axis.clone(),
                        y: axis,
                        series: vec![one.clone(); 60],
                        front: Front::SmallIsGood,
                        size_px,
                    };
                    samples::examine(&format!("chart_hostile_{}_{scale:?}", size_px[0]), &draw(&input));
                }
            }
        }
    }
}
