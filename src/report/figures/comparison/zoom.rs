//! The lower half of the comparison: the corner of the board with the largest vertical disparity in the first picture, enlarged
//! from both halves of each picture beside one another, row by row, so that a pair that a matcher can use shows no step.

use super::corner_mark::CornerMark;
use super::input::{Panel, drawable};
use super::layout::{Layout, letter};
use crate::geom::Rect;
use crate::plot::colour::{ACCENT, GREY, INK, SERIES, WHITE};
use crate::plot::drawing::{Drawing, Item, Stroke};
use crate::plot::text::{Align, CAP_HEIGHT, LINE_HEIGHT};
use crate::plot::{axis, picture, text};
use glam::DVec2;
use std::collections::BTreeMap;

/// Height of a window in the figure over the width of a column.
const PROPORTION: f64 = 0.36;
/// Height of the window in disparities of the first picture, and its least and largest height in px of the picture.
const HEIGHT: f64 = 4.0;
const LEAST_HEIGHT_PX: f64 = 16.0;
const LARGEST_HEIGHT_PX: f64 = 400.0;

/// A corner of the board in both halves, in px of the whole picture: left, right.
pub(super) type SeenTwice = [DVec2; 2];

/// The corners that both halves show, by column and row; the halves meet at the panel's seam.
pub(super) fn seen_twice(panel: &Panel) -> BTreeMap<[i32; 2], SeenTwice> {
    let of = |right: bool| {
        let own = move |corner: &&CornerMark| drawable(corner) && (corner.position_px.x >= panel.seam_px) == right;
        panel.corners.iter().filter(own).map(|corner| (corner.index, corner.position_px))
    };
    let right: BTreeMap<[i32; 2], DVec2> = of(true).collect();
    of(false).filter_map(|(index, left)| Some((index, [left, *right.get(&index)?]))).collect()
}

/// How much lower the right half shows a corner, in px.
fn lower_px([left, right]: &SeenTwice) -> f64 {
    right.y - left.y
}

/// The corner with the largest vertical disparity.
fn worst(seen: &BTreeMap<[i32; 2], SeenTwice>) -> Option<([i32; 2], SeenTwice)> {
    let largest = seen.iter().max_by(|a, b| lower_px(a.1).abs().total_cmp(&lower_px(b.1).abs()))?;
    Some((*largest.0, *largest.1))
}

/// A corner of the board, and its windows in a panel.
struct ZoomPlace {
    /// Column and row.
    index: [i32; 2],
    pair: SeenTwice,
    /// Around it in the left and in the right half.
    windows: [Rect; 2],
}

/// The windows of all panels.
pub(super) struct Zoom {
    /// Columns and rows of a window, whole px of the picture.
    size: DVec2,
    /// The corner with the largest vertical disparity in the first panel, in every panel that shows it twice; in another the
    /// one with its own largest, and none where none is shown twice.
    places: Vec<Option<ZoomPlace>>,
}

impl Zoom {
    /// The corner with the largest vertical disparity in the first panel; `None` where that shows none twice.
    pub(super) fn of(panels: &[Panel]) -> Option<Self> {
        let first = seen_twice(panels.first()?);
        let (worst, pair) = worst(&first)?;
        let height = libm::ceil((HEIGHT * lower_px(&pair).abs()).clamp(LEAST_HEIGHT_PX, LARGEST_HEIGHT_PX));
        let size = DVec2::new(libm::ceil(0.5 * height / PROPORTION), height);
        let place = |panel: &Panel| {
            let seen = seen_twice(panel);
            let (index, pair) = seen.get(&worst).map(|pair| (worst, *pair)).or_else(|| self::worst(&seen))?;
            let whole = DVec2::new(panel.picture.width() as f64, panel.picture.height() as f64);
            if whole.cmplt(size).any() {
                return None;
            }
            // Both windows hold the same rows.
            let middle = 0.5 * (pair[0].y + pair[1].y);
            let window = |px: DVec2| {
                let min = (DVec2::new(px.x, middle) - 0.5 * size).round().clamp(DVec2::ZERO, whole - size);
                Rect { min, max: min + size }
            };
            Some(ZoomPlace { index, pair, windows: pair.map(window) })
        };
        Some(Self { size, places: panels.iter().map(place).collect() })
    }

    /// The windows of panel `k` in px of its picture.
    pub(super) fn windows(&self, k: usize) -> impl Iterator<Item = Rect> {
        self.places.get(k).and_then(Option::as_ref).into_iter().flat_map(|place| place.windows)
    }

    /// Draws the windows of panel `k` from `top` on; ends with its lower edge.
    pub(super) fn draw(&self, drawing: &mut Drawing, layout: &Layout, panel: &Panel, k: usize, top: f64) -> f64 {
        let (left, unit) = (layout.left[k % layout.left.len()], layout.unit);
        let min = DVec2::new(left, top.round());
        let area = Rect { min, max: min + DVec2::new(layout.column, (PROPORTION * layout.column).round()) };
        let caption = match &self.places[k] {
            Some(place) => {
                self.draw_pair(drawing, layout, panel, &area, (&place.pair, &place.windows));
                format!(
                    "({}) {} px of vertical disparity",
                    letter(k),
                    axis::significant(lower_px(&place.pair).abs(), 3)
                )
            }
            None => format!("({}) no corner is found in both halves", letter(k)),
        };
        drawing.frame(&area, Stroke::solid(ACCENT, 3.0 * unit));

        // What it shows, and where that is.
        let times = axis::significant(area.size().y / self.size.y, 2);
        let corner = self.places[k].as_ref().map(|place| {
            let [column, row] = place.index.map(|n| n.to_string().replace('-', "−"));
            format!(
                "corner in column {column}, row {row}; {} × {} px of each half, {times} ×",
                self.size.x, self.size.y
            )
        });
        let mut y = area.max.y + 1.4 * layout.strong.size_px;
        for (words, font, colour) in [(caption, layout.strong, INK), (corner.unwrap_or_default(), layout.small, GREY)] {
            drawing.text(text::shortened(&words, font, area.size().x), font, colour, DVec2::new(left, y), Align::Start);
            y += LINE_HEIGHT * layout.small.size_px;
        }
        y - LINE_HEIGHT * layout.small.size_px + text::DESCENT * layout.small.size_px
    }

    /// The windows of both halves beside one another, the row of the left corner across both, and the step to the right one.
    fn draw_pair(
        &self,
        drawing: &mut Drawing,
        layout: &Layout,
        panel: &Panel,
        area: &Rect,
        (pair, windows): (&SeenTwice, &[Rect; 2]),
    ) {
        // The pixels, each a square.
        let (unit, font) = (layout.unit, layout.strong);
        let width = (0.5 * area.size().x).floor();
        let of_half = |k: usize| {
            let min = area.min + DVec2::new(k as f64 * width, 0.0);
            Rect { min, max: DVec2::new(if k == 0 { min.x + width } else { area.max.x }, area.max.y) }
        };
        let [columns, rows] = self.size.to_array().map(|n| n as usize);
        for (k, name) in [(0, "left half"), (1, "right half")] {
            let shown = of_half(k);
            let [x, y] = windows[k].min.to_array().map(|v| v as usize);
            drawing.push(Item::Picture(shown, picture::grey(&picture::cut_out(panel.picture, x, y, columns, rows))));
            let badge = DVec2::new(text::width(name, font) + font.size_px, 1.4 * font.size_px);
            drawing.push(Item::Fill(Rect { min: shown.min, max: shown.min + badge }, WHITE));
            let foot = shown.min + 0.5 * badge + DVec2::new(0.0, 0.5 * CAP_HEIGHT * font.size_px);
            drawing.text(name, font, INK, foot, Align::Middle);
        }
        let seam = [DVec2::new(area.min.x + width, area.min.y), DVec2::new(area.min.x + width, area.max.y)];
        drawing.line(seam[0], seam[1], Stroke::solid(WHITE, 6.0 * unit));
        drawing.line(seam[0], seam[1], Stroke::solid(INK, 2.0 * unit));

        // The row of the left corner, and both corners.
        let place = |k: usize| of_half(k).min + (pair[k] - windows[k].min) * (of_half(k).size() / self.size);
        let [from, to] = [place(0), place(1)];
        for stroke in [Stroke::solid(WHITE, 4.5 * unit), straight(unit)] {
            drawing.line_within(area, &[from, DVec2::new(area.max.x, from.y)], stroke);
        }
        for corner in [from, to].into_iter().filter(|&corner| area.contains(corner)) {
            drawing.push(Item::Disc(corner, 8.0 * unit, WHITE));
            drawing.push(Item::Disc(corner, 6.0 * unit, SERIES[0]));
        }
        self.step(drawing, layout, area, [DVec2::new(to.x, from.y), to], lower_px(pair));
    }

    /// The step from the row of the left corner to the right corner, with its size.
    fn step(&self, drawing: &mut Drawing, layout: &Layout, area: &Rect, [from, to]: [DVec2; 2], lower_px: f64) {
        if !(area.contains(from) && area.contains(to)) {
            return;
        }
        let (unit, font) = (layout.unit, layout.strong);
        if from.distance(to) > 16.0 * unit {
            drawing.line(from, to, Stroke::solid(WHITE, 8.0 * unit));
            drawing.line(from, to, Stroke::solid(INK, 4.0 * unit));
        }
        let words = format!("{} px", axis::significant(lower_px.abs(), 3));
        let size = DVec2::new(text::width(&words, font) + font.size_px, 1.5 * font.size_px);
        let middle = to + DVec2::new(0.5 * size.x + 20.0 * unit, if lower_px < 0.0 { -size.y } else { size.y });
        let min = (middle - 0.5 * size).min(area.max - size).max(area.min);
        drawing.push(Item::Fill(Rect { min, max: min + size }, WHITE));
        let foot = DVec2::new(min.x + 0.5 * size.x, min.y + 0.5 * (size.y + CAP_HEIGHT * font.size_px));
        drawing.text(words, font, INK, foot, Align::Middle);
    }

    /// The key of the windows from `top` on; ends with its lower edge.
    pub(super) fn key(drawing: &mut Drawing, layout: &Layout, top: f64) -> f64 {
        let (unit, font) = (layout.unit, layout.small);
        let y = top + 1.3 * font.size_px;
        let (x, middle) = (layout.left[0], y - 0.5 * CAP_HEIGHT * font.size_px);
        drawing.line(DVec2::new(x, middle), DVec2::new(x + 58.0 * unit, middle), straight(unit));
        let words =
            "the row of the corner in the left half: a stereo matcher looks for it on that row of the right half";
        drawing.text(words, font, INK, DVec2::new(x + 70.0 * unit, y), Align::Start);
        y + text::DESCENT * font.size_px
    }
}

fn straight(unit: f64) -> Stroke {
    Stroke::dashed(ACCENT, 2.5 * unit, [14.0 * unit, 8.0 * unit])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Raster;

    #[test]
    fn the_windows_of_a_pair_hold_the_same_rows_of_the_picture_around_the_worst_corner() {
        let mark = |column: i32, x: f64, y: f64| CornerMark {
            index: [column, 4],
            position_px: DVec2::new(x, y),
            error_px: DVec2::ZERO,
        };
        // Column 7 is 6 px lower in the right half, column 8 is 2 px higher, and column 9 is seen once.
        let corners =
            [mark(7, 30.0, 50.0), mark(7, 130.0, 56.0), mark(8, 60.0, 50.0), mark(8, 160.0, 48.0), mark(9, 90.0, 9.0)];
        let picture = Raster::filled(200, 100, 0.5);
        let panel = Panel { name: String::new(), picture: &picture, corners: &corners, seam_px: 100.0, found: 0 };
        let [others, none] = [&corners[2..], &corners[4..]].map(|corners| Panel { corners, ..panel.clone() });
        let zoom = Zoom::of(&[panel, others, none]).expect("corners are seen twice");
        assert_eq!(zoom.places[0].as_ref().map(|place| place.index), Some([7, 4]));
        assert_eq!(zoom.places[1].as_ref().map(|place| place.index), Some([8, 4]), "its own worst one");
        let windows: Vec<Rect> = zoom.windows(0).collect();
        assert_eq!(windows.len(), 2);
        assert_eq!([windows[0].min.y, windows[0].max.y], [windows[1].min.y, windows[1].max.y]);
        let whole = Rect { min: DVec2::ZERO, max: DVec2::new(200.0, 100.0) };
        for (window, corner) in windows.iter().zip(&corners[..2]) {
            assert!(window.contains(corner.position_px) && window.size() == zoom.size, "{window:?}");
            assert!(whole.contains(window.min) && whole.contains(window.max), "{window:?}");
        }
        assert_eq!(zoom.windows(2).count(), 0, "the third panel shows no corner twice");
    }
}
