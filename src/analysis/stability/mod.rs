//! The catalogue of hard cases: what is hard, a scene or a generator for it, and how far off the program is.
//!
//! The cases are data, so that the command prints what the tests assert. Errors are held against tables of an independent
//! program (`tests/oracle/make_tables.py`, 50 digits), closed forms, or laws that need no other program.

mod tally;
mod tables;
mod scenes;
mod optics;
mod freeform;
mod place;
mod sampling;
mod design;
mod case;

pub use case::{Case, ErrorUnit};

pub use tally::{CaseOutcome, Tally};

/// Every case, chapter by chapter.
pub fn catalogue() -> impl Iterator<Item = &'static Case> {
    [optics::CASES, freeform::CASES, place::CASES, sampling::CASES, design::CASES].into_iter().flatten()
}
