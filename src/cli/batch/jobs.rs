//! The jobs of a batch: those of a sweep, or of a file.

use crate::cli::batch_args::BatchArgs;
use crate::cli::files::{self, SceneSource};
use crate::error::Error;
use crate::io::inputs;
use crate::report::batch::job_line::{BATCH_SCHEMA, JobHead};
use crate::report::identity::checksum_of_bytes;
use crate::scene::{self, Override, Scene, Sweep};
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// The most jobs of a run.
const MOST_JOBS: u32 = 1_000_000;
/// Longest line of a file of jobs, in bytes.
const MAX_LINE: u64 = 1 << 16;
/// Longest word of a job's own, in bytes.
const MAX_ID: usize = 200;

/// The jobs of a run.
pub(super) struct Jobs {
    pub(super) verb: String,
    /// What tells the run from others.
    pub(super) run: String,
    pub(super) count: u32,
    /// Paths of the figures that are kept.
    figures: Vec<String>,
    scenes: Vec<BatchScene>,
    kind: JobKind,
}

enum JobKind {
    /// Every combination of the sweeps, each with the values that hold for all.
    Sweeps { fixed: Vec<Override>, sweeps: Vec<Sweep> },
    /// Those of a file.
    Listed(Vec<ListedJob>),
}

/// A scene of a run.
struct BatchScene {
    path: PathBuf,
    source: SceneSource,
    /// Of its values and of the files that it names.
    checksum: String,
}

/// A job of a file.
struct ListedJob {
    id: Option<String>,
    /// Its place among the scenes.
    scene: usize,
    values: Vec<Override>,
}

/// A line of a file of jobs.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JobRequest {
    id: Option<String>,
    scene: Option<PathBuf>,
    #[serde(default)]
    set: Map<String, Value>,
}

/// One job.
pub(super) struct BatchJob<'a> {
    pub(super) head: JobHead,
    scene: &'a BatchScene,
    pub(super) values: Vec<Override>,
}

impl Jobs {
    /// The jobs of `verb` that are asked for.
    ///
    /// # Errors
    /// A scene that is not TOML, a file of jobs with a line that is none, two jobs of one id, or too many.
    pub(super) fn of(args: &BatchArgs, verb: String) -> Result<Self, Error> {
        let mut scenes = Vec::new();
        if let Some(path) = &args.scene {
            scenes.push(BatchScene::read(path)?);
        }
        let (kind, count) = match &args.jobs {
            None => {
                let count = args.sweep.iter().try_fold(1u32, |n, sweep| n.checked_mul(sweep.values().len() as u32));
                let count = count.filter(|count| *count <= MOST_JOBS).ok_or_else(|| {
                    let rule = format!("the sweeps make more than {MOST_JOBS} jobs, which is the limit");
                    Error::new("--sweep", rule, "sweep fewer values, or make several runs")
                })?;
                different(args)?;
                (JobKind::Sweeps { fixed: args.values.set.clone(), sweeps: args.sweep.clone() }, count)
            }
            Some(path) => {
                let listed = listed(path, args, &mut scenes)?;
                let count = listed.len() as u32;
                (JobKind::Listed(listed), count)
            }
        };
        let mut jobs = Self { verb, run: String::new(), count, figures: args.figure.clone(), scenes, kind };
        jobs.run = jobs.checksum()?;
        Ok(jobs)
    }

    /// The job of this number.
    pub(super) fn job(&self, number: u32) -> BatchJob<'_> {
        let (own, scene, values) = match &self.kind {
            JobKind::Sweeps { fixed, sweeps } => {
                let mut rest = number as usize;
                let mut chosen = Vec::new();
                for sweep in sweeps.iter().rev() {
                    let count = sweep.values().len();
                    chosen.push(sweep.values()[rest % count].clone());
                    rest /= count;
                }
                (None, 0, fixed.iter().cloned().chain(chosen.into_iter().rev()).collect::<Vec<_>>())
            }
            JobKind::Listed(listed) => {
                let job = &listed[number as usize];
                (job.id.clone(), job.scene, job.values.clone())
            }
        };
        let scene = &self.scenes[scene];
        let told = || format!("{}\n{}\n{}", self.verb, scene.checksum, Value::Object(changed(&values)));
        let id = own.unwrap_or_else(|| checksum_of_bytes(told().bytes()));
        let head = JobHead {
            schema: BATCH_SCHEMA.to_owned(),
            run: self.run.clone(),
            verb: self.verb.clone(),
            job: number,
            jobs: self.count,
            id,
        };
        BatchJob { head, scene, values }
    }

    /// What tells the run: the verb, the figures that are kept, and all jobs with their scenes.
    fn checksum(&self) -> Result<String, Error> {
        let mut ids = BTreeSet::new();
        let mut text = String::new();
        for number in 0..self.count {
            let job = self.job(number);
            text = checksum_of_bytes(format!("{text}\n{}\n{}", job.head.id, job.scene.checksum).bytes());
            if !ids.insert(job.head.id.clone()) {
                let rule = format!("the job {number} has the id of another one, {}", job.head.id);
                return Err(Error::new("the jobs", rule, "give each job another id, or other values, and each once"));
            }
        }
        Ok(checksum_of_bytes(format!("{}\n{}\n{text}", self.verb, self.figures.join("\n")).bytes()))
    }
}

impl BatchJob<'_> {
    /// Where its scene comes from.
    pub(super) fn path(&self) -> &Path {
        &self.scene.path
    }

    /// Its changed keys.
    pub(super) fn set(&self) -> Map<String, Value> {
        changed(&self.values)
    }

    /// Its scene.
    pub(super) fn scene(&self) -> Result<Scene, Error> {
        let BatchScene { path, source, .. } = self.scene;
        scene::parse_with(&source.text, &files::shown(path), source.folder.as_deref(), &self.values)
    }
}

fn changed(values: &[Override]) -> Map<String, Value> {
    values.iter().map(|value| (value.key().to_owned(), value.json())).collect()
}

impl BatchScene {
    fn read(path: &Path) -> Result<Self, Error> {
        let source = files::source(path)?;
        let values = scene::sorted_values(&source.text, &files::shown(path))?;
        let mut sums = vec![checksum_of_bytes(values.to_string().bytes())];
        named_files(&values, source.folder.as_deref(), &mut sums)?;
        let checksum = checksum_of_bytes(sums.concat().bytes());
        Ok(Self { path: path.to_owned(), source, checksum })
    }
}

/// The checksums of the files that words of `values` name, relative to `folder`.
fn named_files(values: &Value, folder: Option<&Path>, sums: &mut Vec<String>) -> Result<(), Error> {
    match values {
        Value::Object(map) => map.values().try_for_each(|value| named_files(value, folder, sums)),
        Value::Array(items) => items.iter().try_for_each(|value| named_files(value, folder, sums)),
        Value::String(word) => {
            let path = folder.unwrap_or(Path::new("")).join(word);
            if path.is_file() {
                let trouble =
                    |error| Error::new(path.display(), format!("it cannot be read: {error}"), "check its rights");
                let file = inputs::open(&path).map_err(trouble)?;
                // What cannot be read to its end is told by the job that reads it.
                sums.push(checksum_of_bytes(BufReader::new(file).bytes().map_while(Result::ok)));
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

/// Refuses two sweeps of one key, and one of a key that is set.
fn different(args: &BatchArgs) -> Result<(), Error> {
    for (k, sweep) in args.sweep.iter().enumerate() {
        if args.sweep[..k].iter().any(|other| other.key() == sweep.key()) {
            let rule = format!("`{}` is swept twice", sweep.key());
            return Err(Error::new("--sweep", rule, "give all its values in one --sweep"));
        }
        if args.values.set.iter().any(|value| value.key() == sweep.key()) {
            let rule = format!("`{}` is both set and swept", sweep.key());
            return Err(Error::new("--sweep", rule, "leave one of the two out"));
        }
    }
    Ok(())
}

/// The jobs of the file at `path`, whose scenes are added to `scenes`.
fn listed(path: &Path, args: &BatchArgs, scenes: &mut Vec<BatchScene>) -> Result<Vec<ListedJob>, Error> {
    let shown = files::shown(path);
    let trouble =
        |error: std::io::Error| Error::new(&shown, format!("it cannot be read: {error}"), "name a file of jobs");
    if files::is_stdin(path) && args.scene.as_deref().is_some_and(files::is_stdin) {
        return Err(Error::new("stdin", "scene and jobs are both to come from stdin", "give one of them as a file"));
    }
    let mut input: Box<dyn BufRead> = if files::is_stdin(path) {
        files::note_stdin();
        Box::new(std::io::stdin().lock())
    } else {
        Box::new(BufReader::new(inputs::open(path).map_err(trouble)?))
    };
    let folder = if files::is_stdin(path) { PathBuf::new() } else { path.parent().unwrap_or(Path::new("")).to_owned() };
    let mut known: BTreeMap<PathBuf, usize> = BTreeMap::new();
    let (mut jobs, mut buffer) = (Vec::new(), Vec::new());
    for number in 1usize.. {
        buffer.clear();
        let problem = |rule: String| {
            let help = "write a JSON object a line, as in {\"set\": {\"prism.index\": 1.5}}";
            Error::new(format!("{shown}:{number}"), rule, help)
        };
        let size = (&mut input).take(MAX_LINE).read_until(b'\n', &mut buffer).map_err(trouble)?;
        if size == 0 {
            break;
        }
        if size as u64 == MAX_LINE {
            return Err(problem(format!("the line has {MAX_LINE} bytes or more, and must have fewer")));
        }
        if buffer.trim_ascii().is_empty() {
            continue;
        }
        if jobs.len() == MOST_JOBS as usize {
            return Err(problem(format!("there are more than {MOST_JOBS} jobs, which is the limit")));
        }
        let request: JobRequest =
            serde_json::from_slice(&buffer).map_err(|error| problem(format!("the line is no job: {error}")))?;
        if request.id.as_ref().is_some_and(|id| id.is_empty() || id.len() > MAX_ID) {
            return Err(problem(format!("an `id` has 1 to {MAX_ID} bytes")));
        }
        let own = request.set.into_iter().map(|(key, value)| Override::of_value(&key, value));
        let own = own.collect::<Result<Vec<_>, _>>().map_err(problem)?;
        let scene = match request.scene {
            None if args.scene.is_some() => 0,
            None => return Err(problem("it names no `scene`, and the command none either".to_owned())),
            Some(path) => match known.get(&path) {
                Some(&known) => known,
                None if files::is_stdin(&path) => {
                    let rule = "its scene is to come from stdin, which a file of jobs cannot have".to_owned();
                    return Err(problem(rule));
                }
                None => {
                    scenes.push(BatchScene::read(&folder.join(&path))?);
                    known.insert(path, scenes.len() - 1);
                    scenes.len() - 1
                }
            },
        };
        jobs.push(ListedJob { id: request.id, scene, values: args.values.set.iter().cloned().chain(own).collect() });
    }
    if jobs.is_empty() {
        return Err(Error::new(&shown, "the file has no job", "write a JSON object a line"));
    }
    Ok(jobs)
}
