//! Studies of prisms: what the verbs under `analyse` have in common, and one file a kind.

mod common;
pub(super) mod of_scene;
pub(super) mod design;
pub(super) mod relay;
pub(super) mod tolerance;
mod trial_file;
pub(super) mod paper;
pub(super) mod stereo;
