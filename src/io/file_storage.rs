//! The YAML of OpenCV's `FileStorage`: read as far as plain values and matrices go, the rest passed over; written as keys with
//! numbers, strings, matrices, and maps of them.

use crate::error::Error;
use std::collections::BTreeMap;
use std::fmt::Write;

/// How the first line begins: OpenCV writes `%YAML:1.0` up to version 4, `%YAML 1.2` from version 5 on.
const FIRST_WORD: &str = "%YAML";
/// Values and matrices of a file, at most.
const MOST_ENTRIES: usize = 1000;

/// What a file breaks, and in which line, where that is known.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) line: Option<usize>,
    pub(super) rule: String,
}

impl Fault {
    fn new(rule: String) -> Self {
        Self { line: None, rule }
    }

    fn at(self, line: usize) -> Self {
        Self { line: Some(line), ..self }
    }

    /// What the user is told of it, with `help`; `place` is the file.
    pub(super) fn told(self, place: &str, help: &str) -> Error {
        match self.line {
            Some(line) => Error::new(format_args!("{place}:{line}"), self.rule, help),
            None => Error::new(place, self.rule, help),
        }
    }
}

/// The top-level entries of a file: plain values by key, and matrices in the order of the file.
#[derive(Debug)]
pub(super) struct Entries<'a> {
    pub(super) scalars: BTreeMap<&'a str, &'a str>,
    pub(super) matrices: Vec<RawMatrix>,
}

/// A matrix as it is written.
#[derive(Debug)]
pub(super) struct RawMatrix {
    pub(super) key: String,
    /// The line of its key, from 1.
    line: usize,
    body: String,
}

/// What a matrix says of its size.
#[derive(Debug)]
pub(super) struct MatrixSize {
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Values of an element.
    depth: usize,
}

impl MatrixSize {
    /// Values of a row: an N x 1 matrix of pairs and an N x 2 one of singles hold the same.
    pub(super) fn channels(&self) -> usize {
        self.depth.saturating_mul(self.columns)
    }
}

impl<'a> Entries<'a> {
    /// Those of a text.
    pub(super) fn of(text: &'a str) -> Result<Self, Fault> {
        if !text.starts_with(FIRST_WORD) {
            let first = text.lines().next().unwrap_or("");
            let rule =
                format!("the first line is {first:?}, and must be \"%YAML:1.0\" or \"%YAML 1.2\" as OpenCV writes it");
            return Err(Fault::new(rule));
        }
        let (mut scalars, mut matrices) = (BTreeMap::new(), Vec::<RawMatrix>::new());
        let mut lines = text.lines().enumerate().skip(1).peekable();
        while let Some((number, line)) = lines.next() {
            let fault = |rule: String| Fault::new(rule).at(number + 1);
            if line == "---" || line == "..." || line.trim().is_empty() || line.starts_with('#') {
                continue;
            }
            let Some((key, value)) = line.split_once(':').filter(|_| !line.starts_with([' ', '-'])) else {
                return Err(fault(format!("the line is {line:?}, and must begin an entry, as `key: value`")));
            };
            if scalars.len() + matrices.len() > MOST_ENTRIES {
                return Err(fault(format!("the file has more than {MOST_ENTRIES} entries, the most that are taken")));
            }
            // The indented lines that follow belong to it.
            let mut body = String::new();
            while let Some((_, next)) = lines.next_if(|(_, next)| next.starts_with(' ')) {
                body.push_str(next);
                body.push('\n');
            }
            if value.trim() != "!!opencv-matrix" {
                // Lists and tables are of no interest here.
                if !value.trim().is_empty() {
                    scalars.insert(key, value.trim());
                }
                continue;
            }
            if matrices.iter().any(|matrix| matrix.key == key) {
                return Err(fault(format!("`{key}` is there twice, and must be there once")));
            }
            matrices.push(RawMatrix { key: key.to_owned(), line: number + 1, body });
        }
        Ok(Self { scalars, matrices })
    }
}

impl RawMatrix {
    /// What is wrong with it, at its line.
    pub(super) fn fault(&self, rule: String) -> Fault {
        Fault::new(rule).at(self.line)
    }

    fn field(&self, name: &str) -> Result<&str, Fault> {
        let value = self.body.lines().find_map(|line| line.trim_start().strip_prefix(name)?.strip_prefix(':'));
        let missing = || self.fault(format!("`{}` has no `{name}`, and must have rows, cols, dt and data", self.key));
        value.map(|v| v.trim().trim_matches('"')).ok_or_else(missing)
    }

    /// How large it says that it is.
    pub(super) fn size(&self) -> Result<MatrixSize, Fault> {
        let key = &self.key;
        let count = |name: &str| -> Result<usize, Fault> {
            let value = self.field(name)?;
            let rule = || self.fault(format!("`{name}` of `{key}` is {value:?}, and must be a whole number from 0 on"));
            value.parse().map_err(|_| rule())
        };
        let (rows, columns) = (count("rows")?, count("cols")?);
        let kind = self.field("dt")?;
        let (digits, letter) = kind.split_at(kind.char_indices().next_back().map_or(0, |(at, _)| at));
        let depth: Option<usize> = if digits.is_empty() { Some(1) } else { digits.parse().ok() };
        let Some(depth) = depth.filter(|d| (1..=64).contains(d) && ["d", "f", "i"].contains(&letter)) else {
            let rule = format!("`dt` of `{key}` is {kind:?}, and must be like \"2d\", \"2f\" or \"2i\"");
            return Err(self.fault(rule));
        };
        Ok(MatrixSize { rows, columns, depth })
    }

    /// Its values, row by row, once its size is known to be one that is taken.
    pub(super) fn values(&self, size: &MatrixSize) -> Result<Vec<f64>, Fault> {
        let key = &self.key;
        let data = self.body.split_once("data:").and_then(|(_, d)| d.trim().strip_prefix('[')?.strip_suffix(']'));
        let data = data.ok_or_else(|| self.fault(format!("`data` of `{key}` must be a list in brackets")))?;
        let parse = |v: &str| {
            // OpenCV writes 1. for 1.
            let v = v.trim();
            v.parse::<f64>().map_err(|_| self.fault(format!("`data` of `{key}` holds {v:?}, and must hold numbers")))
        };
        let numbers = || data.split(',').filter(|v| !v.trim().is_empty());
        let (found, channels) = (numbers().count(), size.channels());
        if Some(found) != size.rows.checked_mul(channels) {
            let rule = format!("`{key}` holds {found} numbers, and must hold {} rows of {channels}", size.rows);
            return Err(self.fault(rule));
        }
        numbers().map(parse).collect()
    }
}

/// The first two lines of a file.
const HEAD: &str = "%YAML:1.0\n---\n";
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
