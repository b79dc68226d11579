//! `biprism compare`: the main job, from prisms to a verdict.

use super::compare_args::{CompareArgs, PicturesArg};
use super::expect::expectations;
use super::outcome::Outcome;
use super::progress::Progress;
use super::set_args::SetArgs;
use super::threads::SPARE_THREADS;
use super::{accuracy, files, origin, output};
use crate::analysis::compare::{JudgeOptions, JudgedDesign, judge_design, named_apart, pixels, prisms};
use crate::error::Error;
use crate::plot::drawing::Drawing;
use crate::progress::Observer;
use crate::report::json::{Design, Report, SchemaName, to_text};
use crate::report::page::comparison::{self as comparison_page, PagePrism};
use crate::report::{self, budget, cameras, comparison, corner_table, picture, table};
use crate::scene::{Expect, Scene};
use crate::system::doubts;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, ScopedJoinHandle};

/// A prism to be judged: its name, its scene, and where that comes from.
pub(super) struct ToJudge {
    pub(super) name: String,
    pub(super) scene: Scene,
    pub(super) path: PathBuf,
}

pub(super) fn run(args: &CompareArgs) -> Result<Outcome, Error> {
    // Read the scenes, and look whether all files may be written.
    let asked = |scene: Scene| accuracy::asked(scene, args.target_px);
    let candidates =
        candidates(&args.scenes, &args.values)?.into_iter().map(|one| ToJudge { scene: asked(one.scene), ..one });
    let candidates: Vec<ToJudge> = candidates.collect();
    candidates.iter().try_for_each(|one| files::checkerboard(&one.scene, &one.path))?;
    outputs(args, &candidates)?;

    // Judge the prisms, some at once.
    let options = JudgeOptions { budget: args.budget };
    let progress = Progress::new(candidates.iter().map(|one| pixels(&one.scene, options)).sum());
    let (mut judged, mut designs, mut written) = (Vec::new(), Vec::new(), Vec::new());
    for done in side_by_side(candidates, |one| judge(one, options, args, &progress)) {
        let JudgedFiles { design, entry, files } = done?;
        for (path, clamped) in files {
            files::print_clamped(&path, clamped);
            written.push(path);
        }
        designs.push(entry);
        judged.push(design);
    }

    // Write what they have in common.
    progress.begin("all", "figure");
    let verdict = table::verdict(&designs);
    let report = Report { schema: SchemaName::V1, scene: scene_names(&judged), designs };
    written.extend(write_common(args, &judged, &report, &verdict)?);
    drop(progress);

    // Say what came out.
    let several = args.scenes.len() != 1;
    let expected = if several { claims(&judged, &report)? } else { expectations(&judged[0].scene, &report)? };
    let text = if args.json { to_text(&report) } else { format!("{}\n\n{verdict}\n", table::text(&report.designs)) };
    output::stdout(&text)?;
    say(&judged, &report, &written);
    let kept = judged.iter().map(|j| accuracy::told(&j.name, &j.film.account, &j.film.counts));
    let nothing = not_judged(&report);
    let judged = if nothing { Outcome::Unmet } else { Outcome::Done };
    Ok(kept.fold(expected.and(judged), Outcome::and))
}

/// The prisms of the one scene, or that of each; without a scene those of the design paper and the exact one.
pub(super) fn candidates(scenes: &[PathBuf], values: &SetArgs) -> Result<Vec<ToJudge>, Error> {
    if scenes.is_empty() {
        let exact = ToJudge {
            name: "exact".to_owned(),
            scene: files::exact_scene(values)?,
            path: PathBuf::from("scenes/exact.toml"),
        };
        return Ok(paper_prisms(values)?.into_iter().chain([exact]).collect());
    }
    if let [path] = scenes {
        let named = prisms(&files::scene(Some(path), values)?)?.into_iter();
        return Ok(named.map(|(name, scene)| ToJudge { name, scene, path: path.clone() }).collect());
    }
    if scenes.iter().filter(|path| files::is_stdin(path)).count() > 1 {
        let help = "name files, and stdin once";
        return Err(Error::new("the scenes", "`-` is there more than once, and stdin is read only once", help));
    }
    let loaded = scenes.iter().map(|path| files::scene(Some(path), values)).collect::<Result<Vec<_>, Error>>()?;
    let stems: Vec<String> = scenes.iter().map(|path| stem(path)).collect();
    let named = named_apart(&stems.iter().map(String::as_str).collect::<Vec<_>>(), loaded)?.into_iter();
    Ok(named.zip(scenes).map(|((name, scene), path)| ToJudge { name, scene, path: path.clone() }).collect())
}

/// The flat and the freeform prism of the design paper.
pub(super) fn paper_prisms(values: &SetArgs) -> Result<Vec<ToJudge>, Error> {
    let named = prisms(&files::scene(None, values)?)?.into_iter();
    Ok(named.map(|(name, scene)| ToJudge { name, scene, path: PathBuf::from("scenes/paper.toml") }).collect())
}

/// The name of a file without its ending, of letters, digits, `_` and `-`, with a letter or `_` in front.
fn stem(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let named = stem.replace(|c: char| !c.is_ascii_alphanumeric() && c != '-', "_");
    if named.starts_with(|c: char| c.is_ascii_alphabetic()) { named } else { format!("_{named}") }
}

/// Whether nothing was judged, and says why.
pub(super) fn not_judged(report: &Report) -> bool {
    let nothing = report.designs.iter().all(|design| design.not_judged.is_some());
    for design in report.designs.iter().filter(|_| nothing) {
        output::unmet(&format!(
            "{}: nothing was measured: {}",
            design.name,
            design.not_judged.as_deref().unwrap_or_default()
        ));
    }
    nothing
}

/// The names of the scenes, each once.
fn scene_names(judged: &[JudgedDesign]) -> String {
    let mut names: Vec<&str> = judged.iter().map(|design| design.scene.name.as_str()).collect();
    names.dedup();
    names.join(", ")
}

/// A prism that was judged, with what the report says of it and its files, of each the pixels that were clamped.
struct JudgedFiles {
    design: JudgedDesign,
    entry: Design,
    files: Vec<(PathBuf, usize)>,
}

/// Judges a prism, and writes its pictures.
fn judge(one: ToJudge, options: JudgeOptions, args: &CompareArgs, progress: &Progress) -> Result<JudgedFiles, Error> {
    let ToJudge { name, scene, path } = one;
    let watch = progress.watch_beside(&name);
    let design = files::named(&path, judge_design(&name, scene, options, &watch))?;
    watch.stage("write");
    let path = |ending: &&str| args.out.join(format!("{name}.{ending}"));
    let paths: Vec<PathBuf> = args.pictures.endings().iter().map(path).collect();
    let clamped = picture::write_all(&paths, &design.scene, &design.system, &design.film)?;
    let files = paths.into_iter().zip(clamped).collect();
    let entry = comparison::entry(&design, watch.take_seconds());
    Ok(JudgedFiles { design, entry, files })
}

/// What `work` makes of each, in their order, by as many threads at once as pictures are made by, and no more than
/// [`SPARE_THREADS`]. They are none of those, whose work on one prism would wait for that on another.
fn side_by_side<T: Send, R: Send>(all: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let threads = rayon::current_num_threads().min(SPARE_THREADS).min(all.len());
    if threads < 2 {
        return all.into_iter().map(work).collect();
    }
    let left = Mutex::new(all.into_iter().enumerate());
    let next = || left.lock().unwrap_or_else(PoisonError::into_inner).next();
    let worker = || std::iter::from_fn(next).map(|(k, one)| (k, work(one))).collect::<Vec<_>>();
    let mut done: Vec<(usize, R)> = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).filter_map(|_| Builder::new().spawn_scoped(scope, worker).ok()).collect();
        let own = worker();
        let join = |other: ScopedJoinHandle<'_, _>| other.join().unwrap_or_else(|panic| resume_unwind(panic));
        own.into_iter().chain(others.into_iter().flat_map(join)).collect()
    });
    done.sort_by_key(|(k, _)| *k);
    done.into_iter().map(|(_, made)| made).collect()
}

/// Writes the figures, the report, the cameras and the corners, some at once: the names of the files.
fn write_common(
    args: &CompareArgs,
    judged: &[JudgedDesign],
    report: &Report,
    verdict: &str,
) -> Result<Vec<PathBuf>, Error> {
    type Job<'a> = Box<dyn FnOnce() -> Result<Vec<PathBuf>, Error> + Send + 'a>;
    let title = &comparison::title(judged);
    let figure =
        |name: &str, drawing: &Drawing, title: &str| files::figure(&args.out, name, drawing, title).map(Vec::from);
    let text = |name: &str, text: &str| {
        let path = args.out.join(name);
        files::text(&path, text).map(|()| vec![path])
    };
    let cameras = || {
        let pair = |design: &'_ Design| Some((design.name.clone(), design.cameras.clone()?));
        cameras::opencv_text(&report.designs.iter().filter_map(pair).collect::<Vec<_>>())
    };
    let budget = || {
        let title = format!("{}: where the error of a corner comes from", report.scene);
        let drawing = args.budget.then(|| budget::figure(title.clone(), judged)).flatten();
        drawing.map_or(Ok(Vec::new()), |drawing| figure("budget", &drawing, &title))
    };
    let drawn: Vec<Job<'_>> = vec![
        Box::new(|| figure("comparison", &comparison::figure(judged, &report.designs, verdict), title)),
        Box::new(|| figure("overview", &comparison::overview(judged), title)),
        Box::new(budget),
        Box::new(|| text("report.html", &page(judged, report, verdict))),
    ];
    let told: Vec<Job<'_>> = vec![
        Box::new(|| text("report.json", &to_text(report))),
        Box::new(|| text("cameras.yml", &cameras())),
        Box::new(|| text("corners.csv", &corner_table::text(judged))),
    ];
    let is_drawn = args.pictures != PicturesArg::None;
    let jobs: Vec<Job<'_>> = drawn.into_iter().filter(|_| is_drawn).chain(told).collect();
    Ok(side_by_side(jobs, |job| job()).into_iter().collect::<Result<Vec<_>, Error>>()?.concat())
}

/// The page to look into.
fn page(judged: &[JudgedDesign], report: &Report, verdict: &str) -> String {
    let prisms = judged.iter().zip(&report.designs).map(|(design, entry)| PagePrism {
        entry,
        judgement: &design.judgement,
        scene: &design.scene,
        system: &design.system,
        picture: Some(&design.film.radiance),
        made: design.film.account.to_string(),
        notes: table::warnings(entry).into_iter().chain(doubts(&design.scene, &design.system)).collect(),
    });
    let title = comparison::title(judged);
    comparison_page::page(&title, verdict, &prisms.collect::<Vec<_>>(), &origin::origin())
}

/// Says what a reader of the table must know besides.
fn say(judged: &[JudgedDesign], report: &Report, written: &[PathBuf]) {
    report.designs.iter().flat_map(table::warnings).for_each(|warning| output::stderr(&warning));
    let fits = report.designs.iter().filter_map(|design| design.surface_fits.as_ref()).flat_map(report::fit::words);
    fits.for_each(|line| output::stderr(&format!("fit of the {line}")));
    for design in judged {
        let doubts = doubts(&design.scene, &design.system);
        doubts.iter().for_each(|doubt| output::stderr(&format!("note: {}: {doubt}", design.name)));
    }
    for path in written {
        output::stderr(&format!("wrote {}", path.display()));
    }
}

/// Holds the claims of each of several scenes against what was judged of it, by its name or by the kind of its prism; claims
/// about another prism, which its scene compared by itself has, are told.
fn claims(judged: &[JudgedDesign], report: &Report) -> Result<Outcome, Error> {
    let mut outcome = Outcome::Done;
    for (design, entry) in judged.iter().zip(&report.designs) {
        let kind = design.scene.prism.kind();
        let names_it = |claim: &Expect| claim.value.split('/').next().is_some_and(|n| n == kind || n == design.name);
        let (own, others): (Vec<Expect>, Vec<Expect>) = design.scene.expect.iter().cloned().partition(names_it);
        for claim in others {
            output::stderr(&format!("note: {}: `{}` is not judged beside other scenes", design.name, claim.value));
        }
        let by_kind = Design { name: kind.to_owned(), ..entry.clone() };
        let of_scene = Report { designs: vec![entry.clone(), by_kind], ..report.clone() };
        outcome = outcome.and(expectations(&Scene { expect: own, ..design.scene.clone() }, &of_scene)?);
    }
    Ok(outcome)
}

/// That every file of the comparison may be written to its folder, which is made.
fn outputs(args: &CompareArgs, candidates: &[ToJudge]) -> Result<(), Error> {
    let endings = args.pictures.endings();
    let pictures = candidates.iter().flat_map(|one| endings.iter().map(|ending| format!("{}.{ending}", one.name)));
    let figures = ["comparison", "overview", "budget"]
        .into_iter()
        .flat_map(|name| ["png", "svg"].map(|end| format!("{name}.{end}")))
        .chain(["report.html".to_owned()])
        .filter(|_| !endings.is_empty());
    let others = ["report.json", "cameras.yml", "corners.csv"].map(str::to_owned);
    let names: Vec<String> = pictures.chain(figures).chain(others).collect();
    files::outputs(&args.out, &names.iter().map(String::as_str).collect::<Vec<_>>()).map(drop)
}
