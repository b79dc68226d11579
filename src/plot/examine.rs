//! For the tests: a way to look at a figure.

use super::drawing::{Drawing, Item};
use super::{canvas, text};

/// Writes a file into the folder that FIGURE_DIR names, to be looked at; nothing where it names none.
pub(crate) fn keep(name: &str, bytes: &[u8]) {
    if let Some(folder) = std::env::var_os("FIGURE_DIR") {
        std::fs::write(std::path::Path::new(&folder).join(name), bytes).unwrap();
    }
}

/// Asks of every figure: no text leaves the sheet, none covers another, and the pixels are the same again.
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
