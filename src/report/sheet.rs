//! A sheet: the figures of a study as rows and columns, from which its table, its CSV and its JSON are made.

use super::number::number;
use serde_json::{Map, Value, json};

/// A column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Name, with the unit in it: `rms_um`. The key in CSV and JSON.
    pub key: &'static str,
    /// What it is: the definition, for who reads the JSON.
    pub meaning: &'static str,
}

/// A field.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number.
    Number(f64),
    /// A count.
    Count(usize),
    /// What there is not.
    Nothing,
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        if value.is_finite() { Self::Number(value) } else { Self::Nothing }
    }
}

impl From<Option<f64>> for Cell {
    fn from(value: Option<f64>) -> Self {
        value.map_or(Self::Nothing, Self::from)
    }
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        Self::Count(value)
    }
}

impl From<&str> for Cell {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<String> for Cell {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

/// Figures as rows and columns.
#[derive(Debug, Clone, PartialEq)]
pub struct StudySheet {
    /// Name: the key in the JSON, and the file's name where it is one.
    pub name: &'static str,
    /// What it shows, in a few words: the heading of the table.
    pub heading: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows, each with a field per column.
    pub rows: Vec<Vec<Cell>>,
    /// Whether it is for programs alone: too long for a table that a person reads.
    pub detail: bool,
}

impl StudySheet {
    /// A sheet without rows.
    pub fn new(name: &'static str, heading: impl Into<String>, columns: &[(&'static str, &'static str)]) -> Self {
        let columns = columns.iter().map(|&(key, meaning)| Column { key, meaning }).collect();
        Self { name, heading: heading.into(), columns, rows: Vec::new(), detail: false }
    }

    /// The same for programs alone.
    #[must_use]
    pub(crate) fn detailed(self) -> Self {
        Self { detail: true, ..self }
    }

    /// Adds a row.
    pub fn push(&mut self, row: Vec<Cell>) {
        debug_assert_eq!(row.len(), self.columns.len(), "{}", self.name);
        self.rows.push(row);
    }

    /// As a table for a person: the heading, and the columns under their names.
    pub fn table(&self) -> String {
        let shown = |cell: &Cell| match cell {
            Cell::Text(text) => text.clone(),
            Cell::Number(value) => number(Some(*value)),
            Cell::Count(count) => count.to_string(),
            Cell::Nothing => "-".to_owned(),
        };
        let mut lines = vec![self.columns.iter().map(|column| column.key.to_owned()).collect::<Vec<_>>()];
        lines.extend(self.rows.iter().map(|row| row.iter().map(shown).collect()));
        let width = |k: usize| lines.iter().map(|line| line[k].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let words = |k: usize| self.rows.iter().any(|row| matches!(row[k], Cell::Text(_)));
        let mut text = format!("{}\n", self.heading);
        for line in &lines {
            let aligned = line.iter().enumerate().map(|(k, field)| {
                let width = widths[k];
                if words(k) { format!("{field:width$}") } else { format!("{field:>width$}") }
            });
            text += aligned.collect::<Vec<_>>().join("  ").trim_end();
            text.push('\n');
        }
        text
    }

    /// As comma-separated values: the keys, and a line a row. Every number reads back as the same f64.
    pub fn csv(&self) -> String {
        let field = |cell: &Cell| match cell {
            Cell::Text(text) if text.contains([',', '"', '\n']) => format!("\"{}\"", text.replace('"', "\"\"")),
            Cell::Text(text) => text.clone(),
            Cell::Number(value) => value.to_string(),
            Cell::Count(count) => count.to_string(),
            Cell::Nothing => String::new(),
        };
        let keys = self.columns.iter().map(|column| column.key).collect::<Vec<_>>().join(",");
        let lines = self.rows.iter().map(|row| row.iter().map(field).collect::<Vec<_>>().join(","));
        std::iter::once(keys).chain(lines).collect::<Vec<_>>().join("\n") + "\n"
    }

    /// As JSON: the rows by their keys, and what the keys mean.
    pub fn json(&self) -> Value {
        let value = |cell: &Cell| match cell {
            Cell::Text(text) => json!(text),
            Cell::Number(value) => json!(value),
            Cell::Count(count) => json!(count),
            Cell::Nothing => Value::Null,
        };
        let entry = |row: &Vec<Cell>| -> Map<String, Value> {
            self.columns.iter().zip(row).map(|(column, cell)| (column.key.to_owned(), value(cell))).collect()
        };
        let meanings: Map<String, Value> =
            self.columns.iter().map(|column| (column.key.to_owned(), json!(column.meaning))).collect();
        json!({ "heading": self.heading, "columns": meanings, "rows": self.rows.iter().map(entry).collect::<Vec<_>>() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet() -> StudySheet {
        let mut sheet =
            StudySheet::new("s", "Heading", &[("prism", "whose"), ("rms_um", "how much"), ("n", "how many")]);
        sheet.push(vec!["flat, \"old\"".into(), 59.137_860_47.into(), 1024.into()]);
        sheet.push(vec!["b".into(), Some(f64::NAN).into(), 7.into()]);
        sheet
    }

    #[test]
    fn a_table_has_its_columns_under_each_other() {
        let wanted = "Heading\nprism        rms_um     n\nflat, \"old\"  59.138  1024\nb                 -     7\n";
        assert_eq!(sheet().table(), wanted);
    }

    #[test]
    fn csv_and_json_keep_every_bit() {
        assert_eq!(sheet().csv(), "prism,rms_um,n\n\"flat, \"\"old\"\"\",59.13786047,1024\nb,,7\n");
        let json = sheet().json();
        assert_eq!(json["rows"][0]["rms_um"].as_f64(), Some(59.137_860_47));
        assert!(json["rows"][1]["rms_um"].is_null() && json["columns"]["rms_um"] == "how much");
    }
}
