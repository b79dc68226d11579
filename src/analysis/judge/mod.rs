//! The judgement of one prism: how far a stereo pair taken through it is from two ideal pinhole cameras.

mod rays;
mod pinhole;
mod centre;
mod stereo;
mod cameras;
mod judgement;
mod numbers;

pub use cameras::CameraFigures;
pub use centre::CentreFigures;
pub use judgement::{Judgement, judge, measure, other_depths};
pub use pinhole::{CENTRE_ONLY, DepthFigures, PinholeFigures, free_at};
pub use rays::grid_sightings;
pub use stereo::StereoFigures;
