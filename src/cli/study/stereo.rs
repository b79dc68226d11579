//! `biprism analyse stereo`.

use super::common::{StudiedPrism, built, settings, write};
use crate::analysis::stereo_study::{StereoStudyInput, exact_of, study};
use crate::cli::compare::{ToJudge, candidates};
use crate::cli::outcome::Outcome;
use crate::cli::prisms_args::few_depths;
use crate::cli::progress::Progress;
use crate::cli::study_args::StereoArgs;
use crate::error::Error;
use crate::report::study::document::StudyDocument;
use crate::report::study::stereo_residuals::{self, NamedStereoStudy};
use serde_json::json;

pub(crate) fn stereo(args: &StereoArgs) -> Result<Outcome, Error> {
    few_depths("--depths-mm", &args.depths_mm)?;

    let mut prisms = candidates(&args.prisms.scenes, &args.prisms.values)?;
    if args.prisms.scenes.len() == 1 {
        prisms = with_exact(prisms);
    }
    let progress = Progress::new(0);
    let document = stereo_of(args, &built(prisms, &progress)?, &progress)?;
    drop(progress);
    write(&args.prisms, &document)
}

/// The prisms of one scene, with the exact one beside them.
pub(super) fn with_exact(mut prisms: Vec<ToJudge>) -> Vec<ToJudge> {
    let exact = prisms.last().and_then(|last| Some((exact_of(&last.scene)?, last.path.clone())));
    prisms.extend(exact.map(|(scene, path)| ToJudge { name: "exact".to_owned(), scene, path }));
    prisms
}

pub(super) fn stereo_of(
    args: &StereoArgs,
    prisms: &[StudiedPrism],
    progress: &Progress,
) -> Result<StudyDocument, Error> {
    let input = StereoStudyInput {
        depths_mm: args.depths_mm.clone(),
        fit_depth_mm: args.fit_depth_mm,
        tilt_rad: args.tilt_deg.to_radians(),
        degree: args.degree,
        grid: args.grid,
    };
    let mut found = Vec::new();
    for prism in prisms {
        progress.begin(&prism.judged.name, "matches");
        let study = prism.named(study(&prism.system, &input))?;
        found.push(NamedStereoStudy { prism: prism.judged.name.clone(), study });
    }
    let settings = settings([
        ("depths_mm", json!(args.depths_mm)),
        ("fit_depth_mm", json!(args.fit_depth_mm)),
        ("tilt_deg", json!(args.tilt_deg)),
        ("degree", json!(args.degree)),
        ("grid", json!(args.grid)),
    ]);
    let (sheets, figures) = (stereo_residuals::sheets(&found), vec![stereo_residuals::figure(&found)]);
    Ok(StudyDocument { name: "stereo", settings, sheets, figures })
}
