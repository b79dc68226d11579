//! Results as one page to look into: a file of HTML with its pictures, figures, style and scripts in it, which needs no network
//! and no other file.

pub mod comparison;
pub mod origin;
pub mod study;
pub mod cost;
mod corner_rows;
mod figure_table;
mod picture_data;
mod shell;
