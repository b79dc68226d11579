//! The arguments of `rectify`.

use super::prisms_args::depth_mm;
use super::set_args::SetArgs;
use std::path::PathBuf;

/// Arguments of `rectify`.
#[derive(Debug, clap::Args)]
pub struct RectifyArgs {
    /// Scene file; `-` is stdin.
    pub scene: PathBuf,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// Folder for maps.exr, left_x.npy, left_y.npy, right_x.npy, right_y.npy, stereo.yml and rectify.json.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// Depth from the camera at which the maps are right, in mm; without it, that of the middle of the scene's board. Where all
    /// rays of a half meet in one point they are right at every depth.
    #[arg(long, value_parser = depth_mm, value_name = "MM")]
    pub depth_mm: Option<f64>,
    /// Depths from the camera at which is told what the maps leave, in mm.
    #[arg(
        long, value_parser = depth_mm, value_delimiter = ',', value_name = "MM,..",
        default_values_t = [600.0, 1000.0, 2000.0, 10_000.0]
    )]
    pub residuals_at_mm: Vec<f64>,
    /// Print rectify.json instead of the table.
    #[arg(long)]
    pub json: bool,
}
