//! The arguments of `new`.

use crate::design::starter::StarterPrism;
use clap::ValueEnum;
use std::path::PathBuf;

/// The prism of a scene to begin with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PrismArg {
    /// Designed for exactly horizontal epipolar lines.
    Exact,
    /// The design paper's freeform prism.
    Freeform,
    /// Flat facets.
    Flat,
    /// No glass.
    None,
}

impl From<PrismArg> for StarterPrism {
    fn from(arg: PrismArg) -> Self {
        match arg {
            PrismArg::Exact => Self::Exact,
            PrismArg::Freeform => Self::Freeform,
            PrismArg::Flat => Self::Flat,
            PrismArg::None => Self::None,
        }
    }
}

/// A length or a size above 0.
fn above_zero(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|value: &f64| value.is_finite() && *value > 0.0);
    found.ok_or_else(|| "give a number above 0, as in 35".to_owned())
}

/// Arguments of `new`.
#[derive(Debug, clap::Args)]
pub struct NewArgs {
    /// The file to be written, which must not be there yet; `-` is stdout.
    pub path: PathBuf,
    /// Ask for what no flag gives, on a terminal or through stdin; an empty line takes what is proposed.
    #[arg(long)]
    pub ask: bool,
    /// Columns of the sensor.
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=65536))]
    pub width_px: Option<u32>,
    /// Rows of the sensor.
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=65536))]
    pub height_px: Option<u32>,
    /// Pixel pitch, in um.
    #[arg(long, value_parser = above_zero, allow_negative_numbers = true)]
    pub pixel_um: Option<f64>,
    /// Focal length of the lens, in mm.
    #[arg(long, value_parser = above_zero, allow_negative_numbers = true)]
    pub focal_mm: Option<f64>,
    /// Distance of the board, in mm: the middle of the depths that matter.
    #[arg(long, value_parser = above_zero, allow_negative_numbers = true)]
    pub distance_mm: Option<f64>,
    /// The prism.
    #[arg(long)]
    pub prism: Option<PrismArg>,
    /// Refractive index of its glass.
    #[arg(long, value_parser = above_zero, allow_negative_numbers = true)]
    pub index: Option<f64>,
    /// Distance of its ridge from the camera, in mm.
    #[arg(long, value_parser = above_zero, allow_negative_numbers = true)]
    pub ridge_mm: Option<f64>,
}
