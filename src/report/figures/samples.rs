//! Test samples: pictures and corners of a realistic shape, and figures written out for inspection.

use super::comparison::CornerMark;
use crate::plot::drawing::{Drawing, Item};
use crate::plot::{canvas, text};
use crate::raster::Raster;
use glam::DVec2;

/// Side of a square of the board, in px.
const SQUARE: f64 = 64.0;

/// Where the corner that the ideal pinhole sees at `ideal` (in px of a half image of 960 x 1080, from its middle) is
/// seen: up to `largest` px away, and rows and columns are bent.
fn seen(ideal: DVec2, largest: f64) -> DVec2 {
    let n = ideal / DVec2::new(480.0, 540.0);
    ideal + DVec2::new(0.2 * n.x * n.x + 0.8 * n.y * n.y, 0.7 * n.x * n.y) * (largest / 1.22)
}

/// The stereo image of a checkerboard through a prism that moves corners by up to `largest` px; mirror images.
pub(super) fn board(largest: f64) -> (Raster<f32>, Vec<CornerMark>) {
    let side = |x: f64| if x < 960.0 { -1.0 } else { 1.0 };
    let in_half = |p: DVec2| DVec2::new((p.x - 960.0 - 480.0 * side(p.x)) * side(p.x), p.y - 540.0);
    let value = |p: DVec2| {
        let there = in_half(p);
        // The map is undone by iteration: it moves little.
        let ideal = (0..6).fold(there, |ideal, _| there - (seen(ideal, largest) - ideal));
        let cell = (ideal / SQUARE).floor();
        if (cell.x + cell.y).rem_euclid(2.0) == 0.0 { 0.9 } else { 0.05 }
    };
    let subsamples = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)];
    let pixel = |i: usize, j: usize| {
        let sum: f64 = subsamples.iter().map(|(dx, dy)| value(DVec2::new(i as f64 + dx, j as f64 + dy))).sum();
        (0.25 * sum) as f32
    };
    let data = (0..1080).flat_map(|j| (0..1920).map(move |i| (i, j))).map(|(i, j)| pixel(i, j)).collect();
    let mut corners = Vec::new();
    for s in [-1.0, 1.0] {
        for row in -8..=8 {
            for column in -7..=7 {
                let ideal = DVec2::new(f64::from(column), f64::from(row)) * SQUARE;
                let real = seen(ideal, largest);
                if real.x.abs() < 475.0 && real.y.abs() < 535.0 {
                    let flip = DVec2::new(s, 1.0);
                    let position_px = DVec2::new(960.0 + 480.0 * s, 540.0) + real * flip;
                    corners.push(CornerMark { index: [column, row], position_px, error_px: (real - ideal) * flip });
                }
            }
        }
    }
    (Raster::from_data(1920, 1080, data), corners)
}

/// Writes a file into the folder that FIGURE_DIR names, for inspection; nothing where it names none.
pub(crate) fn keep(name: &str, bytes: &[u8]) {
    if let Some(folder) = std::env::var_os("FIGURE_DIR") {
        std::fs::write(std::path::Path::new(&folder).join(name), bytes).unwrap();
    }
}

/// Checks every figure: no text leaves the sheet, none covers another, and the pixels are the same again.
pub(crate) fn examine(name: &str, drawing: &Drawing) {
    let picture = canvas::raster(drawing);
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, drawing.width_px(), drawing.height_px());
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(picture.data().as_flattened()).unwrap();
    writer.finish().unwrap();
    keep(&format!("{name}.png"), &png);
    assert!(picture == canvas::raster(drawing), "{name}: two runs differ");
    let labels =
        || drawing.items().iter().filter_map(|item| if let Item::Text(label) = item { Some(label) } else { None });
    for label in labels() {
        let b = label.bounds();
        assert!(
            drawing.sheet().contains(b.min) && drawing.sheet().contains(b.max),
            "{name}: {label:?} leaves the sheet"
        );
        assert!(text::width(&label.text, label.font) > 0.0);
    }
    for (k, a) in labels().enumerate() {
        for b in labels().skip(k + 1) {
            // The bounds leave room for accents and descenders that may touch; the letters' core must not.
            let core = 0.15 * a.font.size_px.min(b.font.size_px);
            let (p, q) = (a.bounds().grown(-core), b.bounds().grown(-core));
            let apart = p.max.x <= q.min.x || q.max.x <= p.min.x || p.max.y <= q.min.y || q.max.y <= p.min.y;
            assert!(apart, "{name}: {:?} covers {:?}", a.text, b.text);
        }
    }
}

/// Whether the figure holds a line of exactly these words.
pub(crate) fn says(drawing: &Drawing, words: &str) -> bool {
    drawing.items().iter().any(|item| matches!(item, Item::Text(label) if label.text == words))
}
