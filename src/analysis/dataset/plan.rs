//! What the pictures of a set show.

use crate::scene::Scene;
use glam::DVec3;

/// A range from which numbers are drawn, all of it alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawRange {
    /// Its lower end.
    pub low: f64,
    /// Its upper end, which may be the lower one.
    pub high: f64,
}

impl DrawRange {
    /// The number at `share` of it, from 0 to 1.
    pub(super) fn at(&self, share: f64) -> f64 {
        (self.low + (self.high - self.low) * share).clamp(self.low, self.high)
    }
}

/// How much of the board both halves must see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InView {
    /// Its middle; the rest may be cut.
    Centre,
    /// All of its squares.
    Whole,
}

impl InView {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Centre => "centre",
            Self::Whole => "whole",
        }
    }
}

/// Where boards are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceRanges {
    /// Distance of the board's middle from the camera along +z, in mm.
    pub distance_mm: DrawRange,
    /// Angle between the board's normal and +z, in deg; its direction is drawn from the whole circle.
    pub tilt_deg: DrawRange,
    /// Turn of the board about its own normal, before it is tilted, in deg.
    pub roll_deg: DrawRange,
    /// How much of it both halves must see. The middle is drawn evenly over the picture, as far as both halves see it.
    pub in_view: InView,
}

/// A place of the board as a scene states it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedPlace {
    /// Position of the middle of the squares, in mm.
    pub position_mm: DVec3,
    /// Tilt about the fixed x, then y, then z axis, in deg.
    pub tilt_deg: DVec3,
}

/// Where the boards of a set are.
#[derive(Debug, Clone, PartialEq)]
pub enum BoardPlaces {
    /// Drawn at random.
    Drawn(PlaceRanges),
    /// As listed, one a picture.
    Listed(Vec<StatedPlace>),
}

impl BoardPlaces {
    /// Nearest and farthest distance of the board's middle from the camera of `scene` along +z, in mm.
    pub fn distances_mm(&self, scene: &Scene) -> [f64; 2] {
        match self {
            Self::Drawn(ranges) => [ranges.distance_mm.low, ranges.distance_mm.high],
            Self::Listed(places) => {
                let all = places.iter().map(|place| place.position_mm.z - scene.camera.position_mm.z);
                all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], mm| [low.min(mm), high.max(mm)])
            }
        }
    }
}

/// What a board shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoardLook {
    /// Its squares.
    Squares,
    /// Noise: that of the scene where it has one, else one named by the seed of the set.
    Noise,
    /// A chart.
    Chart,
}

impl BoardLook {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Squares => "squares",
            Self::Noise => "noise",
            Self::Chart => "chart",
        }
    }
}

/// What is drawn for a set.
#[derive(Debug, Clone, PartialEq)]
pub struct DatasetPlan {
    /// Of the random numbers.
    pub seed: u64,
    /// Where the boards are.
    pub places: BoardPlaces,
    /// What they show, one of these a picture; what the scene says where there is none.
    pub looks: Vec<BoardLook>,
    /// Standard deviation of the noise of a read-out, of full scale 1; that of the scene where there is none.
    pub noise: Option<DrawRange>,
    /// Factor on the light of the board and its background; 1 where there is none.
    pub exposure: Option<DrawRange>,
}
