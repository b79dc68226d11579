//! `biprism analyse reprojection`, `convergence`, `surface` and `layout`.

use super::common::{StudiedPrism, marches, prisms, settings, write, write_into};
use crate::analysis::convergence::plans;
use crate::analysis::cutter;
use crate::analysis::half_image::HalfFrame;
use crate::analysis::layout;
use crate::analysis::reprojection_study::errors;
use crate::analysis::surface_fits::degree_fits;
use crate::cli::files;
use crate::cli::outcome::Outcome;
use crate::cli::prisms_args::PrismsArgs;
use crate::cli::progress::Progress;
use crate::cli::study_args::{ConvergenceArgs, ReprojectionArgs};
use crate::error::Error;
use crate::report::study::convergences;
use crate::report::study::document::StudyDocument;
use crate::report::study::layouts::{self, NamedLayout};
use crate::report::study::reprojections::{self, NamedReprojections};
use crate::report::study::surfaces::{self, NamedFits, NamedSurfaces};
use crate::system::Side;
use crate::vision::half::Half;
use serde_json::{Map, json};
use std::path::Path;

pub(crate) fn reprojection(args: &ReprojectionArgs) -> Result<Outcome, Error> {
    let progress = Progress::new(0);
    let document = reprojection_of(args, &prisms(&args.prisms, &progress)?)?;
    drop(progress);
    write(&args.prisms, &document)
}

pub(super) fn reprojection_of(args: &ReprojectionArgs, prisms: &[StudiedPrism]) -> Result<StudyDocument, Error> {
    let mut found = Vec::new();
    for prism in prisms {
        for (side, word) in prism.sides() {
            let half = if side == Side::Left { Half::Left } else { Half::Right };
            let planes = prism.named(errors(&prism.judged.scene, &prism.system, half, args.grid, &args.depth_mm))?;
            let size_px = HalfFrame::new(&prism.system, half).size_px;
            found.push(NamedReprojections { prism: prism.judged.name.clone(), half: word, size_px, planes });
        }
    }
    let settings = settings([("grid", json!(args.grid)), ("depth_mm", json!(args.depth_mm))]);
    let (sheets, figures) = (reprojections::sheets(&found), reprojections::figures(&found));
    Ok(StudyDocument { name: "reprojection", settings, sheets, figures })
}

pub(crate) fn convergence(args: &ConvergenceArgs) -> Result<Outcome, Error> {
    let scene = files::scene(args.scene.as_deref(), &args.values)?;
    let plans = plans(args.coarsest_um, args.finest_um.min(args.coarsest_um));
    let progress = Progress::new(0);
    let rows = marches(&scene, plans, &args.degree, &progress.watch(&scene.name));
    let rows = files::named(args.scene.as_deref().unwrap_or(Path::new("scenes/paper.toml")), rows)?;
    drop(progress);
    let settings = settings([
        ("degree", json!(args.degree)),
        ("coarsest_um", json!(args.coarsest_um)),
        ("finest_um", json!(args.finest_um)),
    ]);
    let (sheets, figures) = (vec![convergences::sheet(&rows)], convergences::figures(&scene.name, &rows));
    let document = StudyDocument { name: "convergence", settings, sheets, figures };
    write_into(&args.out, args.json, &document)
}

pub(crate) fn surface(args: &PrismsArgs) -> Result<Outcome, Error> {
    let progress = Progress::new(0);
    let document = surface_of(&prisms(args, &progress)?, &progress)?;
    drop(progress);
    write(args, &document)
}

pub(super) fn surface_of(prisms: &[StudiedPrism], progress: &Progress) -> Result<StudyDocument, Error> {
    let (mut found, mut fits) = (Vec::new(), Vec::new());
    for prism in prisms {
        for (side, half) in prism.sides() {
            let surfaces = prism.named(cutter::surfaces(&prism.system, side))?;
            found.push(NamedSurfaces { prism: prism.judged.name.clone(), half, surfaces });
        }
        progress.begin(&prism.judged.name, "fits");
        let of_degrees = prism.named(degree_fits(&prism.judged.scene))?;
        fits.push(NamedFits { prism: prism.judged.name.clone(), fits: of_degrees });
    }
    let (sheets, figures) = (surfaces::sheets(&found, &fits), surfaces::figures(&found, &fits));
    Ok(StudyDocument { name: "surface", settings: Map::new(), sheets, figures })
}

pub(crate) fn layout(args: &PrismsArgs) -> Result<Outcome, Error> {
    let progress = Progress::new(0);
    let mut found = Vec::new();
    for prism in prisms(args, &progress)? {
        let layout = prism.named(layout::layout(&prism.system))?;
        found.push(NamedLayout { prism: prism.judged.name.clone(), layout });
    }
    drop(progress);
    let (sheets, figures) = (vec![layouts::sheet(&found)], layouts::figures(&found));
    write(args, &StudyDocument { name: "layout", settings: Map::new(), sheets, figures })
}
