//! Errors as a user reads them: the place, the value, the rule and the next step.
//!
//! A leaf: it knows no file system and no terminal. Every front end prints a [`Error`] the same way.

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use std::fmt;
use std::ops::Range;

/// A user's mistake or a failure of the outside world: one error, complete enough to mend it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// Where: a file, `file:line`, or an argument.
    pub place: String,
    /// What was found and which rule it breaks, in one sentence: "`board.square_mm` is -1, and must be above 0".
    pub rule: String,
    /// What to do next, in one sentence.
    pub help: String,
    /// The whole text of the file and the bytes in it that are at fault, where there are such.
    pub source: Option<(String, Range<usize>)>,
}

impl Error {
    /// A problem at `place` (a file or an argument) that has no text to point into.
    pub fn new(place: impl fmt::Display, rule: impl Into<String>, help: impl Into<String>) -> Self {
        Self { place: place.to_string(), rule: rule.into(), help: help.into(), source: None }
    }

    /// The same problem, pointing at the bytes `span` of the file's whole text.
    #[must_use]
    pub fn at(mut self, text: &str, span: Range<usize>) -> Self {
        let end = span.end.min(text.len());
        self.source = Some((text.to_owned(), span.start.min(end)..end));
        self
    }

    /// The problem as a compiler would print it, with the offending line where there is one.
    pub fn render(&self, colour: bool) -> String {
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        let help = Level::HELP.message(&self.help);
        let group = match &self.source {
            Some((text, span)) => Level::ERROR.primary_title(&self.rule).element(
                Snippet::source(text).path(&self.place).annotation(AnnotationKind::Primary.span(span.clone())),
            ),
            None => Level::ERROR.primary_title(&self.rule).element(Level::NOTE.message(format!("in {}", self.place))),
        };
        renderer.render(&[group.element(help)])
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Error {}
