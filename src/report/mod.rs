//! Results to files and figures.

pub mod budget;
pub mod cost;
pub mod design;
pub mod fit;
pub mod figures;
pub mod json;
pub mod table;
