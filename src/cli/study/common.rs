//! The prisms of a study, and its files.

use crate::cli::compare::{ToJudge, candidates};
use crate::cli::outcome::Outcome;
use crate::cli::progress::Progress;
use crate::cli::study_args::PrismsArgs;
use crate::cli::{files, output};
use crate::error::Error;
use crate::report::study::document::StudyDocument;
use crate::system::{Side, System};

/// A prism to be studied.
pub(super) struct StudiedPrism {
    /// Its name, and its scene.
    pub(super) judged: ToJudge,
    /// Its instrument.
    pub(super) system: System,
}

/// Builds the instruments of the prisms that are asked for.
pub(super) fn prisms(args: &PrismsArgs, progress: &Progress) -> Result<Vec<StudiedPrism>, Error> {
    built(candidates(&args.scenes)?, progress)
}

/// Builds instruments.
pub(super) fn built(candidates: Vec<ToJudge>, progress: &Progress) -> Result<Vec<StudiedPrism>, Error> {
    let build = |judged: ToJudge| {
        progress.begin(&judged.name, "design");
        let system = files::build(&judged.scene, &judged.path)?;
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

/// Writes the sheets and figures of a study, and prints it.
pub(super) fn write(args: &PrismsArgs, document: &StudyDocument) -> Result<Outcome, Error> {
    write_with(args, document, &[])
}

/// [`write`] with more files of text, each by its name.
pub(super) fn write_with(
    args: &PrismsArgs,
    document: &StudyDocument,
    more: &[(&str, String)],
) -> Result<Outcome, Error> {
    let figures = document.figures.iter().flat_map(|figure| ["png", "svg"].map(|end| format!("{}.{end}", figure.name)));
    let tables = document.sheets.iter().map(|sheet| format!("{}.csv", sheet.name));
    let texts = more.iter().map(|(name, _)| (*name).to_owned());
    let json = format!("{}.json", document.name);
    let names: Vec<String> = texts.chain([json]).chain(tables).chain(figures).collect();
    let paths = files::outputs(&args.out, &names.iter().map(String::as_str).collect::<Vec<_>>())?;

    let json = document.json();
    let mut free = paths.iter();
    let mut next = || free.next().expect("there is a path for every file");
    for (_, text) in more {
        files::text(next(), text)?;
    }
    files::text(next(), &json)?;
    for sheet in &document.sheets {
        files::text(next(), &sheet.csv())?;
    }
    for figure in &document.figures {
        files::figure(&args.out, &figure.name, &figure.drawing, &figure.title)?;
    }
    output::stdout(&if args.json { json } else { document.tables() })?;
    paths.iter().for_each(|path| output::stderr(&format!("wrote {}", path.display())));
    Ok(Outcome::Done)
}
