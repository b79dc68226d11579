//! The tests of the library and of the command, in one program: one module a question.
//!
//! `cargo test --release --test suite laws::` runs one module. Two programs stand apart: `golden`, where each case of
//! the goldens is a test of its own name, and `faults`, which stops commands at moments of their run that it measures by
//! the clock, and so has to have the machine for itself.

#![allow(clippy::unwrap_used, reason = "a test, and its helpers, fail by a panic")]

mod command;
mod common;
mod instruments;

mod accounts;
mod architecture;
mod auto;
mod auto_law;
mod brought;
mod budget;
mod camera;
mod cli;
mod cutter;
mod documents;
mod edges;
mod exact_prism;
mod solid;
mod stereo;
mod optimised_prism;
mod effects;
mod effects_told;
mod export;
mod exr_page;
mod film;
mod hard_cases;
mod hostile;
mod in_light;
mod json_page;
mod laws;
mod lens;
mod level_law;
mod levels;
mod light;
mod made;
mod mesh;
mod objects;
mod oracle;
mod relay_oracle;
mod own_parts;
mod page;
mod paper;
mod photograph;
mod prism_law;
mod pictures;
mod rectify;
mod render;
mod scene_errors;
mod scene_schema;
mod textures;
mod tiff;
mod truth_table;
mod vision;
