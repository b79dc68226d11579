//! Values to an instrument: camera, prism and board with every constant computed beforehand, immutable once built.

pub mod aim;
pub mod auto;
pub mod board;
mod bounds;
pub mod camera;
pub mod clip;
mod throughput;
pub mod tessellated;
mod variants;
mod ghost_rays;
pub(crate) mod instrument;
mod build;
mod margin;
mod doubts;
mod light;
mod shape_doubts;

pub use build::{build, ideal};
pub use doubts::doubts;
pub use instrument::{BoardHit, Footprint, System};
pub use light::require_light;

pub use crate::prism::biprism::{Prism, Side};
pub use board::Board;
pub use bounds::Bound;
pub use camera::Camera;
pub use clip::Opening;
