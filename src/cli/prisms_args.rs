//! The arguments that studies have in common: prisms and the relay lens.

use super::set_args::SetArgs;
use crate::error::Error;
use std::path::PathBuf;

/// A finite number.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| "give a number, as in 1.5".to_owned())
}

/// A finite number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|value| *value > 0.0).ok_or_else(|| "give a number above 0, as in 1.5".to_owned())
}

/// Farthest plane that a map or a residual is taken at, in mm: up to there positions in it are found to 1e-6 px.
const FARTHEST_MM: f64 = 1e6;

/// A depth in mm.
pub(super) fn depth_mm(text: &str) -> Result<f64, String> {
    positive(text)
        .ok()
        .filter(|depth| *depth <= FARTHEST_MM)
        .ok_or_else(|| format!("give a depth in mm above 0, up to {FARTHEST_MM:e}, as in 1000"))
}

/// Depths that are asked for at once, at most.
const MOST_DEPTHS: usize = 64;

/// What is wrong with so many depths after the flag `name`, if anything.
pub(super) fn few_depths(name: &str, depths_mm: &[f64]) -> Result<(), Error> {
    if depths_mm.len() <= MOST_DEPTHS {
        return Ok(());
    }
    let rule = format!("there are {} depths, and at most {MOST_DEPTHS} are taken at once", depths_mm.len());
    Err(Error::new(name, rule, "ask for fewer at a time"))
}

/// A sine between 0 and 1.
fn numerical_aperture(text: &str) -> Result<f64, String> {
    positive(text)
        .ok()
        .filter(|value| *value < 1.0)
        .ok_or_else(|| "give a number between 0 and 1, as in 0.09".to_owned())
}

/// What the studies of prisms have in common.
#[derive(Debug, clap::Args)]
pub struct PrismsArgs {
    /// Scene files, `-` is stdin; without any, the design paper's scene. Of one scene with a flat or a freeform prism both are
    /// studied; of several, up to eight, each scene's own prism.
    pub scenes: Vec<PathBuf>,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// Folder for the figures as PNG and SVG, the JSON and a CSV a table.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// Print the JSON instead of the tables.
    #[arg(long)]
    pub json: bool,
}

/// The ideal lens behind the prism.
#[derive(Debug, clap::Args)]
pub struct LensArgs {
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
}
