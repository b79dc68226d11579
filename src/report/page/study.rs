//! The page of a study: its tables, every column with its meaning, and its figures.

use super::origin::PageOrigin;
use super::shell::{self, Scripts};
use crate::plot::svg;
use crate::report::number::number;
use crate::report::sheet::{Cell, StudySheet};
use crate::report::study::document::StudyFigure;
use minijinja::Value;
use serde::Serialize;

/// A page of a study before it is written.
#[derive(Debug)]
pub(crate) struct StudyPage<'a> {
    /// Its title.
    pub title: &'a str,
    /// What a reader must know first.
    pub introduction: &'a str,
    /// The tables; those for programs alone are left out.
    pub sheets: &'a [StudySheet],
    /// The figures under their headings; no heading where it is empty.
    pub figures: Vec<(&'a str, Vec<&'a StudyFigure>)>,
}

/// What fills the template.
#[derive(Serialize)]
struct StudyContext<'a> {
    title: &'a str,
    introduction: &'a str,
    tables: Vec<PageTable<'a>>,
    parts: Vec<FigurePart<'a>>,
    origin: &'a PageOrigin,
}

#[derive(Serialize)]
struct PageTable<'a> {
    heading: &'a str,
    columns: Vec<TableColumn>,
    rows: Vec<Vec<TableCell>>,
}

#[derive(Serialize)]
struct TableColumn {
    key: &'static str,
    meaning: &'static str,
}

#[derive(Serialize)]
struct TableCell {
    text: String,
    is_number: bool,
    is_code: bool,
    /// Of a column of verdicts: good or not.
    verdict: &'static str,
}

#[derive(Serialize)]
struct FigurePart<'a> {
    heading: &'a str,
    figures: Vec<PageFigure<'a>>,
}

#[derive(Serialize)]
struct PageFigure<'a> {
    title: &'a str,
    drawing: Value,
}

impl StudyPage<'_> {
    /// The page.
    pub(crate) fn html(&self, origin: &PageOrigin) -> String {
        let figure = |figure: &'_ StudyFigure| Value::from_safe_string(svg::write(&figure.drawing, &figure.title));
        let parts = self.figures.iter().map(|(heading, figures)| FigurePart {
            heading,
            figures: figures.iter().map(|one| PageFigure { title: &one.title, drawing: figure(one) }).collect(),
        });
        let context = StudyContext {
            title: self.title,
            introduction: self.introduction,
            tables: self.sheets.iter().filter(|sheet| !sheet.detail).map(table).collect(),
            parts: parts.collect(),
            origin,
        };
        shell::page("study.html", Scripts::Words, "null", &context)
    }
}

fn table(sheet: &StudySheet) -> PageTable<'_> {
    let cell = |(cell, key): (&Cell, &'static str)| {
        let (text, is_number) = match cell {
            Cell::Text(text) => (text.clone(), false),
            Cell::Number(value) => (number(Some(*value)), true),
            Cell::Count(count) => (count.to_string(), true),
            Cell::Nothing => ("-".to_owned(), true),
        };
        let verdict = match (key, text.as_str()) {
            ("status", "reproduced") => "good",
            ("status", _) => "other",
            _ => "",
        };
        TableCell { text, is_number, is_code: key == "command", verdict }
    };
    let row = |row: &Vec<Cell>| row.iter().zip(sheet.columns.iter().map(|c| c.key)).map(cell).collect();
    PageTable {
        heading: &sheet.heading,
        columns: sheet.columns.iter().map(|c| TableColumn { key: c.key, meaning: c.meaning }).collect(),
        rows: sheet.rows.iter().map(row).collect(),
    }
}
