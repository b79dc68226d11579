//! The tables `[effect.*]` of a scene: as written, and as checked values.

mod sensor;
pub(super) mod light;
pub(super) mod lens;
mod as_built;
pub(super) mod tables;
pub(super) mod rules;
mod ranges;
