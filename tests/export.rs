//! `export`: are the files for other programs what the prism is?

mod bodies;
mod grids;
mod lenses;

use crate::command::{biprism, json, repository};
use biprism::Scene;
use biprism::scene;
use biprism::system::{self, System};
use serde_json::Value;
use std::path::Path;

/// A scene of the goldens.
fn case(name: &str) -> Scene {
    scene::load(&repository(&format!("scenes/cases/{name}.toml"))).unwrap_or_else(|problem| panic!("{problem}"))
}

fn built(scene: &Scene) -> System {
    system::build(scene).unwrap_or_else(|problem| panic!("{problem}"))
}

/// The scene of the goldens with the tables of another prism, which may name files in `folder`.
fn with_prism(name: &str, prism: &str, folder: &Path) -> Scene {
    let text = std::fs::read_to_string(repository(&format!("scenes/cases/{name}.toml"))).expect("it is there");
    let (start, end) = (text.find("[prism]").expect("a prism"), text.find("[board]").expect("a board"));
    let text = format!("{}{prism}\n{}", &text[..start], &text[end..]);
    scene::parse(&text, "again", Some(folder)).unwrap_or_else(|problem| panic!("{problem}"))
}

/// What `biprism export` of a scene of the goldens prints as JSON, its files in `folder`.
fn exported(name: &str, format: &str, folder: &Path, more: &[&str]) -> Value {
    let path = repository(&format!("scenes/cases/{name}.toml")).display().to_string();
    let args = ["export", path.as_str(), "--format", format, "--out", ".", "--json"];
    json(&biprism(folder, &[&args[..], more].concat()))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}
