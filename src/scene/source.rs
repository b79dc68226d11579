//! Where the values of a scene come from, so that one statement of a rule serves files and code.

use crate::error::Error;

/// Where the values of a scene come from.
pub(super) trait ValueSource {
    /// The error that the value at `key` (`prism.front.terms[3]`) breaks `rule`. It points at the value, or at the nearest
    /// table around one that was left out.
    fn refuse(&self, key: &str, rule: String, help: &str) -> Error;
    /// Whether the value at `key`, or a table around it, was given.
    fn gives(&self, key: &str) -> bool;
}

/// A scene made in code, by its name.
pub(super) struct Code<'a>(pub(super) &'a str);

impl ValueSource for Code<'_> {
    fn refuse(&self, key: &str, rule: String, help: &str) -> Error {
        Error::new(format!("{}: {key}", self.0), rule, help).of_key(key)
    }

    fn gives(&self, _: &str) -> bool {
        true
    }
}
