//! The instrument: camera, prism, board and effects with every constant computed beforehand, immutable once built.

pub mod aim;
pub mod in_light;
pub mod auto;
pub mod board;
mod bounds;
mod factor_bounds;
mod displacement_bounds;
mod ridge_image;
mod radiance_range;
mod output_gain;
pub mod camera;
pub mod clip;
mod throughput;
mod facets;
mod eight_rays;
pub mod tessellated;
pub mod solid;
pub mod crossing;
mod variants;
mod plate;
mod ghost_rays;
pub(crate) mod instrument;
mod build;
mod design_store;
mod margin;
mod doubts;
mod light;
mod shape_doubts;

pub use build::{
    build, build_before, build_from, facet_angle_rad, ideal, polynomials_of, revolved_with_room, with_room_for,
};
pub use design_store::DesignStore;
pub use doubts::doubts;
pub(crate) use eight_rays::EightWithin;
pub(crate) use facets::Way;
pub use instrument::{BoardHit, Footprint, System};
pub use light::require_light;

pub use crate::prism::biprism::Prism;
pub use crate::prism::side::Side;
pub use board::Board;
pub use camera::Camera;
pub use clip::Opening;
pub use in_light::InLight;
pub use radiance_range::Bound;
