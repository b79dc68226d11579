//! A [`Drawing`] as pixels, with tiny-skia.
//!
//! Everything is antialiased, and lines are at least one px wide and cut at the border before they are drawn: tiny-skia's
//! hairlines panic or shift at the border otherwise (its issues 100 and 189).

use super::colour::Rgb;
use super::drawing::{Drawing, Item, Stroke, clipped};
use super::text;
use crate::geom::Rect;
use crate::raster::Raster;
use glam::DVec2;
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, StrokeDash, Transform};

/// Draws the figure on white paper.
pub(crate) fn paint(drawing: &Drawing) -> Pixmap {
    let mut pixmap = Pixmap::new(drawing.width_px(), drawing.height_px()).expect("a drawing's sides are bounded");
    pixmap.fill(Color::WHITE);
    for item in drawing.items() {
        paint_item(&mut pixmap, item);
    }
    pixmap
}

/// Draws the figure on white paper, as sRGB.
pub fn raster(drawing: &Drawing) -> Raster<Rgb> {
    let pixmap = paint(drawing);
    // The paper is opaque and so is every shape: premultiplied values are plain values.
    let data = pixmap.pixels().iter().map(|p| [p.red(), p.green(), p.blue()]).collect();
    Raster::from_data(pixmap.width() as usize, pixmap.height() as usize, data)
}

fn paint_item(pixmap: &mut Pixmap, item: &Item) {
    match item {
        Item::Fill(rect, colour) => {
            let Rect { min, max } = *rect;
            fill_polygon(pixmap, &[min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)], *colour);
        }
        Item::Line(points, stroke) => stroke_line(pixmap, points, stroke),
        Item::Polygon(points, colour) => fill_polygon(pixmap, points, *colour),
        Item::Disc(centre, radius, colour) => {
            if let Some(path) = PathBuilder::from_circle(centre.x as f32, centre.y as f32, *radius as f32) {
                fill(pixmap, &path, *colour);
            }
        }
        Item::Text(label) => {
            let outline = text::outline(&label.text, label.font, label.at, label.align, label.direction);
            if let Some(path) = outline {
                fill(pixmap, &path, label.colour);
            }
        }
        Item::Picture(rect, picture) => paint_picture(pixmap, rect, picture),
    }
}

fn solid(colour: Rgb) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(colour[0], colour[1], colour[2], 255);
    paint
}

fn fill(pixmap: &mut Pixmap, path: &Path, colour: Rgb) {
    pixmap.fill_path(path, &solid(colour), FillRule::Winding, Transform::identity(), None);
}

fn fill_polygon(pixmap: &mut Pixmap, points: &[DVec2], colour: Rgb) {
    let mut path = PathBuilder::new();
    for (i, point) in points.iter().enumerate() {
        match i {
            0 => path.move_to(point.x as f32, point.y as f32),
            _ => path.line_to(point.x as f32, point.y as f32),
        }
    }
    path.close();
    // A path with a coordinate that is not finite has no bounds, and is not finished.
    if let Some(path) = path.finish() {
        fill(pixmap, &path, colour);
    }
}

fn stroke_line(pixmap: &mut Pixmap, points: &[DVec2], stroke: &Stroke) {
    let sheet = Rect { min: DVec2::ZERO, max: DVec2::new(pixmap.width().into(), pixmap.height().into()) };
    // A closed line stays closed, so that its last corner is as sharp as the others.
    let closed = points.len() > 2 && points.first() == points.last();
    for part in clipped(&sheet.grown(4.0 + stroke.width_px), points) {
        let mut path = PathBuilder::new();
        path.move_to(part[0].x as f32, part[0].y as f32);
        for p in &part[1..] {
            path.line_to(p.x as f32, p.y as f32);
        }
        if closed && part.first() == part.last() {
            path.close();
        }
        if let Some(path) = path.finish() {
            stroke_path(pixmap, &path, stroke);
        }
    }
}

fn stroke_path(pixmap: &mut Pixmap, path: &Path, stroke: &Stroke) {
    let style = tiny_skia::Stroke {
        width: stroke.width_px.max(1.0) as f32,
        line_cap: LineCap::Butt,
        line_join: LineJoin::Miter,
        dash: stroke.dash_px.and_then(|dash| StrokeDash::new(dash.map(|d| d as f32).to_vec(), 0.0)),
        ..tiny_skia::Stroke::default()
    };
    pixmap.stroke_path(path, &solid(stroke.colour), &style, Transform::identity(), None);
}

/// Puts the picture over the sheet's pixels whose centres lie in `rect`: each takes the picture's pixel under it.
fn paint_picture(pixmap: &mut Pixmap, rect: &Rect, picture: &Raster<Rgb>) {
    let size = rect.size();
    if picture.data().is_empty() || !(size.x > 0.0 && size.y > 0.0 && size.is_finite()) {
        return;
    }
    let under = |position: f64, start: f64, length: f64, count: usize| {
        let share = (position + 0.5 - start) / length;
        (0.0..1.0).contains(&share).then(|| ((share * count as f64) as usize).min(count - 1))
    };
    let (width, height) = (pixmap.width() as usize, pixmap.height() as usize);
    let column = |x: usize| Some((x, under(x as f64, rect.min.x, size.x, picture.width())?));
    let columns: Vec<(usize, usize)> = (0..width).filter_map(column).collect();
    let pixels = pixmap.pixels_mut();
    for y in 0..height {
        let Some(j) = under(y as f64, rect.min.y, size.y, picture.height()) else { continue };
        for &(x, i) in &columns {
            let [r, g, b] = picture.get(i, j);
            pixels[y * width + x] = tiny_skia::ColorU8::from_rgba(r, g, b, 255).premultiply();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::colour::{INK, WHITE};
    use crate::plot::text::{Align, Font};

    fn rect(x: f64, y: f64, w: f64, h: f64) -> Rect {
        Rect { min: DVec2::new(x, y), max: DVec2::new(x + w, y + h) }
    }

    #[test]
    fn a_rectangle_on_whole_pixels_fills_them_and_no_other() {
        let mut drawing = Drawing::new(8, 6);
        drawing.push(Item::Fill(rect(2.0, 1.0, 3.0, 2.0), INK));
        let picture = raster(&drawing);
        for j in 0..6 {
            for i in 0..8 {
                let inside = (2..5).contains(&i) && (1..3).contains(&j);
                assert_eq!(picture.get(i, j), if inside { INK } else { WHITE }, "{i} {j}");
            }
        }
    }

    #[test]
    fn half_a_pixel_is_half_grey() {
        let mut drawing = Drawing::new(4, 4);
        drawing.push(Item::Fill(rect(1.0, 1.0, 1.5, 2.0), [0; 3]));
        // 4 x 4 subsamples: the cover of half a pixel is exact up to 8-bit rounding.
        assert!(raster(&drawing).get(2, 1)[0].abs_diff(127) <= 2);
    }

    #[test]
    fn a_picture_is_copied_pixel_for_pixel_and_enlarged_in_blocks() {
        let picture = Raster::from_data(2, 2, vec![[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12]]);
        let mut drawing = Drawing::new(9, 9);
        drawing.push(Item::Picture(rect(0.0, 0.0, 2.0, 2.0), picture.clone()));
        drawing.push(Item::Picture(rect(3.0, 3.0, 6.0, 6.0), picture.clone()));
        let out = raster(&drawing);
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            assert_eq!(out.get(i, j), picture.get(i, j));
            for (a, b) in [(0, 0), (2, 0), (0, 2), (2, 2)] {
                assert_eq!(out.get(3 + 3 * i + a, 3 + 3 * j + b), picture.get(i, j));
            }
        }
        assert_eq!(out.get(2, 2), WHITE);
    }

    #[test]
    fn hostile_shapes_neither_panic_nor_leave_a_mark_inside() {
        let mut drawing = Drawing::new(50, 40);
        let stroke = Stroke::solid(INK, 0.0);
        for far in [9e3, 4e4, 1e6, 1e9, 1e30, 1e308, -1e4, -1e9, f64::INFINITY, f64::NAN] {
            let p = DVec2::splat(far);
            drawing.line(p, p + DVec2::new(1.0, 0.0), stroke);
            drawing.push(Item::Disc(p, 5.0, INK));
            drawing.push(Item::Disc(p, f64::NAN, INK));
            drawing.push(Item::Polygon(vec![p, p, p], INK));
            drawing.push(Item::Fill(Rect { min: p, max: p }, INK));
            drawing.push(Item::Picture(Rect { min: p, max: p }, Raster::filled(1, 1, INK)));
            drawing.text("far", Font::regular(12.0), INK, p, Align::Middle);
            drawing.arrow(p, p * 2.0, stroke, 5.0);
        }
        drawing.push(Item::Picture(rect(0.0, 0.0, 5.0, 5.0), Raster::from_data(0, 0, Vec::new())));
        assert!(raster(&drawing).data().iter().all(|&p| p == WHITE));
    }

    #[test]
    fn full_width_lines_and_borders_do_not_panic() {
        for (w, h) in [(1, 1), (7, 3), (256, 100), (8000, 2)] {
            let mut drawing = Drawing::new(w, h);
            let sheet = drawing.sheet();
            drawing.frame(&sheet, Stroke::solid(INK, 0.0));
            drawing.line(sheet.min, sheet.max, Stroke::dashed(INK, 1.0, [3.0, 2.0]));
            assert_eq!(raster(&drawing).get(0, 0), raster(&drawing).get(0, 0));
        }
    }
}
