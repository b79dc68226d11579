//! The channels of an EXR file.

use crate::raster::Raster;

/// The first bytes of every EXR file.
pub(in crate::io) const SIGNATURE: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// A named plane of an EXR file.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// ASCII name, at most 31 characters. `Y` is the light; a dot groups the rest, `board.U`.
    pub name: String,
    /// The values.
    pub samples: ChannelSamples,
}

/// The values of a channel, in the two types that EXR can keep without loss here.
#[derive(Debug, Clone, PartialEq)]
pub enum ChannelSamples {
    /// Any quantity.
    F32(Raster<f32>),
    /// Classes and counts.
    U32(Raster<u32>),
}

impl Channel {
    /// A plane of f32.
    pub fn f32(name: impl Into<String>, values: Raster<f32>) -> Self {
        Self { name: name.into(), samples: ChannelSamples::F32(values) }
    }

    /// A plane of u32.
    pub fn u32(name: impl Into<String>, values: Raster<u32>) -> Self {
        Self { name: name.into(), samples: ChannelSamples::U32(values) }
    }
}

impl ChannelSamples {
    /// Columns and rows.
    pub fn size(&self) -> (usize, usize) {
        match self {
            Self::F32(plane) => (plane.width(), plane.height()),
            Self::U32(plane) => (plane.width(), plane.height()),
        }
    }
}
