//! Makes `docs/metrics.md` from the meanings of the figures: `cargo run --release --example metrics_page`.
//!
//! `tests/documents.rs` holds the page against [`page`].

use biprism::report::metric_meaning::METRICS;
use std::fmt::Write;
use std::path::Path;

const INTRODUCTION: &str = "# What each figure means

Made by `cargo run --release --example metrics_page`; do not edit. The same words stand behind every name in `report.html`.

Every figure comes twice: *measured* from the corners that the detector finds in the picture, and *true* from rays traced to the
same corners. Positions are in px, pixel (i, j) covering [i, i+1) x [j, j+1), each half from its own top left corner, raw: nothing
is rectified unless a row says so. N counts vectors, never their components. `report.json` has each figure with its unit, N,
normaliser, frame and depths ([json.md](json.md)).
";

/// The whole page.
pub(crate) fn page() -> String {
    let mut text = INTRODUCTION.to_owned();
    for metric in &METRICS {
        let name = metric.label.replace('|', "\\|");
        let body = format!(
            "\n## {name}\n\n`{}`\n\n{}.\n\n- Mind: {}\n- Source: {}.\n",
            metric.key, metric.formula, metric.trap, metric.source
        );
        text.write_str(&body).expect("writing to a string cannot fail");
    }
    text
}

#[allow(dead_code, reason = "the test that holds the page against the meanings takes `page` alone")]
fn main() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/metrics.md");
    std::fs::write(&path, page()).expect("the page can be written");
    println!("wrote {}", path.display());
}
