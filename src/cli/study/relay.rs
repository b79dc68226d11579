//! `biprism analyse spot`, `field-curvature` and `mtf`.

use super::common::{self, StudiedPrism, lens, lens_words, prisms, write};
use crate::analysis::relay::study::{RelayHalf, RelaySettings};
use crate::cli::outcome::Outcome;
use crate::cli::progress::Progress;
use crate::cli::study_args::RelayArgs;
use crate::error::Error;
use crate::report::study::contrasts::{self, NamedContrasts};
use crate::report::study::document::StudyDocument;
use crate::report::study::foci::{self, NamedFoci};
use crate::report::study::spots::{self, NamedSpots};
use crate::system::Side;
use serde_json::{Map, Value, json};

pub(crate) fn spot(args: &RelayArgs) -> Result<Outcome, Error> {
    written(args, spot_of)
}

pub(crate) fn field_curvature(args: &RelayArgs) -> Result<Outcome, Error> {
    written(args, field_curvature_of)
}

pub(crate) fn mtf(args: &RelayArgs) -> Result<Outcome, Error> {
    written(args, mtf_of)
}

/// A study of prisms.
type OfPrisms = fn(&RelayArgs, &[StudiedPrism], &Progress) -> Result<StudyDocument, Error>;

fn written(args: &RelayArgs, study: OfPrisms) -> Result<Outcome, Error> {
    let progress = Progress::new(0);
    let document = study(args, &prisms(&args.prisms, &progress)?, &progress)?;
    drop(progress);
    write(&args.prisms, &document)
}

pub(super) fn spot_of(args: &RelayArgs, prisms: &[StudiedPrism], progress: &Progress) -> Result<StudyDocument, Error> {
    let named = |prism, half: &RelayHalf, side| Ok(NamedSpots { prism, half: side, study: half.spot()? });
    let found = halves(args, prisms, progress, named)?;
    let lens = settings(args).lens;
    let (sheets, figures) = (spots::sheets(&lens, &found), spots::figures(&lens, &found));
    Ok(StudyDocument { name: "spot", settings: words(args), sheets, figures })
}

pub(super) fn field_curvature_of(
    args: &RelayArgs,
    prisms: &[StudiedPrism],
    progress: &Progress,
) -> Result<StudyDocument, Error> {
    let named = |prism, half: &RelayHalf, side| {
        Ok(NamedFoci { prism, half: side, focus_mm: half.focus_mm, lines: half.foci()? })
    };
    let found = halves(args, prisms, progress, named)?;
    let (sheets, figures) = (vec![foci::sheet(&found)], foci::figures(&found));
    Ok(StudyDocument { name: "field_curvature", settings: words(args), sheets, figures })
}

pub(super) fn mtf_of(args: &RelayArgs, prisms: &[StudiedPrism], progress: &Progress) -> Result<StudyDocument, Error> {
    let named = |prism, half: &RelayHalf, side| Ok(NamedContrasts { prism, half: side, study: half.mtf()? });
    let found = halves(args, prisms, progress, named)?;
    let (sheets, figures) = (contrasts::sheets(&found), contrasts::figures(&found));
    Ok(StudyDocument { name: "mtf", settings: words(args), sheets, figures })
}

/// What `study` finds of every half of every prism.
fn halves<T>(
    args: &RelayArgs,
    prisms: &[StudiedPrism],
    progress: &Progress,
    study: impl Fn(String, &RelayHalf, &'static str) -> Result<T, Error>,
) -> Result<Vec<T>, Error> {
    let one = |prism: &StudiedPrism, (side, word): (Side, &'static str)| {
        progress.begin(&prism.judged.name, "rays");
        let half = RelayHalf::new(&prism.system, side, settings(args));
        prism.named(half.and_then(|half| study(prism.judged.name.clone(), &half, word)))
    };
    prisms
        .iter()
        .flat_map(|prism| prism.sides().into_iter().map(move |side| (prism, side)))
        .map(|(p, s)| one(p, s))
        .collect()
}

fn settings(args: &RelayArgs) -> RelaySettings {
    RelaySettings {
        lens: lens(&args.lens),
        focus_mm: args.lens.focus_mm,
        object_mm: args.object_mm,
        field_mm: args.field_mm,
    }
}

/// What was asked, for the JSON.
fn words(args: &RelayArgs) -> Map<String, Value> {
    let own = [("object_mm", json!(args.object_mm)), ("field_mm", json!(args.field_mm))];
    lens_words(&args.lens).into_iter().chain(common::settings(own)).collect()
}
