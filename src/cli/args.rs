//! The arguments, as clap reads them.

use super::batch_args::BatchArgs;
use super::build_facts::LONG_VERSION;
use super::compare_args::{CompareArgs, PicturesArg, target_px};
use super::dataset_args::DatasetArgs;
use super::design_args::DesignArgs;
use super::examples;
use super::export_args::ExportArgs;
use super::new_args::NewArgs;
use super::rectify_args::RectifyArgs;
use super::set_args::SetArgs;
use super::shell_args::{CompletionsArgs, ManArgs};
use super::study_args::AnalyseArgs;
use super::tolerance_args::MergeArgs;
use crate::vision::BoardSize;
use clap::{Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Threads that pictures are made by, at most: more than any machine's processors gain nothing and cost memory each.
pub(super) const MOST_THREADS: usize = 256;

/// A virtual stereo camera: one camera that looks through a prism and so takes a stereo pair in one exposure.
///
/// Without a verb it runs `compare` on the design paper's scene and on that of the exact prism.
#[derive(Debug, Parser)]
#[command(name = "biprism", version, long_version = LONG_VERSION.as_str(), after_help = examples::MAIN)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub verb: Option<Verb>,
    /// How much is said on stderr, and in which colours.
    #[command(flatten)]
    pub words: WordsArgs,
    /// Threads to work with, instead of RAYON_NUM_THREADS or as many as there are processors; results are the same to the last bit.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS as i64))]
    pub threads: Option<u16>,
}

/// How much is said on stderr, and in which colours.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct WordsArgs {
    /// Say nothing on stderr but errors and why the exit code is 1.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say on stderr how long each stage took.
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// Colours of errors and of this help; `auto` has them on a terminal, unless `NO_COLOR` is set.
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    pub color: ColorArg,
}

/// When there are colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ColorArg {
    /// On a terminal.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Design, render, detect and measure: the flat prism of a scene against its freeform prism, and without a scene the exact
    /// one beside the design paper's.
    #[command(after_help = examples::COMPARE)]
    Compare(CompareArgs),
    /// Write a scene to begin with, from a sensor, a lens, a prism and a distance.
    #[command(after_help = examples::NEW)]
    New(NewArgs),
    /// Render the picture of a scene, with ground truth through the prism in the EXR and the NPY.
    #[command(after_help = examples::RENDER)]
    Render(RenderArgs),
    /// Detect the corners of a checkerboard in both halves of any picture.
    #[command(after_help = examples::CORNERS)]
    Corners(CornersArgs),
    /// Measure the stereo pair in a picture: vertical disparity, epipolar lines, deviation from a pinhole.
    #[command(after_help = examples::MEASURE)]
    Measure(MeasureArgs),
    /// Design the freeform prism of a scene and write it as scene text and as point clouds.
    #[command(after_help = examples::DESIGN)]
    Design(DesignArgs),
    /// Check a scene without rendering it, and say what it holds.
    #[command(after_help = examples::CHECK)]
    Check(CheckArgs),
    /// Trace given pixels to the board, or board points back to pixels, at full precision.
    #[command(after_help = examples::TRACE)]
    Trace(TraceArgs),
    /// Write the maps that make a rectified pair of the halves of a picture, for cv2.remap, with stereo.yml for OpenCV.
    #[command(after_help = examples::RECTIFY)]
    Rectify(RectifyArgs),
    /// Write the prism, its cameras or what its pixels see as files for other programs: CAD, optics programs, OpenCV, NumPy.
    #[command(after_help = examples::EXPORT)]
    Export(ExportArgs),
    /// Take many pictures of a scene's board at places drawn at random or listed, with the true corners of each, cameras.yml for
    /// OpenCV, and a manifest. A stopped run goes on where it was.
    #[command(after_help = examples::DATASET)]
    Dataset(DatasetArgs),
    /// Study the program or an instrument.
    #[command(after_help = examples::ANALYSE)]
    Analyse(AnalyseArgs),
    /// Do something with many scenes, a line of JSON a job: those of a sweep or of a file of jobs, or a part of them. A stopped run
    /// goes on where it was.
    #[command(after_help = examples::BATCH)]
    Batch(BatchArgs),
    /// Make one of the parts of a run on several machines, of `batch --shard` or of `analyse tolerance --trials --shard`, and draw a
    /// sweep.
    #[command(after_help = examples::MERGE)]
    Merge(MergeArgs),
    /// Measure what accuracy costs in time: every knob turned, against the reference, as table, JSON, CSV and charts.
    #[command(after_help = examples::COST)]
    Cost(CostArgs),
    /// Compare scenes with their goldens: pictures, corners, residuals, fates and counts. UPDATE_GOLDEN=1 rewrites
    /// those that fail, --bless NAME one.
    #[command(after_help = examples::GOLDEN)]
    Golden(GoldenArgs),
    /// Print what a shell needs to complete verbs and options.
    #[command(after_help = examples::COMPLETIONS)]
    Completions(CompletionsArgs),
    /// Print the page of the manual, or write the pages of all verbs.
    #[command(after_help = examples::MAN)]
    Man(ManArgs),
}

impl Verb {
    /// What is done without a verb.
    pub(crate) fn main_job() -> Self {
        Self::Compare(CompareArgs {
            scenes: Vec::new(),
            values: SetArgs::default(),
            out: PathBuf::from("out"),
            pictures: PicturesArg::Png,
            target_px: None,
            budget: false,
            json: false,
        })
    }
}

/// Inner corners of a board, as in 9x6.
fn board_size(text: &str) -> Result<BoardSize, String> {
    let [least, most] = BoardSize::LIMITS;
    let number = |digits: &str| digits.parse().ok().filter(|n: &i32| (least..=most).contains(n));
    let size = text.split_once(['x', 'X']).and_then(|(columns, rows)| Some([number(columns)?, number(rows)?]));
    size.map(|[columns, rows]| BoardSize { columns, rows })
        .ok_or_else(|| format!("give columns x rows of inner corners, each within {least} .. {most}, as in 9x6"))
}

/// A tolerance, finite and not below 0.
fn tolerance(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|value: &f64| value.is_finite() && *value >= 0.0);
    found.ok_or_else(|| "give a number from 0 on, as in 0.001".to_owned())
}

/// Arguments of `render`.
#[derive(Debug, clap::Args)]
pub struct RenderArgs {
    /// Scene file; `-` is stdin.
    pub scene: PathBuf,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// File to write, its folder made if need be; may be given more than once: .png the picture, .exr the picture and what
    /// every pixel's centre sees, .npy that alone at full f64.
    #[arg(long, required = true)]
    pub out: Vec<PathBuf>,
    /// Write into EXR and NPY what is true of the stereo pair as well: depth, distance, the pixel of the other half that sees the
    /// same point, disparity, and which halves see it; into EXR also each point in the world.
    #[arg(long)]
    pub stereo: bool,
    /// Write left and right half apart, each with its truth: of `--out a.png` the files `a_left.png` and `a_right.png`.
    #[arg(long)]
    pub halves: bool,
    /// No edge or corner of the board may lie farther than this from its true place, in px: the cheapest level of
    /// accuracy that promises it, instead of the scene's own.
    #[arg(long, value_parser = target_px)]
    pub target_px: Option<f64>,
    /// Print what was done as JSON.
    #[arg(long)]
    pub json: bool,
}

/// The transfer curve of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TransferArg {
    /// The file's own, and where it states none, the one under which the corners fit best.
    Auto,
    /// Value = radiance: most machine cameras, with gamma left at 1.
    Linear,
    /// The sRGB curve: a phone's or a photo camera's JPEG.
    Srgb,
}

/// How a picture's values become light.
#[derive(Debug, clap::Args)]
pub struct CurveArgs {
    /// Transfer curve, where the file does not state its own. Without it, or with `auto`: the file's, or else the one of linear,
    /// sRGB and a fitted power under which the corners fit best, which is told. Most machine cameras write linear values, phones
    /// and photo cameras sRGB. A curve that the file contradicts is refused.
    #[arg(long)]
    pub transfer: Option<TransferArg>,
    /// Take the stated curve even where the file states another.
    #[arg(long, requires = "transfer")]
    pub force_transfer: bool,
}

/// Arguments of `corners`.
#[derive(Debug, clap::Args)]
pub struct CornersArgs {
    /// Picture: PNG, EXR, TIFF, JPEG, BMP or PNM; or a corner file (.csv, .json, .yml) to be written in another format.
    pub picture: PathBuf,
    /// How its values become light.
    #[command(flatten)]
    pub curve: CurveArgs,
    /// The scene that says camera, prism and board of the picture; `-` is stdin. Corners are then numbered by the board's
    /// columns and rows, and those whose places it does not tell are left out and counted.
    #[arg(long)]
    pub scene: Option<PathBuf>,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// Take the whole picture as one view instead of two halves.
    #[arg(long, conflicts_with = "scene")]
    pub whole: bool,
    /// Columns x rows of the board's inner corners, as in 9x6, where they are known: of several boards that one is taken, corners
    /// that do not fit are turned down, and another size is told.
    #[arg(long, value_name = "9x6", value_parser = board_size, conflicts_with = "scene")]
    pub board: Option<BoardSize>,
    /// Give every board, not only that of most corners: the second of a view as `leftb`, the third as `leftc`.
    #[arg(long, conflicts_with_all = ["scene", "board"])]
    pub all_boards: bool,
    /// File to write instead of stdout: .csv, .json, or .yml for OpenCV (with its pixel centres at whole numbers).
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Print JSON instead of CSV on stdout; with --out, the counts of what was found and turned down.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `measure`.
#[derive(Debug, clap::Args)]
pub struct MeasureArgs {
    /// Picture: PNG, EXR, TIFF, JPEG, BMP or PNM; or a corner file (.csv, .json, .yml) with the views left and right, as
    /// `biprism corners` or another program wrote it.
    pub picture: PathBuf,
    /// The scene that says camera, prism and board of the picture; `-` is stdin.
    #[arg(long)]
    pub scene: PathBuf,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// How its values become light.
    #[command(flatten)]
    pub curve: CurveArgs,
    /// The picture was rendered from this very scene: compare with the exact corners too.
    #[arg(long)]
    pub own: bool,
    /// Also say where the error of each corner comes from: optics, fit, detector, effects, sampling.
    #[arg(long, requires = "own")]
    pub budget: bool,
    /// Also write a page of HTML to look into: the picture, its corners, epipolar lines and figures.
    #[arg(long)]
    pub page: Option<PathBuf>,
    /// Print the report as JSON instead of the table.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct CheckArgs {
    /// Scene file; `-` is stdin.
    pub scene: PathBuf,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `cost`.
#[derive(Debug, clap::Args)]
pub struct CostArgs {
    /// Scene file, `-` is stdin; without it, the design paper's scene.
    pub scene: Option<PathBuf>,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// Folder for cost.html, cost.json, cost.csv, cost.png, cost.svg, cost_mesh.png, cost_effects.png and, of a designed prism, cost_design.png, these as .svg too.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// How often each setting is timed, all of them in turn.
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub repetitions: u16,
    /// Fewer and cheaper settings: a first look, within a minute for the design paper's scene.
    #[arg(long)]
    pub quick: bool,
    /// Print cost.json instead of the table.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `trace`.
#[derive(Debug, clap::Args)]
pub struct TraceArgs {
    /// Scene file; `-` is stdin.
    pub scene: PathBuf,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// CSV of pixel positions `x_px,y_px`, or with --back of `side,u_mm,v_mm` (left or right); `-` is stdin. A name that ends in .npy is an
    /// array of f64 with a row for each point, the side as 0 or 1.
    #[arg(long, visible_alias = "in", default_value = "-")]
    pub points: PathBuf,
    /// Write a table of records into this .npy, in place of text.
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    pub out: Option<PathBuf>,
    /// From board points to the pixels that see them.
    #[arg(long)]
    pub back: bool,
    /// Trace in light of this wavelength in vacuum, in nm, whatever light the scene has; needs `prism.glass`.
    #[arg(long, value_name = "NM")]
    pub wavelength_nm: Option<f64>,
    /// Print JSON instead of CSV.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `golden`.
#[derive(Debug, clap::Args)]
pub struct GoldenArgs {
    /// Folder of the cases, *.toml; --only chooses among them.
    #[arg(default_value = "scenes/cases")]
    pub cases: PathBuf,
    /// Folder of their goldens.
    #[arg(long, default_value = "golden")]
    pub golden: PathBuf,
    /// Folder for what failing cases leave: a strip expected | difference | actual and a text.
    #[arg(long, default_value = "out/golden")]
    pub failures: PathBuf,
    /// Only this case of the folder, by its name without .toml; may be given more than once.
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Write the golden of this case anew where it differs, and look at no other; may be given more than once. Refused where
    /// CI is set.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["only", "tolerance_px", "tolerance_grey"])]
    pub bless: Vec<String>,
    /// How far corners and residuals may move beyond 1e-9 px (exact ones) and 1e-6 px (detected ones). Above 0, counts of work
    /// and of candidates that were turned down are not held.
    #[arg(long, value_name = "PX", default_value_t = 0.0, value_parser = tolerance)]
    pub tolerance_px: f64,
    /// How far a pixel may move beyond half a level of 16 bits, of full scale 1. Pictures with noise are judged by their
    /// noise, whatever is given here.
    #[arg(long, value_name = "GREY", default_value_t = 0.0, value_parser = tolerance)]
    pub tolerance_grey: f64,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}
