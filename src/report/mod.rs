//! Results to files and figures.

pub mod budget;
pub mod cloud;
pub mod corners;
pub mod cost;
pub mod design;
pub mod figure;
pub mod golden;
pub mod json;
pub mod table;
