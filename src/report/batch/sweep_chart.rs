//! A figure over one or two keys of a sweep: a line chart, or a heat map.

use crate::error::Error;
use crate::geom::Rect;
use crate::plot::axis::Scale;
use crate::plot::chart::{self, AxisInput, ChartInput, ChartSeries, Front, Look, Point};
use crate::plot::colour::Map as ColourMap;
use crate::plot::drawing::Drawing;
use crate::plot::field::{self, HeatMapInput, HeatMapPlane};
use crate::raster::Raster;
use glam::DVec2;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Lines of a chart, at most.
const MOST_LINES: usize = 8;
/// By this share of the mean step may the steps of an axis of a heat map differ: its cells are as wide as each other.
const EVEN: f64 = 1e-6;

/// One job of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepPoint {
    /// Its changed keys.
    pub set: Map<String, Value>,
    /// The figure; none where there is none.
    pub figure: Option<f64>,
}

/// What a chart of a sweep shows.
#[derive(Debug, Clone, Copy)]
pub struct SweepInput<'a> {
    /// Its heading.
    pub title: &'a str,
    /// The figure's path.
    pub figure: &'a str,
    /// The keys that it is drawn over, one or two; none for those that take several numbers, where these are one or two.
    pub over: &'a [String],
    /// The jobs.
    pub points: &'a [SweepPoint],
}

/// Draws the figure over its keys: over one a line for each combination of the others, over two a heat map, or where their values lie
/// unevenly, a line for each value of the second.
///
/// # Errors
/// When there is no key to draw over, or one has no numbers, or there are too many lines, or other keys vary beside two.
pub fn draw(input: &SweepInput) -> Result<Drawing, Error> {
    let varying = varying(input.points);
    let chosen = chosen(input, &varying)?;
    let rest: Vec<&str> = varying.iter().copied().filter(|key| !chosen.contains(key)).collect();
    match chosen[..] {
        [x] => lines(input, x, &rest),
        [x, y] if rest.is_empty() => match grid(input, [x, y]) {
            Some(drawing) => Ok(drawing),
            None => lines(input, x, &[y]),
        },
        _ => {
            let rule = format!("{} vary as well, and a map has two keys alone", rest.join(", "));
            Err(Error::new("--over", rule, "draw over one key, or make a run in which two keys vary"))
        }
    }
}

/// The keys that have several values.
fn varying(points: &[SweepPoint]) -> Vec<&str> {
    let mut values: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for (key, value) in points.iter().flat_map(|point| &point.set) {
        values.entry(key).or_default().insert(value.to_string());
    }
    let several = |key: &str| values.get(key).is_some_and(|values| values.len() > 1);
    let first = points.first().into_iter().flat_map(|point| point.set.keys());
    first.map(String::as_str).filter(|key| several(key)).collect()
}

/// The keys that are drawn over.
fn chosen<'a>(input: &SweepInput<'a>, varying: &[&'a str]) -> Result<Vec<&'a str>, Error> {
    let has_numbers = |key: &str| input.points.iter().all(|point| point.set.get(key).is_some_and(Value::is_number));
    let numeric = || varying.iter().copied().filter(|key| has_numbers(key)).collect::<Vec<_>>();
    let told = || format!("the keys that take several numbers are {}", numeric().join(", "));
    if input.over.is_empty() {
        return match numeric() {
            found if matches!(found.len(), 1 | 2) => Ok(found),
            found if found.is_empty() => {
                let rule = "no key takes several numbers, which a figure could be drawn over";
                Err(Error::new("the chart", rule, "sweep a key of numbers, as in --sweep prism.index=1.46:1.5:6"))
            }
            _ => Err(Error::new("the chart", told(), "name one or two of them with --over")),
        };
    }
    if input.over.len() > 2 {
        return Err(Error::new("--over", "a figure is drawn over one or two keys", "name one or two"));
    }
    match input.over.iter().find(|key| !numeric().contains(&key.as_str())) {
        Some(key) => {
            Err(Error::new("--over", format!("`{key}` takes no several numbers here; {}", told()), "name one"))
        }
        None => Ok(input.over.iter().map(String::as_str).collect()),
    }
}

fn number(point: &SweepPoint, key: &str) -> f64 {
    point.set.get(key).and_then(Value::as_f64).unwrap_or(f64::NAN)
}

/// The figure over `x`, a line for each combination of the values of `others`.
fn lines(input: &SweepInput, x: &str, others: &[&str]) -> Result<Drawing, Error> {
    let shown = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let name = |point: &SweepPoint| {
        let part = |key: &&str| point.set.get(*key).map(|value| format!("{} {}", last(key), shown(value)));
        others.iter().filter_map(part).collect::<Vec<_>>().join(", ")
    };
    let mut series: Vec<ChartSeries> = Vec::new();
    for point in input.points {
        let (name, at) = (name(point), Point::new(number(point, x), point.figure.unwrap_or(f64::NAN)));
        match series.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.push(at),
            None => {
                let look = Look::MarkersAndLine;
                series.push(ChartSeries { name, look, points: vec![at], labels: Vec::new() });
            }
        }
    }
    if series.len() > MOST_LINES {
        let rule = format!("{} lines are to be drawn over `{x}`, and {MOST_LINES} are the most", series.len());
        return Err(Error::new(
            "the chart",
            rule,
            "draw over two keys with evenly spaced values, or sweep fewer values",
        ));
    }
    series.iter_mut().for_each(|line| line.points.sort_by(|a, b| a.x.total_cmp(&b.x)));
    let axis = |name: &str| AxisInput { name: name.to_owned(), scale: Scale::Linear, range: None };
    Ok(chart::draw(&ChartInput {
        title: input.title.to_owned(),
        note: String::new(),
        x: axis(x),
        y: axis(input.figure),
        series,
        front: Front::None,
        size_px: [1400, 900],
    }))
}

/// The figure as colours over two keys; `None` where their values lie unevenly.
fn grid(input: &SweepInput, keys: [&str; 2]) -> Option<Drawing> {
    let axes = keys.map(|key| even(input.points.iter().map(|point| number(point, key)).collect()));
    let [Some(x), Some(y)] = axes else { return None };
    let mut values = Raster::filled(x.count, y.count, f64::NAN);
    for point in input.points {
        let [i, j] = [x.place(number(point, keys[0])), y.place(number(point, keys[1]))];
        values.row_mut(j)[i] = point.figure.unwrap_or(f64::NAN);
    }
    let half = 0.5 * DVec2::new(x.step, y.step);
    let last = DVec2::new(x.last(), y.last());
    Some(field::draw_heat_map(&HeatMapInput {
        title: input.title.to_owned(),
        values: &values,
        area: Rect { min: DVec2::new(x.first, y.first) - half, max: last + half },
        axes: keys.map(str::to_owned),
        caption: input.figure.to_owned(),
        map: ColourMap::Sequential,
        plane: HeatMapPlane::Chart,
        width_px: 1200,
    }))
}

/// Values as far from each other.
struct EvenAxis {
    first: f64,
    step: f64,
    count: usize,
}

impl EvenAxis {
    fn place(&self, value: f64) -> usize {
        (((value - self.first) / self.step).round().max(0.0) as usize).min(self.count - 1)
    }

    fn last(&self) -> f64 {
        self.first + self.step * (self.count - 1) as f64
    }
}

/// The axis through `values`, where they are as far from each other.
fn even(mut values: Vec<f64>) -> Option<EvenAxis> {
    values.sort_by(f64::total_cmp);
    values.dedup();
    let (first, last, count) = (*values.first()?, *values.last()?, values.len());
    let step = (last - first) / (count - 1) as f64;
    let axis = EvenAxis { first, step, count };
    let off = |(k, value): (usize, &f64)| (value - (first + step * k as f64)).abs();
    (step > 0.0 && values.iter().enumerate().all(|one| off(one) <= EVEN * step)).then_some(axis)
}

/// The last word of a key.
fn last(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::drawing::Item;
    use crate::plot::svg;
    use serde_json::json;

    fn point(set: Value, figure: f64) -> SweepPoint {
        SweepPoint { set: set.as_object().unwrap().clone(), figure: Some(figure) }
    }

    fn drawn(points: &[SweepPoint], over: &[&str]) -> Result<String, Error> {
        let over: Vec<String> = over.iter().map(|key| (*key).to_owned()).collect();
        let drawing = draw(&SweepInput { title: "a title", figure: "rms_px", over: &over, points })?;
        let is_map = drawing.items().iter().any(|item| matches!(item, Item::Picture(..)));
        Ok(format!("{} {}", if is_map { "a map" } else { "lines" }, svg::write(&drawing, "a title")))
    }

    /// One key is a line, two are a map, and of a word there is a line a value.
    #[test]
    fn the_keys_say_what_is_drawn() {
        let line: Vec<SweepPoint> = (0..4).map(|k| point(json!({ "a.x": k, "b": 7 }), f64::from(k * k))).collect();
        let text = drawn(&line, &[]).unwrap();
        assert!(text.contains("a.x") && text.contains("rms_px") && text.starts_with("lines"), "{text}");
        let words: Vec<SweepPoint> =
            (0..6).map(|k| point(json!({ "glass": (["BK7", "SF11"][k % 2]), "x": k / 2 }), k as f64)).collect();
        let text = drawn(&words, &[]).unwrap();
        assert!(text.contains("glass BK7") && text.contains("glass SF11"), "{text}");
        let map: Vec<SweepPoint> =
            (0..12).map(|k| point(json!({ "x": k % 4, "y": 0.1 * f64::from(k / 4) }), f64::from(k))).collect();
        assert!(drawn(&map, &[]).unwrap().starts_with("a map"));
        assert!(drawn(&map, &["x"]).unwrap().starts_with("lines"));
        // Cells of a map are as wide as each other.
        let uneven: Vec<SweepPoint> =
            (0..6).map(|k| point(json!({ "x": k % 3, "y": (7 * (k / 3) + k / 5) }), k as f64)).collect();
        assert!(drawn(&uneven, &[]).unwrap().starts_with("lines"));
    }

    #[test]
    fn what_cannot_be_drawn_is_told() {
        let said = |points: &[SweepPoint], over: &[&str]| drawn(points, over).unwrap_err().to_string();
        let cube: Vec<SweepPoint> =
            (0..8).map(|k| point(json!({ "x": k % 2, "y": k / 2 % 2, "z": k / 4 }), f64::from(k))).collect();
        assert!(said(&cube, &[]).contains("x, y, z") && said(&cube, &["x", "y"]).contains("z vary as well"));
        assert!(drawn(&cube, &["x"]).is_ok());
        assert!(said(&cube, &["w"]).contains("`w` takes no several numbers"));
        assert!(said(&cube[..1], &[]).contains("no key takes several numbers"));
        let many: Vec<SweepPoint> = (0..20).map(|k| point(json!({ "x": k % 2, "g": format!("{k}") }), 1.0)).collect();
        assert!(said(&many, &[]).contains("lines are to be drawn"));
    }
}
