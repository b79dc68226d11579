//! The lens of the camera.

use super::telecentric::Telecentric;
use super::thin_lens::ThinLens;

/// The lens of the camera: none but a pinhole, or one of two kinds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Lens {
    /// A pinhole: all is sharp.
    #[default]
    Pinhole,
    /// A lens of finite aperture in focus at one distance.
    Thin(ThinLens),
    /// A telecentric lens in place of the pinhole.
    Telecentric(Telecentric),
}

impl Lens {
    /// The thin lens, if it is one.
    pub fn thin(&self) -> Option<&ThinLens> {
        match self {
            Self::Thin(lens) => Some(lens),
            _ => None,
        }
    }

    /// The telecentric lens, if it is one.
    pub fn telecentric(&self) -> Option<&Telecentric> {
        match self {
            Self::Telecentric(lens) => Some(lens),
            _ => None,
        }
    }

    /// Whether the pupil is more than a point.
    pub fn has_pupil(&self) -> bool {
        match self {
            Self::Pinhole => false,
            Self::Thin(lens) => !lens.is_nothing(),
            Self::Telecentric(lens) => lens.na > 0.0,
        }
    }
}
