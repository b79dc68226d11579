//! OpenEXR files: a picture of light with its ground truth out, any flat EXR in.

mod read;
mod write;
mod zip;
mod channel;

pub(super) use channel::SIGNATURE;
pub use channel::{Channel, ChannelSamples};

pub use read::{read, read_channels};
pub use write::{BLOCK_ROWS, write, write_strips};

pub(super) use read::read_from;
