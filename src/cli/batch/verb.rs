//! What is done with each scene of a batch.

use crate::analysis::compare::{JudgeOptions, judge_built, prisms};
use crate::analysis::fates::fates;
use crate::cli::args::{Args, RenderArgs, Verb};
use crate::cli::compare_args::CompareArgs;
use crate::cli::design_args::DesignArgs;
use crate::cli::study::of_scene;
use crate::cli::study_args::AnalyseArgs;
use crate::cli::{accuracy, design, files};
use crate::error::Error;
use crate::render::render_classed;
use crate::report::{comparison, design as design_report, picture};
use crate::scene::Scene;
use crate::system::{DesignStore, build_from};
use clap::Parser;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Options that write files, or are the batch's own.
const NO_OPTIONS: [&str; 12] = [
    "--out",
    "--pictures",
    "--cloud",
    "--solid",
    "--figure",
    "--json",
    "--set",
    "--threads",
    "--halves",
    "--stereo",
    "--quiet",
    "--verbose",
];

/// The verb with its options.
pub(super) enum BatchWork {
    Compare(CompareArgs),
    Render(RenderArgs),
    Design(DesignArgs),
    Analyse(AnalyseArgs),
}

impl BatchWork {
    /// Of words such as `analyse stereo --grid 33`, with one blank between them.
    ///
    /// # Errors
    /// What is no verb of a batch, or an option that has no place in one.
    pub(super) fn of_words(words: &str) -> Result<Self, Error> {
        let told = |rule| Error::new("--verb", rule, "write it as in --verb \"compare --target-px 0.01\"");
        Self::of_verb(words).map_err(told)
    }

    fn of_verb(verb: &str) -> Result<Self, String> {
        let words: Vec<&str> = verb.split(' ').collect();
        let name = |word: &str| word.split('=').next().unwrap_or_default().to_owned();
        if let Some(option) = words.iter().find(|word| NO_OPTIONS.contains(&name(word).as_str())) {
            return Err(format!("{option} has no place here: a batch writes its lines alone"));
        }
        let known = "the verbs of a batch are compare, render, design and analyse with spot, field-curvature, mtf, \
                     reprojection, surface or stereo";
        if !["compare", "render", "design", "analyse"].contains(&words[0]) {
            return Err(known.to_owned());
        }
        if let ["analyse", "paper" | "stability", ..] = words[..] {
            return Err(format!("{verb} has no place in a batch: it has scenes of its own; {known}"));
        }
        let picture: &[&str] = if words[0] == "render" { &["--out", "none.png"] } else { &[] };
        let line = ["biprism"].iter().chain(&words).chain(&["-"]).chain(picture);
        let args = Args::try_parse_from(line).map_err(|error| {
            let told = error.render().to_string();
            let first = told.lines().next().unwrap_or_default();
            format!("{}; {known}", first.strip_prefix("error: ").unwrap_or(first))
        })?;
        let one = |scenes: usize| (scenes == 1).then_some(()).ok_or_else(|| "the scene is that of the job".to_owned());
        match args.verb {
            Some(Verb::Compare(args)) => one(args.scenes.len()).map(|()| BatchWork::Compare(args)),
            Some(Verb::Render(args)) => Ok(BatchWork::Render(args)),
            Some(Verb::Design(args)) => Ok(BatchWork::Design(args)),
            Some(Verb::Analyse(args)) => match of_scene::refusal(&args.study) {
                None => Ok(BatchWork::Analyse(args)),
                Some(why) => Err(format!("{verb} has no place in a batch: {why}; {known}")),
            },
            _ => Err(known.to_owned()),
        }
    }

    /// The figures of `scene`, which `place` names in messages, with designs of `designs`; of the verb `render` its picture goes to the file
    /// `png`, where there is one.
    pub(super) fn figures(
        &self,
        scene: Scene,
        place: &Path,
        designs: &DesignStore,
        png: Option<PathBuf>,
    ) -> Result<Value, Error> {
        match self {
            Self::Compare(args) => compared(args, accuracy::asked(scene, args.target_px), place, designs),
            Self::Render(args) => rendered(&accuracy::asked(scene, args.target_px), place, designs, png),
            Self::Design(args) => {
                files::named(place, design::figures_and_prism(scene, args)).map(|(figures, _)| figures)
            }
            Self::Analyse(args) => {
                let document = of_scene::document(&args.study, &scene, place, designs)?;
                let sheet = |document: &crate::report::study::document::StudyDocument| {
                    let sheets = document
                        .sheets
                        .iter()
                        .filter(|sheet| !sheet.detail)
                        .map(|sheet| (sheet.name.to_owned(), sheet.json()["rows"].take()));
                    Value::Object(sheets.collect())
                };
                Ok(document.as_ref().map_or(Value::Null, sheet))
            }
        }
    }
}

/// The figures that a job of `biprism batch --verb VERB` has of `scene`, which `place` names in messages, with designs of `designs`.
///
/// # Errors
/// What is no verb of a batch or has an option that has no place in one, and what the verb says of the scene.
pub fn figures(verb: &str, scene: Scene, place: &Path, designs: &DesignStore) -> Result<Value, Error> {
    known(verb)?.figures(scene, place, designs, None)
}

/// The figures of `biprism design`, given with its options as in `design --objective toed-in`, and the designed prism as the
/// `[prism]` part of a scene.
///
/// # Errors
/// As [`figures`], and when no prism is designed.
pub fn designed(verb: &str, scene: Scene, place: &Path) -> Result<(Value, String), Error> {
    match known(verb)? {
        BatchWork::Design(args) => files::named(place, design::figures_and_prism(scene, &args)),
        _ => Err(Error::new(verb, "the verb designs nothing", "give `design` and its options")),
    }
}

/// The verb of these words, for callers that are no command.
fn known(verb: &str) -> Result<BatchWork, Error> {
    BatchWork::of_verb(verb).map_err(|rule| Error::new(verb, rule, "`biprism VERB --help` lists its options"))
}

/// The report of the scene's prisms, each by its name.
fn compared(args: &CompareArgs, scene: Scene, place: &Path, designs: &DesignStore) -> Result<Value, Error> {
    files::checkerboard(&scene, place)?;
    let mut entries = Map::new();
    for (name, scene) in prisms(&scene)? {
        let system = files::named(place, build_from(&scene, designs))?;
        let judged = files::named(place, judge_built(&name, scene, system, JudgeOptions { budget: args.budget }, &()))?;
        entries.insert(name, json!(comparison::entry(&judged, BTreeMap::new())));
    }
    Ok(Value::Object(entries))
}

/// What became of the rays of the picture, which goes to the file `png`, and what it kept to.
fn rendered(scene: &Scene, place: &Path, designs: &DesignStore, png: Option<PathBuf>) -> Result<Value, Error> {
    let system = files::named(place, build_from(scene, designs))?;
    let film = render_classed(&system, &());
    if let Some(png) = png {
        picture::write_all(&[png], scene, &system, &film)?;
    }
    Ok(json!({
        "fates": film.class.as_ref().map(fates),
        "counts": film.counts,
        "accuracy": design_report::accuracy(&film.account, &film.counts),
    }))
}
