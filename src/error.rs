//! Errors as a user reads them: the place, the value, the rule and the next step.
//!
//! A leaf: it knows no file system and no terminal. Every front end prints a [`Error`] the same way.

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use std::borrow::Cow;
use std::fmt;
use std::ops::Range;

/// Characters of a sentence that are shown, at most: a value in it may be a whole file.
const LONGEST_SENTENCE: usize = 1000;
/// Bytes of the line at fault that are shown, at most: beyond it the place alone is told.
const LONGEST_LINE: usize = 1 << 16;

/// What a line shows in the place of a control character of two bytes: of as many bytes, so that what is underlined stays.
const SHOWN_CONTROL: &str = "\u{b7}";

/// A user's mistake or a failure of the outside world: one error, complete enough to mend it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// Where: a file, `file:line`, or an argument.
    pub place: String,
    /// The key of a scene that is at fault (`board.square_mm`), where it is one.
    pub key: Option<String>,
    /// What was found and which rule it breaks, in one sentence: "`board.square_mm` is -1, and must be above 0".
    pub rule: String,
    /// What to do next, in one sentence.
    pub help: String,
    /// The lines of the file at fault, and the bytes in them that are, where there are such.
    pub source: Option<Box<(String, Range<usize>)>>,
    /// The number in the file of the first of these lines, from 1; 0 of a problem that points into no text.
    pub first_line: usize,
}

impl Error {
    /// A problem at `place` (a file or an argument) that has no text to point into.
    pub fn new(place: impl fmt::Display, rule: impl Into<String>, help: impl Into<String>) -> Self {
        let (place, rule, help) = (place.to_string(), rule.into(), help.into());
        Self { place, key: None, rule, help, source: None, first_line: 0 }
    }

    /// The same problem, of the `key` of a scene.
    #[must_use]
    pub fn of_key(self, key: impl Into<String>) -> Self {
        Self { key: Some(key.into()), ..self }
    }

    /// The line at fault in the file, from 1, where there is one.
    pub fn line(&self) -> Option<usize> {
        Some(self.first_line).filter(|line| *line > 0)
    }

    /// The character of that line at which the fault begins, from 1, where the line is kept.
    pub fn column(&self) -> Option<usize> {
        let (text, span) = self.source.as_deref()?;
        text.get(..span.start).map(|before| before.chars().count() + 1)
    }

    /// The same problem, pointing at the bytes `span` of the file's whole text.
    #[must_use]
    pub fn at(mut self, text: &str, span: Range<usize>) -> Self {
        let end = span.end.min(text.len());
        let start = span.start.min(end);
        let first = text[..start].rfind('\n').map_or(0, |k| k + 1);
        let last = text[end..].find('\n').map_or(text.len(), |k| end + k);
        self.first_line = 1 + text.as_bytes()[..first].iter().filter(|&&b| b == b'\n').count();
        if last - first > LONGEST_LINE {
            self.place = format!("{}:{}", self.place, self.first_line);
        } else {
            self.source = Some(Box::new((text[first..last].to_owned(), start - first..end - first)));
        }
        self
    }

    /// The problem as a compiler would print it, with the offending line where there is one. No character of it moves the
    /// cursor or colours a terminal, whatever files are called and whatever is in them: see [`printable`].
    pub fn render(&self, colour: bool) -> String {
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        let sentence = |text: &str| printable(&shortened(text)).replace('\n', "\\n");
        let (place, rule, help) = (sentence(&self.place), sentence(&self.rule), sentence(&self.help));
        let help = Level::HELP.message(&help);
        let group = match self.source.as_deref() {
            Some((text, span)) => Level::ERROR.primary_title(&rule).element(
                Snippet::source(text.replace(is_second_control, SHOWN_CONTROL))
                    .line_start(self.first_line)
                    .path(&place)
                    .annotation(AnnotationKind::Primary.span(span.clone())),
            ),
            None => Level::ERROR.primary_title(&rule).element(Level::NOTE.message(format!("in {place}"))),
        };
        renderer.render(&[group.element(help)])
    }
}

/// Whether a character is one of the second set of control characters, which the drawing of a line would let through.
fn is_second_control(c: char) -> bool {
    matches!(c, '\u{80}'..='\u{9f}')
}

/// The text with every character written out that a terminal would obey instead of showing it: control characters but for
/// line breaks and tabs, and those that turn the direction of writing.
pub fn printable(text: &str) -> Cow<'_, str> {
    let obeyed = |c: char| {
        (c.is_control() && c != '\n' && c != '\t') || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(obeyed) {
        return Cow::Borrowed(text);
    }
    let shown = |c: char| if obeyed(c) { c.escape_default().to_string() } else { c.to_string() };
    Cow::Owned(text.chars().map(shown).collect())
}

/// A sentence without its middle, where that is long.
fn shortened(text: &str) -> Cow<'_, str> {
    let length = text.chars().count();
    if length <= LONGEST_SENTENCE {
        return Cow::Borrowed(text);
    }
    let kept = LONGEST_SENTENCE / 2;
    let (first, last) = (text.chars().take(kept), text.chars().skip(length - kept));
    Cow::Owned(first.chain(" ... ".chars()).chain(last).collect())
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_a_terminal_obeys_is_printed() {
        let hostile = "a\u{1b}[31m\r\u{9b}1m\u{7}\u{202e}b\u{7f}\nc";
        for problem in [
            Error::new(hostile, hostile, hostile),
            Error::new(hostile, hostile, hostile).at(&format!("one\n{hostile}\nthree"), 5..6),
        ] {
            let told = problem.render(false);
            let obeyed = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
            assert!(!told.contains(obeyed), "{told:?}");
            assert!(told.contains("\\u{1b}[31m") && told.contains("\\nc"), "{told}");
        }
        assert_eq!(printable("plain \u{e9}\n\t"), "plain \u{e9}\n\t");
    }

    /// The line is told once, with its number in the whole file, and of a long line only the place.
    #[test]
    fn a_place_has_one_line_and_one_column() {
        let text = "first\nsecond\nthird = x\nfourth\n";
        let told = Error::new("a.toml", "it is so", "do that").at(text, 21..22).render(false);
        assert!(told.contains("a.toml:3:9\n") && told.contains("3 | third = x"), "{told}");
        let problem = Error::new("a.toml", "it is so", "do that").at("one\n\u{e9}\u{e9} = x", 9..10).of_key("b.c");
        assert_eq!((problem.line(), problem.column(), problem.key.as_deref()), (Some(2), Some(4), Some("b.c")));
        assert_eq!((Error::new("a", "b", "c").line(), Error::new("a", "b", "c").column()), (None, None));
        let long = format!("first\n{}", "x".repeat(LONGEST_LINE + 1));
        let problem = Error::new("a.csv", format!("it is {long:?}"), "do that").at(&long, 10..11);
        assert!(problem.place == "a.csv:2" && problem.render(false).len() < 2000);
    }
}
