//! The text of a scene file with its parse tree, so that every message can point at the bytes it speaks of.

use super::given_text::GivenText;
use super::limits::FILE_BYTES;
use super::source::ValueSource;
use crate::error::Error;
use crate::io::inputs;

use serde::de::DeserializeOwned;
use std::io::Read;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A TOML text that parsed.
pub(super) struct Document<'t> {
    /// The whole text, without a byte order mark.
    pub(super) text: &'t str,
    /// The root table; every key and value with its span.
    pub(super) root: Spanned<DeTable<'t>>,
    place: &'t str,
    /// Values that were given besides the text, in the order of their spans, which begin behind it.
    given: &'t [GivenText],
}

impl<'t> Document<'t> {
    /// Parse `text`, which `place` names in messages.
    pub(super) fn parse(text: &'t str, place: &'t str) -> Result<Self, Error> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        if text.trim().is_empty() {
            let help = "start from scenes/paper.toml, or give another file";
            return Err(Error::new(place, "the scene is empty", help));
        }
        match DeTable::parse(text) {
            Ok(root) => Ok(Self { text, root, place, given: &[] }),
            Err(error) => Err(not_toml(text, place, &error)),
        }
    }

    /// A document without a line, for values that come by themselves.
    pub(super) fn blank(place: &'t str) -> Self {
        Self { text: "", root: Spanned::new(0..0, DeTable::new()), place, given: &[] }
    }

    /// The same with the values of `given` in place of its own, one after the other.
    pub(super) fn with(mut self, given: &'t [GivenText]) -> Result<Self, Error> {
        self.given = given;
        given.iter().try_for_each(|value| value.put_into(self.root.get_mut()))?;
        Ok(self)
    }

    /// Its values as a text of their own; comments and the order of keys are not kept.
    pub(super) fn to_text(&self) -> Result<String, Error> {
        let told = |why: String| Error::new(self.place, format!("the scene has no text: {why}"), "correct the scene");
        let table = self.values::<toml::Table>()?;
        toml::to_string(&table).map_err(|error| told(error.to_string()))
    }

    /// The values of type `T`, once [`super::structure`] has found them right.
    pub(super) fn values<T: DeserializeOwned>(&self) -> Result<T, Error> {
        T::deserialize(toml::Deserializer::from(self.root.clone())).map_err(|error| {
            let rule = format!("the scene cannot be read: {}", error.message());
            self.problem(error.span().unwrap_or(0..0), rule, "mend the marked place")
        })
    }

    /// A problem with the bytes `span`.
    pub(super) fn problem(&self, span: Range<usize>, rule: String, help: impl Into<String>) -> Error {
        match self.given_at(&span) {
            Some(given) => Error::new(&given.place, rule, help),
            None if self.text.is_empty() => Error::new(self.place, rule, help),
            None => Error::new(self.place, rule, help).at(self.text, span),
        }
    }

    /// A problem with the value at `key`, or the nearest table around one that was left out.
    pub(super) fn fault(&self, key: &str, rule: String, help: impl Into<String>) -> Error {
        self.problem(self.span(key), rule, help).of_key(key)
    }

    /// What was given besides the text and has its span there.
    fn given_at(&self, span: &Range<usize>) -> Option<&GivenText> {
        self.given.iter().find(|given| given.span().contains(&span.start))
    }

    /// Where the value at `path` stands (`prism.front.terms[3]`), or the nearest table around it when it was left out.
    pub(super) fn span(&self, path: &str) -> Range<usize> {
        let mut span = 0..0;
        let mut table = self.root.get_ref();
        for step in path.split('.') {
            let (key, indices) = step.split_once('[').unwrap_or((step, ""));
            let Some(mut value) = table.get(key) else { break };
            for index in indices.split(['[', ']']).filter_map(|digits| digits.parse::<usize>().ok()) {
                let Some(item) = value.get_ref().get(index) else { break };
                value = item;
            }
            span = value.span();
            match value.get_ref() {
                DeValue::Table(inner) => table = inner,
                _ => break,
            }
        }
        span
    }

    /// Whether the file has the key `key` in the table at `table`.
    pub(super) fn has(&self, table: &str, key: &str) -> bool {
        let root = Some(self.root.get_ref());
        let inner = table.split('.').fold(root, |table, step| match table?.get(step)?.get_ref() {
            DeValue::Table(inner) => Some(inner),
            _ => None,
        });
        inner.is_some_and(|table| table.get(key).is_some())
    }

    /// What the file says at `span`, short enough for a sentence.
    pub(super) fn shown(&self, span: Range<usize>) -> String {
        const LONGEST: usize = 40;
        let words = match self.given_at(&span) {
            Some(given) => given.words(span),
            None => self.text.get(span).unwrap_or_default(),
        };
        let first = words.lines().next().unwrap_or_default();
        if first.chars().count() > LONGEST || first.len() < words.len() {
            first.chars().take(LONGEST).chain("...".chars()).collect()
        } else {
            first.to_owned()
        }
    }
}

impl ValueSource for Document<'_> {
    fn refuse(&self, key: &str, rule: String, help: &str) -> Error {
        self.fault(key, rule, help)
    }

    fn gives(&self, key: &str) -> bool {
        !self.span(key).is_empty()
    }
}

/// The text of the file at `path`, of at most [`FILE_BYTES`].
pub(super) fn read(path: &Path) -> Result<String, Error> {
    let place = path.display().to_string();
    let refused = |error: std::io::Error| {
        Error::new(&place, format!("`{place}` cannot be read: {error}"), "give the path of a scene file")
    };
    if path.is_dir() {
        let help = "give the path of a scene file in it";
        return Err(Error::new(&place, format!("`{place}` is a directory, and a scene is a file"), help));
    }
    let file = inputs::open(path).map_err(refused)?;
    let told = file.metadata().map_err(refused)?.len();
    if told > FILE_BYTES {
        return Err(too_long(&place, told));
    }
    text_of(file, &place)
}

fn too_long(place: &str, bytes: u64) -> Error {
    let rule = format!("`{place}` has {bytes} bytes or more, and a scene has at most {FILE_BYTES}");
    Error::new(place, rule, "give a scene file; points of a surface go into a file of their own")
}

/// The text of an input, called `place`, of at most [`FILE_BYTES`]. A pipe tells no length, so the reading itself is bounded.
pub(super) fn text_of(input: impl Read, place: &str) -> Result<String, Error> {
    let refused =
        |error: std::io::Error| Error::new(place, format!("`{place}` cannot be read: {error}"), "give a scene file");
    let mut bytes = Vec::new();
    input.take(FILE_BYTES + 1).read_to_end(&mut bytes).map_err(refused)?;
    if bytes.len() as u64 > FILE_BYTES {
        return Err(too_long(place, bytes.len() as u64));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let byte = error.as_bytes()[at];
        let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
        let rule = format!("`{place}` is not UTF-8 text: byte {at} is 0x{byte:02x}");
        Error::new(place, rule, "save the file as UTF-8").at(&text, at..at + char::REPLACEMENT_CHARACTER.len_utf8())
    })
}

fn not_toml(text: &str, place: &str, error: &toml::de::Error) -> Error {
    let span = error.span().unwrap_or(0..0);
    let word = text.get(span.clone()).unwrap_or_default().trim();
    let (rule, help) = if error.message() == "duplicate key" {
        (format!("`{word}` is given twice in one table"), "keep one of the two")
    } else if span.start >= text.trim_end().len() {
        (format!("the scene ends too early: {}", error.message()), "complete its last line: the file may be cut short")
    } else {
        (
            format!("the scene is not TOML: {}", error.message()),
            "mend the marked place; scenes/paper.toml shows the form",
        )
    };
    Error::new(place, rule, help).at(text, span)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a = 1\n[t]\nb = [[1, 2], [3, 44]]\nc.d = \"x\"\n[[list]]\n[[list]]\ne = 5\n";

    #[test]
    fn span_of_a_path_is_its_value_or_the_nearest_table() {
        let document = Document::parse(TEXT, "test").unwrap();
        let words = [
            ("a", "1"),
            ("t", "[t]"),
            ("t.b", "[[1, 2], [3, 44]]"),
            ("t.b[1][1]", "44"),
            ("t.b[7]", "[[1, 2], [3, 44]]"),
            ("t.c.d", "\"x\""),
            ("t.missing.too", "[t]"),
            ("list[1].e", "5"),
            ("list[0].e", "[[list]]"),
            ("missing", ""),
        ];
        for (path, wanted) in words {
            assert_eq!(&TEXT[document.span(path)], wanted, "{path}");
        }
    }

    #[test]
    fn keys_that_are_there_are_known() {
        let document = Document::parse(TEXT, "test").unwrap();
        assert!(document.has("t", "b") && document.has("t.c", "d") && document.has("t", "c"));
        assert!(!document.has("t", "d") && !document.has("t.b", "d") && !document.has("missing", "b"));
    }

    #[test]
    fn long_or_many_lined_values_are_shown_short() {
        let text = format!("a = \"{}\"\nb = [\n1]\nc = \"\u{e9}\"", "\u{e9}".repeat(100));
        let document = Document::parse(&text, "test").unwrap();
        let shown = |path| document.shown(document.span(path));
        assert_eq!(shown("a"), format!("\"{}...", "\u{e9}".repeat(39)));
        assert_eq!(shown("b"), "[...");
        assert_eq!(shown("c"), "\"\u{e9}\"");
    }
}
