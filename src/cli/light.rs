//! The light of a picture that a command is given: by the curve that is stated, that the file states, or that suits it best.

use super::args::{CurveArgs, TransferArg};
use super::output;
use crate::analysis::transfer_choice::{self, Curve, TransferChoice};
use crate::error::Error;
use crate::io::{self, CurveSource, Metadata};
use crate::raster::Raster;
use crate::raster::transfer::Transfer;
use std::path::Path;

/// A picture as linear light.
pub(super) struct Light {
    pub(super) picture: Raster<f32>,
    pub(super) metadata: Metadata,
    /// How its curve was found, where neither file nor caller states it.
    pub(super) choice: Option<TransferChoice>,
}

/// Reads the picture at `path`, of two halves or of one view. What was chosen and why goes to stderr.
pub(super) fn read(path: &Path, args: &CurveArgs, halves: bool) -> Result<Light, Error> {
    read_checked(path, args, halves, &|_| Ok(()))
}

/// [`read`], with a look at the picture before anything is sought in it.
pub(super) fn read_checked(
    path: &Path,
    args: &CurveArgs,
    halves: bool,
    check: &dyn Fn(&Raster<f32>) -> Result<(), Error>,
) -> Result<Light, Error> {
    let stated = match args.transfer {
        Some(TransferArg::Linear) => Some(Transfer::Linear),
        Some(TransferArg::Srgb) => Some(Transfer::Srgb),
        Some(TransferArg::Auto) | None => None,
    };
    let source = match stated {
        Some(transfer) if args.force_transfer => CurveSource::Forced(transfer),
        Some(transfer) => CurveSource::Stated(transfer),
        None => CurveSource::FileOrStored,
    };
    let (stored, metadata) = io::read(path, source)?;
    check(&stored)?;
    if !metadata.is_as_stored() {
        return Ok(Light { picture: stored, metadata, choice: None });
    }

    // Find the curve; colours are read again by one of a name, since they are reduced to luminance in light.
    let Some(choice) = transfer_choice::choose(&stored, halves) else {
        output::stderr(
            "note: the file states no transfer curve, and no board was found under any: it is read as sRGB; state the curve \
             with --transfer",
        );
        let (picture, metadata) = io::read(path, CurveSource::Forced(Transfer::Srgb))?;
        return Ok(Light { picture, metadata, choice: None });
    };
    output::stderr(&format!("note: {}: {}", path.display(), choice.words()));
    let picture = match choice.curve {
        Curve::Named(transfer) if metadata.from_colour => io::read(path, CurveSource::Forced(transfer))?.0,
        _ => transfer_choice::light(&stored, &choice),
    };
    Ok(Light { picture, metadata, choice: Some(choice) })
}
