//! Studies of one scene by itself, without files.

use super::common::built_from;
use super::design::{reprojection_of, surface_of};
use super::relay::{field_curvature_of, mtf_of, spot_of};
use super::stereo::{stereo_of, with_exact};
use crate::analysis::compare::prisms;
use crate::cli::compare::ToJudge;
use crate::cli::prisms_args::few_depths;
use crate::cli::progress::Progress;
use crate::cli::study_args::Study;
use crate::error::Error;
use crate::report::study::document::StudyDocument;
use crate::scene::Scene;
use crate::system::DesignStore;
use std::path::Path;

/// Why a study has no place here, where it has none: it is not of one scene, or has a way of its own to be spread over machines.
pub(crate) fn refusal(study: &Study) -> Option<&'static str> {
    match study {
        Study::Tolerance(_) => Some("its trials have --shard of their own"),
        Study::Convergence(_) => Some("its times are of a machine that does nothing else"),
        Study::Layout(_) => Some("it is a drawing"),
        _ => None,
    }
}

/// What `study` finds of the prisms of `scene`, which `place` names in messages; nothing of one with a [`refusal`].
pub(crate) fn document(
    study: &Study,
    scene: &Scene,
    place: &Path,
    designs: &DesignStore,
) -> Result<Option<StudyDocument>, Error> {
    let progress = Progress::silent();
    let named = |(name, scene)| ToJudge { name, scene, path: place.to_owned() };
    let candidates = || Ok::<Vec<ToJudge>, Error>(prisms(scene)?.into_iter().map(named).collect());
    let all = || built_from(candidates()?, designs, &progress);
    match study {
        Study::Spot(args) => spot_of(args, &all()?, &progress),
        Study::FieldCurvature(args) => field_curvature_of(args, &all()?, &progress),
        Study::Mtf(args) => mtf_of(args, &all()?, &progress),
        Study::Reprojection(args) => reprojection_of(args, &all()?),
        Study::Surface(_) => surface_of(&all()?, &progress),
        Study::Stereo(args) => {
            few_depths("--depths-mm", &args.depths_mm)?;
            stereo_of(args, &built_from(with_exact(candidates()?), designs, &progress)?, &progress)
        }
        Study::Stability(_) | Study::Paper(_) | Study::Tolerance(_) | Study::Convergence(_) | Study::Layout(_) => {
            return Ok(None);
        }
    }
    .map(Some)
}
