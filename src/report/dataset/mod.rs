//! A set of pictures, told: its manifest, its cameras, and what came of a run.

mod cameras;
mod manifest;
mod summary;

pub use cameras::cameras_text;
pub use manifest::{LookCounts, MANIFEST_SCHEMA, ManifestHead, PoseLine, SetFiles, line};
pub use summary::{SetSummary, SetTally};
