//! The prisms of a study, and its files.

use crate::analysis::convergence::{MarchPlan, axis_misses};
use crate::analysis::relay::lens::RelayLens;
use crate::cli::compare::{ToJudge, candidates};
use crate::cli::outcome::Outcome;
use crate::cli::prisms_args::{LensArgs, PrismsArgs};
use crate::cli::progress::{Progress, Watch};
use crate::cli::{files, origin, output};
use crate::error::Error;
use crate::progress::Observer;
use crate::report::page::study::StudyPage;
use crate::report::study::convergences::MarchRow;
use crate::report::study::document::StudyDocument;
use crate::scene::Scene;
use crate::system::{DesignStore, Side, System, build_from};
use serde_json::{Map, Value, json};
use std::path::Path;
use std::time::Instant;

/// A prism to be studied.
pub(super) struct StudiedPrism {
    /// Its name, and its scene.
    pub(super) judged: ToJudge,
    /// Its instrument.
    pub(super) system: System,
}

/// Builds the instruments of the prisms that are asked for.
pub(super) fn prisms(args: &PrismsArgs, progress: &Progress) -> Result<Vec<StudiedPrism>, Error> {
    built(candidates(&args.scenes, &args.values)?, progress)
}

/// Builds instruments.
pub(super) fn built(candidates: Vec<ToJudge>, progress: &Progress) -> Result<Vec<StudiedPrism>, Error> {
    built_from(candidates, &DesignStore::default(), progress)
}

/// The same with the designs of `designs`.
pub(super) fn built_from(
    candidates: Vec<ToJudge>,
    designs: &DesignStore,
    progress: &Progress,
) -> Result<Vec<StudiedPrism>, Error> {
    let build = |judged: ToJudge| {
        progress.begin(&judged.name, "design");
        let system = files::named(&judged.path, build_from(&judged.scene, designs))?;
        Ok(StudiedPrism { judged, system })
    };
    candidates.into_iter().map(build).collect()
}

impl StudiedPrism {
    /// The halves that differ: of an instrument that is its own mirror image, the right one alone.
    pub(super) fn sides(&self) -> Vec<(Side, &'static str)> {
        let right = (Side::Right, "right");
        if self.system.is_mirror_symmetric() { vec![right] } else { vec![(Side::Left, "left"), right] }
    }

    /// What was found of it, or what is wrong and in which file.
    pub(super) fn named<T>(&self, made: Result<T, Error>) -> Result<T, Error> {
        files::named(
            &self.judged.path,
            made.map_err(|e| Error { place: format!("{}: {}", self.judged.name, e.place), ..e }),
        )
    }
}

/// Writes the sheets, the figures and the page of a study, and prints it.
pub(super) fn write(args: &PrismsArgs, document: &StudyDocument) -> Result<Outcome, Error> {
    write_into(&args.out, args.json, document)
}

/// [`write`] into the folder `out`, printed as JSON where `as_json`.
pub(super) fn write_into(out: &Path, as_json: bool, document: &StudyDocument) -> Result<Outcome, Error> {
    let title = document.sheets.first().map_or(document.name, |sheet| &sheet.heading);
    let page = StudyPage {
        title,
        introduction: "",
        sheets: &document.sheets,
        figures: vec![("", document.figures.iter().collect())],
    };
    write_with(out, as_json, document, &page.html(&origin::origin()))
}

/// The same with this page.
pub(super) fn write_with(out: &Path, as_json: bool, document: &StudyDocument, page: &str) -> Result<Outcome, Error> {
    let figures = document.figures.iter().flat_map(|figure| ["png", "svg"].map(|end| format!("{}.{end}", figure.name)));
    let tables = document.sheets.iter().map(|sheet| format!("{}.csv", sheet.name));
    let texts = ["html", "json"].map(|end| format!("{}.{end}", document.name));
    let names: Vec<String> = texts.into_iter().chain(tables).chain(figures).collect();
    let paths = files::outputs(out, &names.iter().map(String::as_str).collect::<Vec<_>>())?;

    let json = document.json();
    let mut free = paths.iter();
    let mut next = || free.next().expect("there is a path for every file");
    files::text(next(), page)?;
    files::text(next(), &json)?;
    for sheet in &document.sheets {
        files::text(next(), &sheet.csv())?;
    }
    for figure in &document.figures {
        files::figure(out, &figure.name, &figure.drawing, &figure.title)?;
    }
    output::stdout(&if as_json { json } else { document.tables() })?;
    paths.iter().for_each(|path| output::stderr(&format!("wrote {}", path.display())));
    Ok(Outcome::Done)
}

/// The lens that is asked for.
pub(super) fn lens(args: &LensArgs) -> RelayLens {
    RelayLens { na: args.na, magnification: args.magnification, wavelength_mm: args.wavelength_nm * 1e-6 }
}

/// What was asked of it, for the JSON.
pub(super) fn lens_words(args: &LensArgs) -> Map<String, Value> {
    let pairs = [
        ("na", json!(args.na)),
        ("magnification", json!(args.magnification)),
        ("wavelength_nm", json!(args.wavelength_nm)),
        ("focus_mm", json!(args.focus_mm)),
    ];
    settings(pairs)
}

/// What was asked by name, for the JSON.
pub(super) fn settings(pairs: impl IntoIterator<Item = (&'static str, Value)>) -> Map<String, Value> {
    pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// The marches of `plans` one after the other, so that each has its own time.
pub(super) fn marches(
    scene: &Scene,
    plans: Vec<MarchPlan>,
    degrees: &[usize],
    watch: &Watch<'_>,
) -> Result<Vec<MarchRow>, Error> {
    watch.stage_of("marches", plans.len());
    let mut rows = Vec::new();
    for plan in plans {
        let started = Instant::now();
        let misses = axis_misses(scene, plan, degrees)?;
        let seconds = started.elapsed().as_secs_f64();
        rows.extend(misses.into_iter().map(|miss| MarchRow { plan, miss, seconds }));
        watch.pixels(1);
    }
    Ok(rows)
}
