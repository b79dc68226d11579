//! Least squares for what no ordinary differential equation gives: pinholes, one depth, one rear surface for both halves, and
//! spots of a lens with an opening.
//!
//! The unknowns are both surfaces and the virtual camera's free numbers, the residuals what the rays miss their law by at both
//! ends of the depths, all derivatives exact.

mod anchored;
mod cloud;
mod figures;
mod merit;
mod nodes;
mod optimised;
mod passage;
mod refusals;
mod search;
mod start;
mod unknowns;

pub(super) use cloud::cloud;
pub(super) use figures::met_law;
pub use figures::{LawFigures, MetLaw, SpotFigures};
pub(super) use optimised::optimised;
pub(super) use refusals::fitted;

#[cfg(test)]
mod derivative_tests;
