//! `biprism analyse stereo`.

use super::common::{built, settings, write};
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

    // The prisms of one scene, with the exact one beside them.
    let mut prisms = candidates(&args.prisms.scenes)?;
    if let ([_], Some(last)) = (args.prisms.scenes.as_slice(), prisms.last())
        && let Some(scene) = exact_of(&last.scene)
    {
        let exact = ToJudge { name: "exact".to_owned(), scene, path: last.path.clone() };
        prisms.push(exact);
    }

    let input = StereoStudyInput {
        depths_mm: args.depths_mm.clone(),
        fit_depth_mm: args.fit_depth_mm,
        tilt_rad: args.tilt_deg.to_radians(),
        degree: args.degree,
        grid: args.grid,
    };
    let progress = Progress::new(0);
    let mut found = Vec::new();
    for prism in built(prisms, &progress)? {
        progress.begin(&prism.judged.name, "matches");
        let study = prism.named(study(&prism.system, &input))?;
        found.push(NamedStereoStudy { prism: prism.judged.name.clone(), study });
    }
    drop(progress);
    let settings = settings([
        ("depths_mm", json!(args.depths_mm)),
        ("fit_depth_mm", json!(args.fit_depth_mm)),
        ("tilt_deg", json!(args.tilt_deg)),
        ("degree", json!(args.degree)),
        ("grid", json!(args.grid)),
    ]);
    let (sheets, figures) = (stereo_residuals::sheets(&found), vec![stereo_residuals::figure(&found)]);
    write(&args.prisms, &StudyDocument { name: "stereo", settings, sheets, figures })
}
