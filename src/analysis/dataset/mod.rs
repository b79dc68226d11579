//! Sets of pictures of one instrument: its board at many places, drawn at random or listed, with what is true of each. The prism is
//! designed once.

mod cameras;
mod draw;
mod plan;
mod set;

pub use cameras::{CameraResidual, SetCameras};
pub use plan::{BoardLook, BoardPlaces, DatasetPlan, DrawRange, InView, PlaceRanges, StatedPlace};
pub use set::{Dataset, DatasetPose};
