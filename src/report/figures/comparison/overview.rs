//! The upper half of the comparison: the whole pictures with their corners and errors, and the key below.

use super::corner_mark::CornerMark;
use super::input::{ComparisonInput, Panel, drawable, sizes};
use super::layout::{Layout, letter};
use super::zoom::Zoom;
use crate::geom::Rect;
use crate::num::stats;
use crate::plot::axis::Axis;
use crate::plot::colour::{ACCENT, GREY, INK, MISSING, Map, Rgb, WHITE};
use crate::plot::drawing::{Drawing, Item, Stroke};
use crate::plot::text::{Align, CAP_HEIGHT, LINE_HEIGHT};
use crate::plot::{axis, colour, colour_bar, picture, text};
use glam::DVec2;

/// Length of the dashes of the seam, in px of a figure 2000 px wide.
const SEAM_DASH: [f64; 2] = [10.0, 7.0];

/// How far towards white the pictures are paled, so that the marks on them can be seen.
const PALENESS: f64 = 0.45;
/// Radius of a corner's dot, in px of a figure 2000 px wide.
const DOT: f64 = 3.2;
/// Width of an arrow's shaft and length of its head, in px of a figure 2000 px wide.
const SHAFT: f64 = 2.0;
const HEAD: f64 = 10.0;

/// The room that arrows beyond a picture's border take at most, as a share of the picture's width.
const MOST_BEYOND: f64 = 0.25;

/// How far the longest arrows reach beyond the pictures, as a share of their width; no arrow is cut.
fn beyond(input: &ComparisonInput) -> f64 {
    let of_panel = |panel: &Panel| {
        let size = DVec2::new(panel.picture.width() as f64, panel.picture.height() as f64).max(DVec2::ONE);
        let tip = |corner: &CornerMark| corner.position_px + corner.error_px * input.arrow_gain;
        let over = |tip: DVec2| (-tip).max(tip - size).max_element() / size.x;
        panel.corners.iter().filter(|c| drawable(c)).map(tip).map(over).fold(0.0, f64::max)
    };
    input.panels.iter().map(of_panel).fold(0.0, f64::max).min(MOST_BEYOND)
}

/// Where a panel's picture stands in the figure.
struct PanelPlace {
    /// Whole px.
    area: Rect,
    /// Px of the figure for one px of the picture.
    scale: f64,
    /// Room for arrows below the picture, in px of the figure.
    below: f64,
}

impl PanelPlace {
    /// The largest place in column `k` below `top` that keeps the picture's proportions and is not much higher than
    /// a column is wide.
    fn of(input: &ComparisonInput, layout: &Layout, k: usize, top: f64) -> Self {
        let picture = input.panels[k].picture;
        let size = match (picture.width(), picture.height()) {
            (0, _) | (_, 0) => DVec2::new(16.0, 9.0),
            (width, height) => DVec2::new(width as f64, height as f64),
        };
        let room = beyond(input) * size.x;
        let scale = (layout.column / (size.x + 2.0 * room)).min(1.2 * layout.column / size.y);
        let shown = (size * scale).round().max(DVec2::ONE);
        let left = layout.left[k % layout.left.len()] + (0.5 * (layout.column - shown.x)).floor();
        let min = DVec2::new(left, (top + room * scale).round());
        Self { area: Rect { min, max: min + shown }, scale, below: (room * scale).round() }
    }

    fn of_px(&self, picture_px: DVec2) -> DVec2 {
        self.area.min + picture_px * self.scale
    }
}

/// Draws panel `k` from `top` on; ends with its lower edge.
pub(super) fn draw(
    drawing: &mut Drawing,
    layout: &Layout,
    input: &ComparisonInput,
    k: usize,
    top: f64,
    errors: &Axis,
    zoom: Option<&Zoom>,
) -> f64 {
    let (panel, left, unit) = (&input.panels[k], layout.left[k % layout.left.len()], layout.unit);
    let y = top + layout.head.size_px;
    let name = text::shortened(&format!("({}) {}", letter(k), panel.name), layout.head, layout.column);
    drawing.text(name, layout.head, INK, DVec2::new(left, y), Align::Start);
    let y = y + LINE_HEIGHT * layout.small.size_px;
    let count = text::shortened(&summary(panel), layout.small, layout.column);
    drawing.text(count, layout.small, GREY, DVec2::new(left, y), Align::Start);

    let place = PanelPlace::of(input, layout, k, (y + 0.6 * layout.head.size_px).round());
    let pixels = (place.area.size().x as usize, place.area.size().y as usize);
    if panel.picture.data().is_empty() {
        drawing.push(Item::Fill(place.area, MISSING));
        let middle = 0.5 * (place.area.min + place.area.max);
        drawing.text("no picture", layout.body, GREY, middle, Align::Middle);
    } else {
        let small = picture::grey(&picture::area_averaged(panel.picture, pixels.0, pixels.1));
        let paled: [Rgb; 256] = std::array::from_fn(|level| colour::mixed([level as u8; 3], WHITE, PALENESS));
        let small = small.map(|[level, ..]| paled[usize::from(level)]);
        drawing.push(Item::Picture(place.area, small));
    }
    for corner in panel.corners.iter().filter(|c| drawable(c)) {
        let from = place.of_px(corner.position_px);
        let to = from + corner.error_px * (input.arrow_gain * place.scale);
        let colour = Map::Marks.colour(errors.share(corner.error_px.length()).unwrap_or(0.0));
        if from.distance(to) <= DOT * unit {
            // Hidden under the dot.
        } else if place.area.grown(place.below + HEAD * unit).contains(to) {
            error_arrow(drawing, from, to, colour, unit);
        }
        if place.area.contains(from) {
            dot(drawing, from, colour, unit);
        }
    }
    if let Some(zoom) = zoom {
        for window in zoom.windows(k) {
            let area = Rect { min: place.of_px(window.min), max: place.of_px(window.max) };
            drawing.frame(&area, Stroke::solid(WHITE, 6.0 * unit));
            drawing.frame(&area, Stroke::solid(ACCENT, 3.0 * unit));
        }
    }
    halves(drawing, layout, &place, panel.seam_px);
    drawing.frame(&place.area, Stroke::solid(GREY, unit));
    place.area.max.y + place.below
}

/// How many corners a panel has and how large their errors are, in words.
fn summary(panel: &Panel) -> String {
    let sizes = sizes(panel);
    let skipped = match panel.corners.len() - sizes.len() {
        0 => String::new(),
        skipped => format!(" (+ {skipped} without a number)"),
    };
    if sizes.is_empty() && panel.found > panel.corners.len() {
        return format!("{} corners, whose designed places are not known", panel.found);
    }
    if sizes.is_empty() {
        return format!("no corners detected{skipped}");
    }
    let [rms, largest] = [stats::rms(&sizes), stats::max_abs(&sizes)].map(|v| axis::significant(v, 3));
    format!("{} corners{skipped}, error RMS {rms} px, largest {largest} px", sizes.len())
}

/// Draws the key of both panels from `top` on; ends with its lower edge.
pub(super) fn key(
    drawing: &mut Drawing,
    layout: &Layout,
    input: &ComparisonInput,
    top: f64,
    errors: &Axis,
    zoom: Option<&Zoom>,
) -> f64 {
    let (unit, font) = (layout.unit, layout.small);
    let errors_of_all = input.panels.iter().map(sizes).collect::<Vec<_>>().concat();
    let bar = Rect {
        min: DVec2::new(layout.right_half + 0.1 * layout.half, top).round(),
        max: DVec2::new(layout.right_half + 0.9 * layout.half, top + 20.0 * unit).round(),
    };
    let caption = match input.panels.len() {
        0 | 1 => "length of the corner error, px",
        2 => "length of the corner error, px (both panels)",
        _ => "length of the corner error, px (all panels)",
    };
    let under = match errors_of_all.is_empty() {
        true => bar.max.y,
        false => colour_bar::draw(drawing, &bar, errors, Map::Marks, caption, font),
    };

    let left = layout.left[0];
    let sign = 56.0 * unit;
    let words = |drawing: &mut Drawing, x: f64, y: f64, words: &str| {
        drawing.text(words, font, INK, DVec2::new(x, y + 0.5 * CAP_HEIGHT * font.size_px), Align::Start);
        x + text::width(words, font) + 34.0 * unit
    };
    let y = top + 0.5 * font.size_px;
    let mut x = left;
    if !errors_of_all.is_empty() {
        dot(drawing, DVec2::new(x + 0.5 * sign, y), INK, unit);
        x = words(drawing, x + sign, y, "detected corner");
    }
    let seam = Stroke::dashed(INK, 2.0 * unit, SEAM_DASH.map(|d| d * unit));
    drawing.line(DVec2::new(x, y), DVec2::new(x + 0.8 * sign, y), seam);
    x = words(drawing, x + sign, y, "seam of the halves L, R");
    if zoom.is_some() {
        let sample = Rect { min: DVec2::new(x, y - 9.0 * unit), max: DVec2::new(x + 0.7 * sign, y + 9.0 * unit) };
        drawing.frame(&sample, Stroke::solid(ACCENT, 3.0 * unit));
        words(drawing, x + sign, y, "enlarged below");
    }

    let y = y + 1.9 * font.size_px;
    let per_px =
        if input.panels.is_empty() { 0.0 } else { input.arrow_gain * PanelPlace::of(input, layout, 0, 0.0).scale };
    if per_px > 0.0 && per_px.is_finite() && !errors_of_all.is_empty() {
        let sample = axis::round_below(100.0 * unit / per_px);
        let tip = DVec2::new(left + sample * per_px, y);
        let share = errors.share(sample).unwrap_or(0.0);
        error_arrow(drawing, DVec2::new(left, y), tip, Map::Marks.colour(share), unit);
        let x = words(drawing, tip.x + 0.4 * font.size_px, y, &format!("error of {} px", axis::short(sample)))
            - 34.0 * unit;
        let drawn = format!(", drawn {} × as long", axis::short(input.arrow_gain));
        words(drawing, x, y, &drawn);
    }
    let y = y + 1.7 * font.size_px;
    words(drawing, left, y, "error: detected corner − its place by the design; pictures paled");
    under.max(y + font.size_px)
}

/// The seam and the names of the halves.
fn halves(drawing: &mut Drawing, layout: &Layout, place: &PanelPlace, seam_px: f64) {
    let (unit, font) = (layout.unit, layout.strong);
    let seam = place.of_px(DVec2::new(seam_px, 0.0)).x;
    let ends = [DVec2::new(seam, place.area.min.y), DVec2::new(seam, place.area.max.y)];
    drawing.line_within(&place.area, &ends, Stroke::solid(WHITE, 4.0 * unit));
    drawing.line_within(&place.area, &ends, Stroke::dashed(INK, 2.0 * unit, SEAM_DASH.map(|d| d * unit)));
    for (name, left) in [("L", place.area.min.x), ("R", seam)] {
        let side = 1.4 * font.size_px;
        let min = DVec2::new(left, place.area.min.y) + 8.0 * unit;
        let badge = Rect { min, max: min + side };
        if place.area.contains(badge.min) && place.area.contains(badge.max) {
            drawing.push(Item::Fill(badge, WHITE));
            let foot = DVec2::new(min.x + 0.5 * side, min.y + 0.5 * (side + CAP_HEIGHT * font.size_px));
            drawing.text(name, font, INK, foot, Align::Middle);
        }
    }
}

/// A corner.
fn dot(drawing: &mut Drawing, centre: DVec2, colour: Rgb, unit: f64) {
    drawing.push(Item::Disc(centre, DOT * unit, colour));
}

/// An arrow with a white rim.
fn error_arrow(drawing: &mut Drawing, from: DVec2, to: DVec2, colour: Rgb, unit: f64) {
    let rim = (to - from).normalize_or_zero() * (1.5 * unit);
    drawing.arrow(from, to + rim, Stroke::solid(WHITE, (SHAFT + 2.5) * unit), (HEAD + 4.0) * unit);
    drawing.arrow(from, to, Stroke::solid(colour, SHAFT * unit), HEAD * unit);
}
