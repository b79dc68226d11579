//! What accuracy costs, as files: a table to read, JSON and CSV to work with, and charts.

pub mod csv;
pub mod table;

#[cfg(test)]
mod tests;
mod document;

pub use document::{CostReport, Machine, Name, Words, error_px, front};
