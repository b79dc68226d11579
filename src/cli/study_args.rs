//! The arguments of `analyse`.

use super::examples;
use super::prisms_args::{LensArgs, PrismsArgs, depth_mm, finite, positive};
use super::set_args::SetArgs;
use super::tolerance_args::ToleranceArgs;
use crate::scene::DESIGN_DEGREE;
use clap::Subcommand;
use std::path::PathBuf;

/// The longest step of the design paper's Fig. 4(b) on the sensor, in um: 29 to half the width of a half image.
pub(super) const PAPER_STEP_UM: f64 = 91.034_482_758_620_68;

/// Rays along a side of a grid.
fn grid(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| (2..=1001).contains(n)).ok_or_else(|| "give a whole number from 2 to 1001".to_owned())
}

/// A total degree of polynomials.
fn degree(text: &str) -> Result<usize, String> {
    let found = text.parse().ok().filter(|n| (1..=DESIGN_DEGREE).contains(n));
    found.ok_or_else(|| format!("give a whole number from 1 to {DESIGN_DEGREE}"))
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
    #[command(after_help = examples::STABILITY)]
    Stability(StabilityArgs),
    /// The spot that an ideal lens behind the prism makes of the camera's pinhole, seen backwards through each half (the design
    /// paper's Fig. 7): through focus and over the field.
    #[command(after_help = examples::SPOT)]
    Spot(RelayArgs),
    /// Where close neighbours of each pixel's ray meet it (the design paper's Fig. 8): tangential and sagittal foci, distortion.
    #[command(after_help = examples::FIELD_CURVATURE)]
    FieldCurvature(RelayArgs),
    /// The contrast of sinusoidal patterns through the prism and an ideal lens (the design paper's Fig. 9): by diffraction and by
    /// rays, over frequency, through focus and over the field.
    #[command(after_help = examples::MTF)]
    Mtf(RelayArgs),
    /// Where the rays behind the prism pierce a plane, less where those of the virtual camera would (the design paper's Table 1 and
    /// Fig. 5).
    #[command(after_help = examples::REPROJECTION)]
    Reprojection(ReprojectionArgs),
    /// How far from the virtual camera's centre the rays of the designed prism meet its axis, over the step of the design (the design
    /// paper's Fig. 4b), with the time of each.
    #[command(after_help = examples::CONVERGENCE)]
    Convergence(ConvergenceArgs),
    /// What each error of making the prism costs (the design paper's Table 2), one by one, how large it may be, or by trials with all
    /// of them at once: in spots, vertical disparity and deviation from a pinhole.
    #[command(after_help = examples::TOLERANCE)]
    Tolerance(ToleranceArgs),
    /// Sag, departure, slope and curvature of both surfaces of each prism, and what polynomials leave of the points that they are
    /// fitted to, over the degree (the design paper's Fig. 4a).
    #[command(after_help = examples::SURFACE)]
    Surface(PrismsArgs),
    /// All figures and tables of the design paper on its own instrument: what it says, what is found, and what can be said of each, as
    /// one page of HTML with the figures in it.
    #[command(after_help = examples::PAPER)]
    Paper(PaperArgs),
    /// What is left for stereo of the halves as they are, after one warp a half (the rival in software), after the maps of `biprism
    /// rectify` and, of the exact prism, after its row shift: residuals, and the error of depth of a perfect matcher, at several
    /// depths and on a tilted board. Of one scene with a flat or a freeform prism the exact one of the same glass is studied too.
    #[command(after_help = examples::STEREO)]
    Stereo(StereoArgs),
    /// Draw the instrument to scale, from above and from the side, with traced rays of both halves (the design paper's Fig. 6).
    #[command(after_help = examples::LAYOUT)]
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

/// A turn of less than a right angle, in degrees.
fn tilt(text: &str) -> Result<f64, String> {
    finite(text)
        .ok()
        .filter(|turn| turn.abs() <= 80.0)
        .ok_or_else(|| "give an angle from -80 to 80, as in 55".to_owned())
}

/// Arguments of `analyse stereo`.
#[derive(Debug, clap::Args)]
pub struct StereoArgs {
    /// The prisms.
    #[command(flatten)]
    pub prisms: PrismsArgs,
    /// Depths from the camera at which points are matched, in mm.
    #[arg(
        long, value_parser = depth_mm, value_delimiter = ',', value_name = "MM,..",
        default_values_t = [600.0, 1000.0, 2000.0]
    )]
    pub depths_mm: Vec<f64>,
    /// The depth at which warps and maps are right, in mm; the tilted board stands there.
    #[arg(long, default_value_t = 1000.0, value_parser = depth_mm, value_name = "MM")]
    pub fit_depth_mm: f64,
    /// The turn of a tilted board about the vertical, in degrees; 0 for none.
    #[arg(long, default_value_t = 55.0, allow_hyphen_values = true, value_parser = tilt, value_name = "DEG")]
    pub tilt_deg: f64,
    /// Total degree of the warps.
    #[arg(long, default_value_t = 5, value_parser = degree)]
    pub degree: usize,
    /// Points along each edge of the left half.
    #[arg(long, default_value_t = 65, value_parser = grid)]
    pub grid: usize,
}

/// Arguments of `analyse convergence`.
#[derive(Debug, clap::Args)]
pub struct ConvergenceArgs {
    /// Scene file with a freeform prism, `-` is stdin; without it, the design paper's scene.
    pub scene: Option<PathBuf>,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// Degree of the fitted polynomials; may be given more than once.
    #[arg(long, default_values_t = [5, 9], value_parser = degree)]
    pub degree: Vec<usize>,
    /// The longest step on the sensor, in um; every other is half the one before.
    #[arg(long, default_value_t = PAPER_STEP_UM, value_parser = positive, value_name = "UM")]
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

/// Arguments of `analyse paper`.
#[derive(Debug, clap::Args)]
pub struct PaperArgs {
    /// Folder for `paper.html`, the figures by themselves as PNG and SVG, the JSON and the CSV.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// The shortest step of Fig. 4(b), in um.
    #[arg(long, default_value_t = 1.0, value_parser = positive, value_name = "UM")]
    pub finest_um: f64,
    /// Print the JSON instead of the table.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `analyse spot`, `field-curvature` and `mtf`.
#[derive(Debug, clap::Args)]
pub struct RelayArgs {
    /// The prisms.
    #[command(flatten)]
    pub prisms: PrismsArgs,
    /// The lens.
    #[command(flatten)]
    pub lens: LensArgs,
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
