//! The lens of the camera.

use super::pupil::Pupil;
use super::telecentric::Telecentric;
use super::thin_lens::{Aperture, ThinLens};

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

    /// The pupil, where it is more than a point: in mm of a thin lens, in sines of a telecentric one.
    pub fn pupil(&self) -> Option<Pupil> {
        let pupil = match self {
            Self::Pinhole => return None,
            Self::Thin(lens) => Pupil { radius: lens.radius_mm, aperture: lens.aperture },
            Self::Telecentric(lens) => Pupil { radius: lens.na, aperture: Aperture::Circle },
        };
        self.has_pupil().then_some(pupil)
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
