//! The arguments, as clap reads them.

use crate::accuracy::COARSEST_TARGET_PX;
use crate::scene::DESIGN_DEGREE;
use crate::scene::{DesignedSurface, Objective, Rear};
use crate::vision::BoardSize;
use clap::{Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// A virtual stereo camera: one camera that looks through a prism and so takes a stereo pair in one exposure.
///
/// Without a verb it runs `compare` on the design paper's scene and on that of the exact prism.
#[derive(Debug, Parser)]
#[command(name = "biprism", version)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub verb: Option<Verb>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Design, render, detect and measure: the flat prism of a scene against its freeform prism, and without a scene the exact
    /// one beside the design paper's.
    Compare(CompareArgs),
    /// Render the picture of a scene, with ground truth through the prism in the EXR and the NPY.
    Render(RenderArgs),
    /// Detect the corners of a checkerboard in both halves of any picture.
    Corners(CornersArgs),
    /// Measure the stereo pair in a picture: vertical disparity, epipolar lines, deviation from a pinhole.
    Measure(MeasureArgs),
    /// Design the freeform prism of a scene and write it as scene text and as point clouds.
    Design(DesignArgs),
    /// Check a scene without rendering it, and say what it holds.
    Check(CheckArgs),
    /// Trace given pixels to the board, or board points back to pixels, at full precision.
    Trace(TraceArgs),
    /// Study the program or an instrument.
    Analyse(AnalyseArgs),
    /// Measure what accuracy costs in time: every knob turned, against the reference, as table, JSON, CSV and charts.
    Cost(CostArgs),
    /// Compare scenes with their goldens: pictures, corners, residuals, fates and counts. UPDATE_GOLDEN=1 rewrites
    /// those that fail, --bless NAME one.
    Golden(GoldenArgs),
}

impl Verb {
    /// What is done without a verb.
    pub fn main_job() -> Self {
        Self::Compare(CompareArgs {
            scenes: Vec::new(),
            out: PathBuf::from("out"),
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

/// A target in px, within what a scene may ask for.
fn target_px(text: &str) -> Result<f64, String> {
    let target: f64 = text.parse().map_err(|_| "give a number of px, as in 0.01".to_owned())?;
    if target > 0.0 && target <= COARSEST_TARGET_PX {
        Ok(target)
    } else {
        Err(format!("give a number above 0, up to {COARSEST_TARGET_PX}"))
    }
}

/// A tolerance, finite and not below 0.
fn tolerance(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|value: &f64| value.is_finite() && *value >= 0.0);
    found.ok_or_else(|| "give a number from 0 on, as in 0.001".to_owned())
}

/// A finite number.
fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| "give a number, as in 1.5".to_owned())
}

/// A finite number above 0.
fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|value| *value > 0.0).ok_or_else(|| "give a number above 0, as in 1.5".to_owned())
}

/// Rays along a side of a grid.
fn grid(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| (2..=1001).contains(n)).ok_or_else(|| "give a whole number from 2 to 1001".to_owned())
}

/// A total degree of polynomials.
fn degree(text: &str) -> Result<usize, String> {
    let found = text.parse().ok().filter(|n| (1..=DESIGN_DEGREE).contains(n));
    found.ok_or_else(|| format!("give a whole number from 1 to {DESIGN_DEGREE}"))
}

/// A sine between 0 and 1.
fn numerical_aperture(text: &str) -> Result<f64, String> {
    positive(text)
        .ok()
        .filter(|value| *value < 1.0)
        .ok_or_else(|| "give a number between 0 and 1, as in 0.09".to_owned())
}

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
pub struct CompareArgs {
    /// Scene files, `-` is stdin; without any, the design paper's scene and that of the exact prism. Of one scene with a flat
    /// or a freeform prism both are compared; of several, up to eight, each scene's own prism.
    pub scenes: Vec<PathBuf>,
    /// Folder for the pictures, the report, cameras.yml for OpenCV, and corners.csv.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// No edge or corner of the board may lie farther than this from its true place, in px: the cheapest level of
    /// accuracy that promises it, instead of the scene's own.
    #[arg(long, value_parser = target_px)]
    pub target_px: Option<f64>,
    /// Also say where the error of each corner comes from (optics, fit, detector, effects, sampling), in the report and as
    /// budget.png; renders the scene's own board once more, with every pixel traced.
    #[arg(long)]
    pub budget: bool,
    /// Print the report as JSON instead of the table.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `render`.
#[derive(Debug, clap::Args)]
pub struct RenderArgs {
    /// Scene file; `-` is stdin.
    pub scene: PathBuf,
    /// File to write, its folder made if need be; may be given more than once: .png the picture, .exr the picture and what
    /// every pixel's centre sees, .npy that alone at full f64.
    #[arg(long, required = true)]
    pub out: Vec<PathBuf>,
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

/// What the surfaces of a freeform prism are to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ObjectiveArg {
    /// As in the design paper.
    March,
    /// Exactly horizontal epipolar lines.
    Epipolar,
    /// Exact pinholes whose axes are turned outwards.
    ToedIn,
    /// A pinhole each half, parallel to the camera.
    Pinhole,
    /// The camera's own pinhole, of a board at one depth.
    Depth,
}

impl From<ObjectiveArg> for Objective {
    fn from(arg: ObjectiveArg) -> Self {
        match arg {
            ObjectiveArg::March => Self::March,
            ObjectiveArg::Epipolar => Self::Epipolar,
            ObjectiveArg::ToedIn => Self::ToedIn,
            ObjectiveArg::Pinhole => Self::Pinhole,
            ObjectiveArg::Depth => Self::Depth,
        }
    }
}

/// What a design becomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SurfaceArg {
    /// Polynomials.
    Polynomial,
    /// Surfaces of revolution.
    Revolved,
}

impl From<SurfaceArg> for DesignedSurface {
    fn from(arg: SurfaceArg) -> Self {
        match arg {
            SurfaceArg::Polynomial => Self::Polynomial,
            SurfaceArg::Revolved => Self::Revolved,
        }
    }
}

/// The surface of a designed prism that faces the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum RearArg {
    /// A freeform of its own for each half.
    Own,
    /// One freeform for both halves.
    Even,
    /// A plane.
    Flat,
}

impl From<RearArg> for Rear {
    fn from(arg: RearArg) -> Self {
        match arg {
            RearArg::Own => Self::Own,
            RearArg::Even => Self::Even,
            RearArg::Flat => Self::Flat,
        }
    }
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
    /// How its values become light.
    #[command(flatten)]
    pub curve: CurveArgs,
    /// The picture was rendered from this very scene: compare with the exact corners too.
    #[arg(long)]
    pub own: bool,
    /// Also say where the error of each corner comes from: optics, fit, detector, effects, sampling.
    #[arg(long, requires = "own")]
    pub budget: bool,
    /// Print the report as JSON instead of the table.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `design`.
#[derive(Debug, clap::Args)]
pub struct DesignArgs {
    /// Scene file with a flat or freeform prism; `-` is stdin.
    pub scene: PathBuf,
    /// Folder for prism.toml, cloud.csv, front.ply and back.ply; of surfaces of revolution also prism_polynomial.toml, with the
    /// polynomials that are fitted to them.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// What the surfaces are to be, instead of the scene's own: `march` as in the design paper, `epipolar` for exactly horizontal
    /// epipolar lines, `toed-in` for exact pinholes whose axes are turned outwards, `pinhole` for a parallel one, `depth` for one at
    /// one depth.
    #[arg(long)]
    pub objective: Option<ObjectiveArg>,
    /// The surface that faces the board, instead of the scene's own: `own` for each half, `even` one for both, or `flat`.
    #[arg(long)]
    pub rear: Option<RearArg>,
    /// Total degree of the polynomials, instead of the scene's own.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=DESIGN_DEGREE as u64))]
    pub degree: Option<u64>,
    /// What the design becomes, instead of what the scene says: polynomials, or its surfaces of revolution themselves.
    #[arg(long)]
    pub surface: Option<SurfaceArg>,
    /// Also write the prism as one watertight body, .stl or .ply, in cells of 1/128 of a half's width. Read back as `body` it is the
    /// same prism to 2e-4 px RMS from PLY, and to 0.1 px from STL, whose numbers are f32, of the design paper's camera; beside the
    /// ridge, where two backs that meet at less than 1 deg are taken for one, to the width of two cells.
    #[arg(long, value_name = "FILE")]
    pub solid: Option<PathBuf>,
    /// March the centre column first, then every row.
    #[arg(long)]
    pub y_then_x: bool,
    /// File to draw the design into, .png or .svg: its profile, the sag of both surfaces and how far they depart from planes, and
    /// what it leaves of its law.
    #[arg(long, value_name = "FILE")]
    pub figure: Option<PathBuf>,
    /// Print the figures of the design as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct CheckArgs {
    /// Scene file; `-` is stdin.
    pub scene: PathBuf,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `analyse`.
#[derive(Debug, clap::Args)]
pub struct AnalyseArgs {
    /// What to study.
    #[command(subcommand)]
    pub study: Study,
}

/// A study.
#[derive(Debug, Subcommand)]
pub enum Study {
    /// Run the catalogue of hard cases: error against an independent oracle, fates, residual and time of each.
    Stability(StabilityArgs),
    /// The spot that an ideal lens behind the prism makes of the camera's pinhole, seen backwards through each half (the design
    /// paper's Fig. 7): through focus and over the field.
    Spot(RelayArgs),
    /// Where close neighbours of each pixel's ray meet it (the design paper's Fig. 8): tangential and sagittal foci, distortion.
    FieldCurvature(RelayArgs),
    /// The contrast of sinusoidal patterns through the prism and an ideal lens (the design paper's Fig. 9): by diffraction and by
    /// rays, over frequency, through focus and over the field.
    Mtf(RelayArgs),
    /// Where the rays behind the prism pierce a plane, less where those of the virtual camera would (the design paper's Table 1 and
    /// Fig. 5).
    Reprojection(ReprojectionArgs),
    /// How far from the virtual camera's centre the rays of the designed prism meet its axis, over the step of the design (the design
    /// paper's Fig. 4b), with the time of each.
    Convergence(ConvergenceArgs),
    /// Draw the instrument to scale, from above and from the side, with traced rays of both halves (the design paper's Fig. 6).
    Layout(PrismsArgs),
}

/// Arguments of `analyse reprojection`.
#[derive(Debug, clap::Args)]
pub struct ReprojectionArgs {
    /// The prisms.
    #[command(flatten)]
    pub prisms: PrismsArgs,
    /// Rays along each side of the grid over the half image, borders included.
    #[arg(long, default_value_t = 33, value_parser = grid)]
    pub grid: usize,
    /// Also in the plane this far beyond the virtual camera, in mm; may be given more than once.
    #[arg(long, value_parser = positive, value_name = "MM")]
    pub depth_mm: Vec<f64>,
}

/// Arguments of `analyse convergence`.
#[derive(Debug, clap::Args)]
pub struct ConvergenceArgs {
    /// Scene file with a freeform prism, `-` is stdin; without it, the design paper's scene.
    pub scene: Option<PathBuf>,
    /// Degree of the fitted polynomials; may be given more than once.
    #[arg(long, default_values_t = [5, 9], value_parser = degree)]
    pub degree: Vec<usize>,
    /// The longest step on the sensor, in um; every other is half the one before.
    #[arg(long, default_value_t = 91.03448275862068, value_parser = positive, value_name = "UM")]
    pub coarsest_um: f64,
    /// The shortest step, in um.
    #[arg(long, default_value_t = 1.0, value_parser = positive, value_name = "UM")]
    pub finest_um: f64,
    /// Folder for the figure as PNG and SVG, the JSON and the CSV.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// Print the JSON instead of the table.
    #[arg(long)]
    pub json: bool,
}

/// What the studies of prisms have in common.
#[derive(Debug, clap::Args)]
pub struct PrismsArgs {
    /// Scene files, `-` is stdin; without any, the design paper's scene. Of one scene with a flat or a freeform prism both are
    /// studied; of several, up to eight, each scene's own prism.
    pub scenes: Vec<PathBuf>,
    /// Folder for the figures as PNG and SVG, the JSON and a CSV a table.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// Print the JSON instead of the tables.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `analyse spot`, `field-curvature` and `mtf`.
#[derive(Debug, clap::Args)]
pub struct RelayArgs {
    /// The prisms.
    #[command(flatten)]
    pub prisms: PrismsArgs,
    /// Numerical aperture of the lens on the side of the prism.
    #[arg(long, default_value_t = 0.09, value_parser = numerical_aperture)]
    pub na: f64,
    /// Magnification of the lens.
    #[arg(long, default_value_t = 0.55, value_parser = positive)]
    pub magnification: f64,
    /// Wavelength in vacuum, in nm: of the diffraction. The glass keeps the index of the scene.
    #[arg(long, default_value_t = 486.1327, value_parser = positive, value_name = "NM")]
    pub wavelength_nm: f64,
    /// z of the plane in focus, in mm in the world; without it, the plane of the virtual camera's centre.
    #[arg(long, allow_hyphen_values = true, value_parser = finite, value_name = "MM")]
    pub focus_mm: Option<f64>,
    /// How far beyond the camera's pinhole along +z the object is, in mm.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true, value_parser = finite, value_name = "MM")]
    pub object_mm: f64,
    /// How far beside it the points of the field are, in mm.
    #[arg(long, default_value_t = 1.0, value_parser = positive, value_name = "MM")]
    pub field_mm: f64,
}

/// Arguments of `analyse stability`.
#[derive(Debug, clap::Args)]
pub struct StabilityArgs {
    /// Only the cases whose name or chapter has this word in it.
    #[arg(long)]
    pub only: Option<String>,
    /// Print JSON, with what is hard and where each bound comes from.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `cost`.
#[derive(Debug, clap::Args)]
pub struct CostArgs {
    /// Scene file, `-` is stdin; without it, the design paper's scene.
    pub scene: Option<PathBuf>,
    /// Folder for cost.json, cost.csv, cost.png, cost.svg and, of a designed prism, cost_design.png and .svg.
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
    /// CSV of pixel positions `x_px,y_px`, or with --back of `side,u_mm,v_mm` (left or right); `-` is stdin.
    #[arg(long, default_value = "-")]
    pub points: PathBuf,
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
