//! A study as it is written: its sheets, its figures, and what it was asked.

use crate::plot::drawing::Drawing;
use crate::report::sheet::StudySheet;
use serde_json::{Map, Value, json};

/// A figure of a study.
#[derive(Debug, Clone)]
pub struct StudyFigure {
    /// The file's name without its ending.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// The drawing.
    pub drawing: Drawing,
}

/// A study as it is written.
#[derive(Debug, Clone)]
pub struct StudyDocument {
    /// The verb's word: `spot`.
    pub name: &'static str,
    /// What it was asked, by name.
    pub settings: Map<String, Value>,
    /// The figures as numbers.
    pub sheets: Vec<StudySheet>,
    /// The figures as pictures.
    pub figures: Vec<StudyFigure>,
}

impl StudyDocument {
    /// The tables for a person, one below the other.
    pub fn tables(&self) -> String {
        self.sheets.iter().filter(|sheet| !sheet.detail).map(StudySheet::table).collect::<Vec<_>>().join("\n")
    }

    /// As JSON: `biprism-study/1`.
    pub fn json(&self) -> String {
        let sheets: Map<String, Value> =
            self.sheets.iter().map(|sheet| (sheet.name.to_owned(), sheet.json())).collect();
        let document =
            json!({ "schema": "biprism-study/1", "study": self.name, "settings": self.settings, "sheets": sheets });
        format!("{document:#}\n")
    }
}
