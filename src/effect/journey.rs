//! Light paths: what transport effects may know of a ray.

use crate::optics::refraction::Refraction;
use glam::DVec3;

/// The way of one ray from the camera to the board, as light takes it backwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightPath<'a> {
    /// Cosine of the angle to the axis at which it meets the sensor.
    pub image_cos: f64,
    /// The surfaces that it crosses, from the camera on, in one frame.
    pub crossings: &'a [Refraction],
    /// Where it meets the plane of the board; `None` where it never does.
    pub landing: Option<BoardPoint>,
}

/// A place on the plane of the board, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardPoint {
    /// The place, in mm.
    pub point_mm: DVec3,
    /// The plane's unit normal, of either orientation.
    pub normal: DVec3,
}
