//! Figures of results: what a paper could print.

pub mod comparison;
pub mod budget;
#[cfg(test)]
pub(crate) mod samples;
pub mod cost;
pub mod cutter;
pub mod surface_map;
