//! The YAML of OpenCV's `FileStorage`: keys with numbers, strings, matrices, and maps of them.

use std::fmt::Write;

/// The first two lines of a file.
pub(crate) const HEAD: &str = "%YAML:1.0\n---\n";
/// How far a map is indented within another.
const INDENT: &str = "   ";

/// A map of keys, in the order in which they were given.
#[derive(Debug, Clone, Default)]
pub(crate) struct YamlMap {
    text: String,
}

impl YamlMap {
    /// Adds a word or a number.
    pub(crate) fn scalar(&mut self, key: &str, value: &str) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.text, "{key}: {value}");
    }

    /// Adds a string, which must hold neither quotes nor line breaks.
    pub(crate) fn string(&mut self, key: &str, value: &str) {
        self.scalar(key, &format!("\"{value}\""));
    }

    /// Adds a matrix of `[rows, columns]` elements of the type `dt` (`d`: doubles, `2i`: pairs of integers); `lines` of
    /// its values in their order, written one below the other.
    pub(crate) fn matrix(
        &mut self,
        key: &str,
        [rows, columns]: [usize; 2],
        dt: &str,
        lines: impl Iterator<Item = String>,
    ) {
        let _ = write!(
            self.text,
            "{key}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: \"{dt}\"\n   data: [ "
        );
        for (k, line) in lines.enumerate() {
            let _ = write!(self.text, "{}{line}", if k == 0 { "" } else { ",\n       " });
        }
        self.text.push_str(" ]\n");
    }

    /// Adds a matrix of doubles.
    pub(crate) fn doubles(&mut self, key: &str, rows: &[&[f64]]) {
        let columns = rows.first().map_or(0, |row| row.len());
        let line = |row: &&[f64]| row.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", ");
        self.matrix(key, [rows.len(), columns], "d", rows.iter().map(line));
    }

    /// Adds a map.
    pub(crate) fn map(&mut self, key: &str, map: &Self) {
        let _ = writeln!(self.text, "{key}:");
        map.text.lines().for_each(|line| {
            let _ = writeln!(self.text, "{INDENT}{line}");
        });
    }

    /// The file that holds the map.
    pub(crate) fn file(&self) -> String {
        format!("{HEAD}{}", self.text)
    }
}

/// A number as OpenCV reads it back: `{:?}` has a point or an exponent, and the fewest digits that round-trip.
pub(crate) fn number(v: f64) -> String {
    format!("{v:?}")
}
