//! A run of `biprism batch`.

use super::job_file::JobFile;
use super::jobs::{BatchJob, Jobs};
use super::verb::BatchWork;
use crate::cli::batch_args::BatchArgs;
use crate::cli::outcome::Outcome;
use crate::cli::progress::Progress;
use crate::cli::{files, output};
use crate::error::Error;
use crate::io::atomic::write_atomically;
use crate::progress::Observer;
use crate::report::batch::flat::flat;
use crate::report::batch::flat::unmet;
use crate::report::batch::job_line::{JobError, JobLine};
use crate::system::DesignStore;
use serde_json::{Map, Value, json};
use std::fs;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, scope};
use std::time::Instant;

pub(crate) fn run(args: &BatchArgs) -> Result<Outcome, Error> {
    let verb = args.verb.split_whitespace().collect::<Vec<_>>().join(" ");
    let work = BatchWork::of_words(&verb)?;
    if args.pictures.is_some() && !matches!(work, BatchWork::Render(_)) {
        let rule = format!("the verb is {verb}, and pictures are those of the verb render");
        return Err(Error::new("--pictures", rule, "leave --pictures out, or write --verb render"));
    }
    let jobs = Jobs::of(args, verb)?;

    // See what is there.
    let shard = args.shard.unwrap_or([1, 1]);
    let own: Vec<u32> = (shard[0] - 1..jobs.count).step_by(shard[1] as usize).collect();
    let name = args.shard.map_or("batch.jsonl".to_owned(), |[i, n]| format!("batch_{i}_of_{n}.jsonl"));
    let path = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(name));
    let file = JobFile::open(&path, jobs.count, |number| jobs.job(number).head)?;
    let missing: Vec<u32> = own.iter().copied().filter(|job| file.places[*job as usize].is_none()).collect();
    if file.was_torn {
        output::stderr(&format!("{}: its last line was cut off, and is made anew", path.display()));
    }
    let there = own.len() - missing.len();
    if there > 0 {
        output::stderr(&format!("{}: goes on after {there} jobs", path.display()));
    }

    // Do what is missing.
    if let Some(folder) = &args.pictures {
        own_pictures(folder, &jobs, &missing)?;
        note_lost(folder, own.iter().filter(|job| file.places[**job as usize].is_some()));
    }
    let progress = Progress::new(0);
    let watch = progress.watch("batch");
    watch.stage_of("jobs", missing.len());
    let started = Instant::now();
    let workshop = BatchWorkshop {
        jobs: &jobs,
        work: &work,
        wanted: &args.figure,
        pictures: args.pictures.as_deref(),
        designs: DesignStore::default(),
    };
    let mut file = workshop.do_all(&missing, file, &watch)?;
    file.put_in_order()?;
    drop(progress);

    // Tell it.
    let (seconds, errors, unmet) = (started.elapsed().as_secs_f64(), file.errors, file.unmet);
    let (made, designs) = (missing.len(), workshop.designs.count());
    let told = json!({
        "out": path.display().to_string(), "verb": jobs.verb, "run": jobs.run, "jobs": jobs.count, "shard": args.shard,
        "own": own.len(), "made": made, "errors": errors, "unmet": unmet, "designs": designs, "seconds": seconds,
    });
    let words = format!(
        "{made} of {} jobs were done in {seconds:.1} s, with {designs} designs made for them; {errors} lines are errors\n",
        own.len()
    );
    output::stdout(&if args.json { format!("{told:#}\n") } else { words })?;
    output::stderr(&format!("wrote {}", path.display()));
    let kinds = [(errors, "ended in an error"), (unmet, "did not keep what was asked for")];
    for (count, what) in kinds.into_iter().filter(|(count, _)| *count > 0) {
        output::unmet(&format!("{count} jobs {what}, as their lines tell"));
    }
    Ok(if errors + unmet > 0 { Outcome::Unmet } else { Outcome::Done })
}

/// The file of the picture of a job.
fn png(folder: &Path, job: u32) -> PathBuf {
    folder.join(format!("{job:06}.png"))
}

/// Makes the folder of the pictures of a run, with a file that tells which run that is.
///
/// # Errors
/// Where it has pictures of another run, or cannot be made.
fn own_pictures(folder: &Path, jobs: &Jobs, missing: &[u32]) -> Result<(), Error> {
    files::folder(folder)?;
    let mark = folder.join("run.txt");
    let help = "name another folder with --pictures";
    match fs::read_to_string(&mark) {
        Ok(run) if run.trim() == jobs.run => Ok(()),
        Ok(_) => Err(Error::new(folder.display(), "the folder has the pictures of another run", help)),
        Err(_) => match missing.iter().map(|job| png(folder, *job)).find(|path| path.exists()) {
            Some(path) => Err(Error::new(path.display(), "the file is there, and is none of this run", help)),
            None => write_atomically(&mark, |out| writeln!(out, "{}", jobs.run)),
        },
    }
}

/// Says of how many jobs that are `done` no picture is there.
fn note_lost<'a>(folder: &Path, done: impl Iterator<Item = &'a u32>) {
    let lost = done.filter(|job| !png(folder, **job).exists()).count();
    if lost > 0 {
        let folder = folder.display();
        output::stderr(&format!(
            "note: {lost} jobs that are done have no picture in {folder}: remove their lines to have them"
        ));
    }
}

/// What jobs are done with.
struct BatchWorkshop<'a> {
    jobs: &'a Jobs,
    work: &'a BatchWork,
    /// Paths of the figures that are kept; all where there are none.
    wanted: &'a [String],
    /// Where pictures go.
    pictures: Option<&'a Path>,
    designs: DesignStore,
}

impl BatchWorkshop<'_> {
    /// Does the jobs of these numbers, some at once, and adds their lines to `file` as they are done.
    ///
    /// # Errors
    /// When a line cannot be written.
    fn do_all(&self, numbers: &[u32], file: JobFile, watch: &dyn Observer) -> Result<JobFile, Error> {
        let file = Mutex::new(file);
        let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
        let fault: Mutex<Option<Error>> = Mutex::new(None);
        let work = || {
            while let Some(&number) = numbers.get(next.fetch_add(1, Ordering::Relaxed)) {
                if stopped.load(Ordering::Relaxed) {
                    break;
                }
                let line = self.line(&self.jobs.job(number));
                let written = line.and_then(|line| file.lock().unwrap_or_else(PoisonError::into_inner).append(&line));
                match written {
                    Ok(()) => watch.pixels(1),
                    Err(problem) => {
                        stopped.store(true, Ordering::Relaxed);
                        fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(problem);
                    }
                }
            }
        };
        let threads = rayon::current_num_threads();
        if threads < 2 || numbers.len() < threads {
            // Few jobs are done one by one, each by all threads.
            work();
        } else {
            scope(|scope| {
                let alone = || {
                    // What a job does in parallel is done by its own thread: jobs are enough to keep all of them busy.
                    let own = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
                    work();
                    drop(own);
                };
                let started: Vec<_> =
                    (0..threads).map_while(|_| Builder::new().spawn_scoped(scope, alone).ok()).collect();
                if started.is_empty() {
                    work();
                }
            });
        }
        match fault.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(problem) => Err(problem),
            None => Ok(file.into_inner().unwrap_or_else(PoisonError::into_inner)),
        }
    }

    /// Does one job.
    ///
    /// # Errors
    /// What would be wrong with every other job as well: a picture that cannot be written, and figures of which none is wanted.
    fn line(&self, job: &BatchJob<'_>) -> Result<JobLine, Error> {
        let started = Instant::now();
        let mut name = None;
        let png = self.pictures.map(|folder| png(folder, job.head.job));
        let done = catch_unwind(AssertUnwindSafe(|| {
            let scene = job.scene()?;
            name = Some(scene.name.clone());
            self.work.figures(scene, job.path(), &self.designs, png.clone())
        }));
        let done = done.unwrap_or_else(|_| {
            let rule = "the program failed, as stderr tells";
            Err(Error::new(job.path().display(), rule, "report the scene with the changed keys; other jobs go on"))
        });
        let (figures, unmet, error) = match done {
            Ok(figures) => (Some(self.kept(&figures)?), unmet(&figures), None),
            Err(problem) if png.is_some_and(|png| problem.place == png.display().to_string()) => return Err(problem),
            Err(problem) => (None, Vec::new(), Some(JobError::from(&problem))),
        };
        let seconds = started.elapsed().as_secs_f64();
        Ok(JobLine { head: job.head.clone(), scene: name, set: job.set(), figures, unmet, error, seconds })
    }

    /// The figures that are wanted of all of a job.
    fn kept(&self, figures: &Value) -> Result<Map<String, Value>, Error> {
        let kept = flat(figures, self.wanted);
        if !kept.is_empty() || self.wanted.is_empty() {
            return Ok(kept);
        }
        let all = flat(figures, &[]);
        let rule = format!("no figure of `{}` is called {}", self.jobs.verb, self.wanted.join(" or "));
        let first = all.keys().next().map_or("none", String::as_str);
        let help =
            format!("give a path as in a line without --figure, or its beginning up to a slash: the first is {first}");
        Err(Error::new("--figure", rule, help))
    }
}
