//! Does docs/exr.md tell what the files of a picture hold: every channel, attribute and key, and no other?

use crate::command::{biprism, text};
use exr::meta::MetaData;
use exr::prelude::{AttributeValue, SampleType, Text};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Scenes that together have every channel and every note: an object before the board; colours with a clipped ridge, in random sets; a sensor
/// with a gamma.
fn scenes() -> [String; 3] {
    let scene = |prism: &str, effects: &str| {
        format!(
            "name = \"small\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 32\nheight_px = 18\npixel_pitch_um = 330.0\n\
             [prism]\nkind = \"flat\"\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n{prism}\n[board]\ncolumns = 7\n\
             rows = 7\nsquare_mm = 30.0\nposition_mm = [0.0, 0.0, 1000.0]\n{effects}\n"
        )
    };
    let glass = "index = 1.5168\nglass = \"N-BK7\"\nwavelength_nm = 587.5618";
    let effects = "[effect.dispersion]\nlines_nm = [486.1327, 587.5618]\nresponse = \"nikon_d5100\"\n[effect.clipping]\nchamfer_mm = 0.2\n\
                   [effect.thin_lens]\nf_number = 8.0\nfocus_mm = 990.0\n[quadrature]\npoints = 2\nreplicates = 8\n";
    let sensor = "[effect.sensor]\ngamma = 2.2\n";
    let object = "[[object]]\ncolumns = 2\nrows = 2\nsquare_mm = 30.0\nposition_mm = [0.0, 0.0, 900.0]\n";
    [scene("index = 1.48", object), scene(glass, effects), scene("index = 1.48", sensor)]
}

/// The words between backticks in the first cells of the rows of the tables under a heading, with the second cell.
fn rows(page: &str, heading: &str) -> BTreeMap<String, String> {
    let start = page.find(&format!("\n## {heading}\n")).unwrap_or_else(|| panic!("no part is called {heading:?}"));
    let part = page[start + 4..].split("\n## ").next().expect("a part");
    let mut found = BTreeMap::new();
    for line in part.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        for word in cells[1].split('`').skip(1).step_by(2) {
            found.insert(word.to_owned(), cells[2].to_owned());
        }
    }
    found
}

#[test]
fn every_channel_attribute_and_key_stands_on_the_page() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("docs/exr.md")).expect("the page is there");
    let folder = tempfile::tempdir().expect("a folder");
    let (mut channels, mut keys) = (BTreeMap::new(), BTreeSet::new());
    let (mut attributes, mut classes) = (BTreeSet::new(), Vec::new());
    for scene in scenes() {
        fs::write(folder.path().join("scene.toml"), scene).expect("written");
        let halves = ["render", "scene.toml", "--stereo", "--halves", "--out", "a.exr", "--out", "a.png"];
        let done = biprism(folder.path(), &halves);
        assert!(done.status.success(), "{}", text(&done.stderr));
        let meta = MetaData::read_from_file(folder.path().join("a_left.exr"), true).expect("a header");
        let [header] = &meta.headers[..] else { panic!("one part") };
        for channel in &header.channels.list {
            let kind = if channel.sample_type == SampleType::U32 { "u32" } else { "f32" };
            channels.insert(channel.name.to_string(), kind.to_owned());
        }
        let own = &header.own_attributes;
        attributes.extend(own.other.keys().map(ToString::to_string));
        attributes.extend(own.software_name.is_some().then_some("software".to_owned()));
        attributes.extend(own.horizontal_density.is_some().then_some("xDensity".to_owned()));
        let Some(AttributeValue::Text(notes)) = own.other.get(&Text::from("biprism")) else { panic!("notes") };
        let notes: serde_json::Value = serde_json::from_str(&notes.to_string()).expect("JSON");
        keys.extend(notes.as_object().expect("an object").keys().cloned());
        let named = notes["class"].as_array().expect("a list").clone();
        classes = if named.len() > classes.len() { named } else { classes };
        let (_, png) = biprism::io::read(&folder.path().join("a_left.png"), None).expect("a picture");
        assert_eq!(png.texts["biprism"].parse::<serde_json::Value>().expect("JSON"), notes, "the PNG has other notes");
    }
    assert_eq!(rows(&page, "Channels of the EXR"), channels, "the page's channels, and those of the files");
    for (k, name) in classes.iter().enumerate() {
        let row = format!("\n| {k} | `{}` |", name.as_str().expect("a word"));
        assert!(page.contains(&row), "docs/exr.md lacks {row}");
    }
    let told = rows(&page, "Attributes of the EXR");
    let told: BTreeSet<String> = told.into_keys().collect();
    let written: BTreeSet<String> = attributes.into_iter().chain(keys).collect();
    assert_eq!(told, written, "the page's attributes and keys, and those of the files");
}
