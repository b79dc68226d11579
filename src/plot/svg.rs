//! A [`Drawing`] as SVG text: the same shapes in the same order, for a page or a paper.
//!
//! Text stays text (it can be found and copied), in DejaVu Sans or a font of its widths.

use super::colour::Rgb;
use super::drawing::{Drawing, Item, Label, Stroke};
use super::glyphs::Weight;
use super::text::{Align, Direction};
use crate::geom::Rect;
use crate::io::embedded_picture::rgb_png_bytes;
use crate::raster::Raster;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec2;
use std::fmt::Write;

/// The figure as a whole SVG document, named `title` for those who cannot see it.
pub fn write(drawing: &Drawing, title: &str) -> String {
    let (width, height) = (drawing.width_px(), drawing.height_px());
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" role=\"img\" font-family=\"'DejaVu Sans', Verdana, sans-serif\">\n<title>{}</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n",
        escaped(title)
    );
    for item in drawing.items() {
        svg += &element(item).unwrap_or_default();
    }
    svg + "</svg>\n"
}

/// One shape; `None` when a position in it is not a number, so that it has no place.
fn element(item: &Item) -> Option<String> {
    Some(match item {
        Item::Fill(rect, colour) => format!("<rect {} fill=\"{}\"/>\n", area(rect)?, hex(*colour)),
        Item::Line(points, stroke) => {
            format!("<polyline points=\"{}\" fill=\"none\" {}/>\n", list(points)?, stroked(stroke))
        }
        Item::Polygon(points, colour) => {
            format!("<polygon points=\"{}\" fill=\"{}\"/>\n", list(points)?, hex(*colour))
        }
        Item::Disc(centre, radius, colour) => {
            format!("<circle {} fill=\"{}\"/>\n", circle(*centre, *radius)?, hex(*colour))
        }
        Item::Text(label) => text(label)?,
        Item::Picture(rect, pixels) => picture(rect, pixels)?,
    })
}

/// A coordinate to a hundredth of a px; `None` beyond what any sheet can show.
fn number(value: f64) -> Option<String> {
    let within = value.is_finite() && value.abs() < 1e6;
    let text = format!("{value:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    within.then(|| if short == "-0" { "0".to_owned() } else { short.to_owned() })
}

fn list(points: &[DVec2]) -> Option<String> {
    let pairs: Option<Vec<String>> =
        points.iter().map(|p| Some(format!("{},{}", number(p.x)?, number(p.y)?))).collect();
    Some(pairs?.join(" "))
}

fn area(rect: &Rect) -> Option<String> {
    let (min, size) = (rect.min, rect.size().max(DVec2::ZERO));
    let [x, y, w, h] = [min.x, min.y, size.x, size.y].map(number);
    Some(format!("x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"", x?, y?, w?, h?))
}

fn circle(centre: DVec2, radius: f64) -> Option<String> {
    Some(format!("cx=\"{}\" cy=\"{}\" r=\"{}\"", number(centre.x)?, number(centre.y)?, number(radius.max(0.0))?))
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn stroked(stroke: &Stroke) -> String {
    let width = number(stroke.width_px).unwrap_or_else(|| "1".to_owned());
    let dash =
        stroke.dash_px.and_then(|[on, off]| Some(format!(" stroke-dasharray=\"{} {}\"", number(on)?, number(off)?)));
    format!("stroke=\"{}\" stroke-width=\"{width}\"{}", hex(stroke.colour), dash.unwrap_or_default())
}

fn text(label: &Label) -> Option<String> {
    let (x, y, size) = (number(label.at.x)?, number(label.at.y)?, number(label.font.size_px)?);
    let anchor = match label.align {
        Align::Start => "start",
        Align::Middle => "middle",
        Align::End => "end",
    };
    let weight = match label.font.weight {
        Weight::Regular => "",
        Weight::Bold => " font-weight=\"bold\"",
    };
    let turn = match label.direction {
        Direction::Right => String::new(),
        Direction::Up => format!(" transform=\"rotate(-90 {x} {y})\""),
    };
    Some(format!(
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{weight} text-anchor=\"{anchor}\" fill=\"{}\"{turn}>{}</text>\n",
        hex(label.colour),
        escaped(&label.text)
    ))
}

/// Runs of one colour in a row from which on a picture stands in the figure as a file of its own.
const MOST_RUNS: usize = 4096;

/// A rectangle for each run of one colour in a row; of a picture of many runs the picture itself, each pixel a square.
fn picture(rect: &Rect, pixels: &Raster<Rgb>) -> Option<String> {
    let runs: usize = (0..pixels.height()).map(|j| pixels.row(j).chunk_by(|a, b| a == b).count()).sum();
    if runs > MOST_RUNS {
        let file = STANDARD.encode(rgb_png_bytes(pixels)?);
        let place = area(rect)?;
        return Some(format!(
            "<image {place} preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
             href=\"data:image/png;base64,{file}\"/>\n"
        ));
    }
    let step = rect.size() / DVec2::new(pixels.width() as f64, pixels.height() as f64);
    let mut group = "<g shape-rendering=\"crispEdges\">\n".to_owned();
    for j in 0..pixels.height() {
        let mut start = 0;
        for run in pixels.row(j).chunk_by(|a, b| a == b) {
            let min = rect.min + step * DVec2::new(start as f64, j as f64);
            let max = min + step * DVec2::new(run.len() as f64, 1.0);
            writeln!(group, "<rect {} fill=\"{}\"/>", area(&Rect { min, max })?, hex(run[0])).ok()?;
            start += run.len();
        }
    }
    Some(group + "</g>\n")
}

/// Text for XML: markup escaped, and a space for characters that XML does not allow.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\u{0}'..='\u{1f}' | '\u{7f}'..='\u{9f}' | '\u{fffe}' | '\u{ffff}' => out.push(' '),
            _ => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::colour::INK;
    use crate::plot::text::Font;

    #[test]
    fn each_shape_is_written_as_it_is() {
        let mut drawing = Drawing::new(40, 30);
        drawing.push(Item::Fill(Rect { min: DVec2::new(1.0, 2.5), max: DVec2::new(4.0, 4.5) }, [1, 2, 255]));
        drawing.line(DVec2::ZERO, DVec2::new(-0.001, 3.126), Stroke::dashed(INK, 1.5, [2.0, 1.0]));
        drawing.text("a<b & \"c\"\u{7}", Font::bold(12.0), INK, DVec2::new(5.0, 6.0), Align::End);
        let row = Raster::from_data(4, 1, vec![[9; 3], [9; 3], [9; 3], [8; 3]]);
        drawing.push(Item::Picture(Rect { min: DVec2::ZERO, max: DVec2::new(8.0, 2.0) }, row));
        let svg = write(&drawing, "x > y");
        for part in [
            "<title>x &gt; y</title>",
            "<rect x=\"1\" y=\"2.5\" width=\"3\" height=\"2\" fill=\"#0102ff\"/>",
            "<polyline points=\"0,0 0,3.13\" fill=\"none\" stroke=\"#1a1a1a\" stroke-width=\"1.5\" stroke-dasharray=\"2 1\"/>",
            "font-weight=\"bold\" text-anchor=\"end\" fill=\"#1a1a1a\">a&lt;b &amp; &quot;c&quot; </text>",
            "<rect x=\"0\" y=\"0\" width=\"6\" height=\"2\" fill=\"#090909\"/>",
            "<rect x=\"6\" y=\"0\" width=\"2\" height=\"2\" fill=\"#080808\"/>",
        ] {
            assert!(svg.contains(part), "{part}\n{svg}");
        }
    }

    #[test]
    fn what_has_no_place_is_left_out() {
        let mut drawing = Drawing::new(10, 10);
        for far in [f64::NAN, f64::INFINITY, 1e300] {
            let p = DVec2::splat(far);
            drawing.push(Item::Disc(p, 1.0, INK));
            drawing.line(DVec2::ZERO, p, Stroke::solid(INK, 1.0));
            drawing.text("far", Font::regular(5.0), INK, p, Align::Start);
            drawing.push(Item::Picture(Rect { min: p, max: p }, Raster::filled(2, 2, INK)));
        }
        let svg = write(&drawing, "");
        assert_eq!(svg.lines().count(), 4, "{svg}");
    }
}
