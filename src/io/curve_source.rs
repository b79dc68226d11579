//! Where the transfer curve of a picture comes from: its file, or the caller.

use crate::error::Error;
use crate::raster::transfer::Transfer;
use std::path::Path;

/// Where the transfer curve of a picture comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurveSource {
    /// The file; one that states none is refused.
    File,
    /// The file, and where it states none, the values are given as they are stored, on a scale to 1.
    FileOrStored,
    /// The caller; a file that states another is refused.
    Stated(Transfer),
    /// The caller, whatever the file states.
    Forced(Transfer),
}

impl From<Option<Transfer>> for CurveSource {
    fn from(stated: Option<Transfer>) -> Self {
        stated.map_or(Self::File, Self::Stated)
    }
}

/// What [`super::Metadata::transfer_source`] says of values that are given as they are stored.
pub(super) const AS_STORED: &str = "none: the file states no curve";

impl CurveSource {
    /// The curve that the caller states.
    pub(super) fn stated(self) -> Option<Transfer> {
        match self {
            Self::Stated(transfer) | Self::Forced(transfer) => Some(transfer),
            Self::File | Self::FileOrStored => None,
        }
    }

    /// The curve of a file whose `format` names none, and who says so.
    ///
    /// # Errors
    /// Where the caller wants the file's own.
    pub(super) fn of_silent(self, path: &Path, format: &str) -> Result<(Transfer, &'static str), Error> {
        match self {
            Self::Stated(transfer) | Self::Forced(transfer) => Ok((transfer, "the caller")),
            Self::FileOrStored => Ok((Transfer::Linear, AS_STORED)),
            Self::File => {
                let rule = format!("a {format} does not say how its values became of light");
                Err(Error::new(path.display(), rule, SAY))
            }
        }
    }
}

/// What to do where a file does not say.
pub(super) const SAY: &str = "state it: --transfer linear for most machine cameras, srgb for a phone's or a photo camera's \
                              JPEG, or auto to have `biprism corners` find it";
