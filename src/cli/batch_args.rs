//! The arguments of `batch`.

use super::set_args::SetArgs;
use super::tolerance_args::shard;
use crate::scene::Sweep;
use std::path::PathBuf;

/// Arguments of `batch`.
#[derive(Debug, clap::Args)]
pub struct BatchArgs {
    /// Scene file, `-` is stdin; may be left out where each line of --jobs names its own.
    #[arg(required_unless_present = "jobs")]
    pub scene: Option<PathBuf>,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// What is done with each scene: `compare`, `render`, `design`, `analyse spot`, `field-curvature`, `mtf`, `reprojection`, `surface` or
    /// `stereo`, with options of theirs, as in "compare --target-px 0.01". Nothing but the lines is written, and pictures where --pictures asks for them.
    #[arg(long, value_name = "VERB")]
    pub verb: String,
    /// Values that a key takes: A:B:N for N values from A to B, both among them, or a list, as in prism.index=1.46:1.5:6 or
    /// prism.glass=N-BK7,N-SF11; of several every combination is a job, the last one changing first.
    #[arg(long, value_name = "KEY=VALUES", value_parser = Sweep::of_words, conflicts_with = "jobs")]
    pub sweep: Vec<Sweep>,
    /// File of jobs instead, `-` is stdin: a JSON object a line, with `set` (values by their keys), and where it is wanted `id` (its own
    /// word) and `scene` (a file, relative to this one). A run has up to a million jobs.
    #[arg(long, value_name = "JSONL")]
    pub jobs: Option<PathBuf>,
    /// Only the i-th of n parts of the jobs, as in 2/8: those of the numbers i-1, i-1+n, ..; `biprism merge` makes one of their files.
    #[arg(long, value_parser = shard, value_name = "I/N")]
    pub shard: Option<[u32; 2]>,
    /// Only the figures at this path and below it, as in flat/stereo; may be given more than once. Without it all.
    #[arg(long, value_name = "PATH")]
    pub figure: Vec<String>,
    /// File for the lines, one a job. Jobs that it has are not done again. Without it out/batch.jsonl, of a shard out/batch_2_of_8.jsonl.
    #[arg(long, value_name = "JSONL")]
    pub out: Option<PathBuf>,
    /// Folder for the picture of each job of the verb `render`, a PNG called by the job's number; each is there before its line is.
    #[arg(long, value_name = "FOLDER")]
    pub pictures: Option<PathBuf>,
    /// Print what was done as JSON.
    #[arg(long)]
    pub json: bool,
}
