//! Figures: results as pictures that a paper could print.
//!
//! Each figure is a pure function from plain data to a [`drawing::Drawing`], a list of shapes; [`canvas::raster`] turns
//! it into pixels and [`svg::write`] into SVG text. The same data give the same bytes on every run.
//!
//! ```text
//! BudgetInput ------budget::draw--------->
//! ComparisonInput --comparison::draw-----> Drawing --canvas::raster--> Raster<[u8; 3]>
//! ChartInput -------chart::draw--------->          --svg::write------> SVG text
//! QuiverInput ------field::draw_quiver-->
//! HeatMapInput -----field::draw_heat_map>
//! ```
//!
//! Values that are not numbers are left out and counted in the figure; text that has no room is shortened; data that are
//! empty give an empty figure with its labels.

pub mod colour;
pub mod text;
mod glyphs;
pub mod drawing;
pub mod canvas;
pub mod svg;
pub mod picture;
pub mod axis;
pub mod colour_bar;
mod frame;
pub mod chart;
pub mod field;
pub mod plan;
pub mod tornado;
#[cfg(test)]
pub(crate) mod examine;
