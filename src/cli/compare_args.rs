//! The arguments of `compare`.

use super::set_args::SetArgs;
use crate::accuracy::COARSEST_TARGET_PX;
use clap::ValueEnum;
use std::path::PathBuf;

/// A target in px, within what a scene may ask for.
pub(super) fn target_px(text: &str) -> Result<f64, String> {
    let target: f64 = text.parse().map_err(|_| "give a number of px, as in 0.01".to_owned())?;
    if target > 0.0 && target <= COARSEST_TARGET_PX {
        Ok(target)
    } else {
        Err(format!("give a number above 0, up to {COARSEST_TARGET_PX}"))
    }
}

/// The pictures of a comparison that are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PicturesArg {
    /// None, and no figures: the numbers alone.
    None,
    /// PNG, with the figures and the page.
    Png,
    /// EXR with what every pixel sees, too.
    All,
}

impl PicturesArg {
    /// The endings of the picture of each prism.
    pub(super) fn endings(self) -> &'static [&'static str] {
        match self {
            Self::None => &[],
            Self::Png => &["png"],
            Self::All => &["png", "exr"],
        }
    }
}

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
pub struct CompareArgs {
    /// Scene files, `-` is stdin; without any, the design paper's scene and that of the exact prism. Of one scene with a flat
    /// or a freeform prism both are compared; of several, up to eight, each scene's own prism.
    pub scenes: Vec<PathBuf>,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// Folder for the pictures, the report as JSON and as a page to look into, cameras.yml for OpenCV, and corners.csv.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// The pictures that are written: `none`, so that report.json, cameras.yml and corners.csv are all; `png` of each prism, with the
    /// figures and the page; `all`, an EXR of each prism with what every pixel sees as well.
    #[arg(long, value_enum, default_value_t = PicturesArg::Png)]
    pub pictures: PicturesArg,
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
