//! The tables of the oracle, compiled in: comment lines, a line of column names, then rows.

/// Refraction at one plane.
pub(super) const REFRACTION: &str = include_str!("../../../tests/oracle/refraction.csv");
/// The paper's flat prism.
pub(super) const FLAT: &str = include_str!("../../../tests/oracle/flat.csv");
/// The polynomial prism of [`PRISM`].
pub(super) const FREEFORM: &str = include_str!("../../../tests/oracle/freeform.csv");
/// Flat prisms from vanishing to extreme.
pub(super) const PRISMS: &str = include_str!("../../../tests/oracle/prisms.csv");
/// Rays and wavy sheets.
pub(super) const CROSSINGS: &str = include_str!("../../../tests/oracle/crossings.csv");
/// The prism that `biprism design scenes/paper.toml` writes.
pub(super) const PRISM: &str = include_str!("../../../tests/oracle/prism.toml");

/// The rows of a table, each with its fields.
pub(super) fn rows(table: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    table.lines().filter(|line| !line.starts_with('#')).skip(1).map(|line| line.split(',').collect())
}

/// A field as a number: the nearest f64 to its 30 digits.
pub(super) fn number(field: &str) -> f64 {
    field.parse().expect("the committed tables hold numbers where numbers are due")
}
