//! A run of `biprism batch`.

use super::job_file::JobFile;
use super::jobs::{BatchJob, Jobs};
use super::verb::BatchWork;
use crate::cli::batch_args::BatchArgs;
use crate::cli::outcome::Outcome;
use crate::cli::progress::Progress;
use crate::cli::{files, output};
use crate::error::Error;
use crate::progress::Observer;
use crate::report::batch::flat::flat;
use crate::report::batch::job_line::{JobError, JobLine};
use crate::system::DesignStore;
use serde_json::json;
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
    args.pictures.as_deref().map_or(Ok(()), files::folder)?;
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
    let (seconds, errors) = (started.elapsed().as_secs_f64(), file.errors);
    let (made, designs) = (missing.len(), workshop.designs.count());
    let told = json!({
        "out": path.display().to_string(), "verb": jobs.verb, "run": jobs.run, "jobs": jobs.count, "shard": args.shard,
        "own": own.len(), "made": made, "errors": errors, "designs": designs, "seconds": seconds,
    });
    let words = format!(
        "{made} of {} jobs were done in {seconds:.1} s, with {designs} designs made for them; {errors} lines are errors\n",
        own.len()
    );
    output::stdout(&if args.json { format!("{told:#}\n") } else { words })?;
    output::stderr(&format!("wrote {}", path.display()));
    if errors > 0 {
        output::unmet(&format!("{errors} jobs ended in an error, which their lines tell"));
        return Ok(Outcome::Unmet);
    }
    Ok(Outcome::Done)
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
                let written = file.lock().unwrap_or_else(PoisonError::into_inner).append(&line);
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
    fn line(&self, job: &BatchJob<'_>) -> JobLine {
        let started = Instant::now();
        let mut name = None;
        let done = catch_unwind(AssertUnwindSafe(|| {
            let scene = job.scene()?;
            name = Some(scene.name.clone());
            let png = self.pictures.map(|folder| folder.join(format!("{:06}.png", job.head.job)));
            self.work.figures(scene, job.path(), &self.designs, png)
        }));
        let done = done.unwrap_or_else(|_| {
            let rule = "the program failed, as stderr tells";
            Err(Error::new(job.path().display(), rule, "report the scene with the changed keys; other jobs go on"))
        });
        let (figures, error) = match done {
            Ok(figures) => (Some(flat(&figures, self.wanted)), None),
            Err(problem) => (None, Some(JobError::from(&problem))),
        };
        let seconds = started.elapsed().as_secs_f64();
        JobLine { head: job.head.clone(), scene: name, set: job.set(), figures, error, seconds }
    }
}
