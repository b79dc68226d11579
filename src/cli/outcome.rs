//! How a verb ended.

/// How a verb that could run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// All is as it should be.
    Done,
    /// It ran, and something that was expected is not so.
    Unmet,
}

impl Outcome {
    /// Both as they should be, or not.
    pub(super) fn and(self, other: Self) -> Self {
        if self == Self::Done { other } else { self }
    }
}
