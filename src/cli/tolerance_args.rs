//! The arguments of `analyse tolerance` and of `merge`.

use super::prisms_args::{LensArgs, PrismsArgs, positive};
use crate::analysis::tolerance::operand::Operand;
use crate::analysis::tolerance::probe::Criterion;
use crate::analysis::tolerance::sensitivity::Budgeted;
use clap::ValueEnum;
use std::path::PathBuf;

/// The most trials of a run.
const MOST_TRIALS: u32 = 1_000_000;
/// The most parts of a run.
const MOST_SHARDS: u32 = 10_000;

/// Arguments of `analyse tolerance`.
#[derive(Debug, clap::Args)]
pub struct ToleranceArgs {
    /// The prisms.
    #[command(flatten)]
    pub prisms: PrismsArgs,
    /// The relay lens of the spots.
    #[command(flatten)]
    pub lens: LensArgs,
    /// Only this error, and how large it is tried, in its unit: "TEDX 2=0.1"; may be given more than once. Without it all, each as
    /// large as in the design paper's Table 2, or as a workshop keeps to without effort: an index of 1e-3, 1 arcmin.
    #[arg(long, value_parser = operand, value_name = "NAME=AMOUNT")]
    pub operand: Vec<(Operand, f64)>,
    /// Only this criterion: spot_um and best_spot_um (the relay lens' spot, focused as without errors, and anew), vertical_px,
    /// pinhole_px; may be given more than once.
    #[arg(long, value_parser = criterion)]
    pub criterion: Vec<Criterion>,
    /// What a criterion may become: "vertical_px=0.1"; may be given once a criterion. How large each error may be, or the yield of
    /// trials, is then told as well.
    #[arg(long, value_parser = budget, value_name = "CRITERION=MOST")]
    pub budget: Vec<Budgeted>,
    /// Prisms with all errors at once, drawn at random, instead of one error at a time.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_TRIALS)), value_name = "N")]
    pub trials: Option<u32>,
    /// How an error is drawn for a trial: normal with its amount as two standard deviations, or uniform between minus and plus it.
    #[arg(long, value_enum, default_value_t = DistributionArg::Normal, requires = "trials")]
    pub distribution: DistributionArg,
    /// Of the random numbers of the trials.
    #[arg(long, default_value_t = 1, requires = "trials")]
    pub seed: u64,
    /// Only the i-th of n equal parts of the trials, as in 2/8; `biprism merge` makes one of their files.
    #[arg(long, value_parser = shard, value_name = "I/N", requires = "trials")]
    pub shard: Option<[u32; 2]>,
}

/// Arguments of `merge`.
#[derive(Debug, clap::Args)]
pub struct MergeArgs {
    /// The files of all parts of one run: `tolerance_trials_*.jsonl` of `analyse tolerance --trials`, or those of `batch`.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Of a batch: also draw this figure over the keys that vary, as a chart of lines or a map, as PNG and SVG; may be given more than
    /// once.
    #[arg(long, value_name = "PATH")]
    pub figure: Vec<String>,
    /// Of a batch: the key, or the two keys, that figures are drawn over.
    #[arg(long, value_name = "KEY", requires = "figure")]
    pub over: Vec<String>,
    /// Of trials: what a criterion may become, for the yield: "vertical_px=0.1"; may be given once a criterion.
    #[arg(long, value_parser = budget, value_name = "CRITERION=MOST")]
    pub budget: Vec<Budgeted>,
    /// Folder for one file of all parts, and figures as PNG and SVG; of trials also the JSON and a CSV a table.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// Print the JSON instead of the tables.
    #[arg(long)]
    pub json: bool,
}

/// How an error is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DistributionArg {
    /// Normal, its amount two standard deviations.
    Normal,
    /// Uniform between minus and plus its amount.
    Uniform,
}

fn operand(text: &str) -> Result<(Operand, f64), String> {
    let (name, amount) = text.rsplit_once('=').ok_or("give a name and an amount, as in \"TEDX 2=0.1\"")?;
    let found = Operand::named(name.trim()).ok_or_else(|| {
        format!("no error is called {name:?}; there are {}", Operand::ALL.map(Operand::name).join(", "))
    })?;
    Ok((found, positive(amount.trim())?))
}

fn criterion(text: &str) -> Result<Criterion, String> {
    let known =
        || format!("no criterion is called {text:?}; there are {}", Criterion::ALL.map(Criterion::key).join(", "));
    Criterion::named(text.trim()).ok_or_else(known)
}

fn budget(text: &str) -> Result<Budgeted, String> {
    let (name, most) = text.rsplit_once('=').ok_or("give a criterion and its most, as in vertical_px=0.1")?;
    Ok(Budgeted { criterion: criterion(name)?, most: positive(most.trim())? })
}

/// A part of a run.
pub(super) fn shard(text: &str) -> Result<[u32; 2], String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some([i.parse().ok()?, n.parse().ok()?]));
    let fits = |[i, n]: &[u32; 2]| (1..=*n).contains(i) && *n <= MOST_SHARDS;
    numbers.filter(fits).ok_or_else(|| format!("give a part of up to {MOST_SHARDS}, as in 2/8"))
}
