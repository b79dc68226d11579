//! Results to files and figures.

pub mod board_pose;
pub mod batch;
pub mod budget;
pub mod comparison;
pub mod expectations;
pub mod identity;
pub mod picture;
pub mod cost;
pub mod cutter;
pub mod design;
pub mod fit;
pub mod figures;
pub mod json;
pub mod number;
pub mod sheet;
pub mod study;
pub mod table;
pub mod cameras;
pub mod export;
pub mod rectify;
pub mod dataset;
pub mod corner_table;
pub mod metric_meaning;
pub mod page;
pub mod traced;
mod truth;
mod stereo_file;
