//! The arguments of `dataset`.

use super::prisms_args::finite;
use super::set_args::SetArgs;
use crate::analysis::dataset::{BoardLook, DrawRange, InView};
use clap::ValueEnum;
use std::path::PathBuf;

/// The most pictures of a set.
pub(super) const MOST_POSES: u32 = 1_000_000;
/// The farthest board, in mm.
const FARTHEST_MM: f64 = 1e6;
/// The largest angle between the board's normal and +z, in deg: beyond it a board is seen on end.
const MOST_TILT_DEG: f64 = 85.0;
/// The largest noise, of full scale 1.
const MOST_NOISE: f64 = 10.0;
/// The largest factor on light.
const MOST_EXPOSURE: f64 = 1000.0;

/// A range within limits, as in 500:1500; one number is a range of that alone.
fn range(text: &str, [least, most]: [f64; 2]) -> Result<DrawRange, String> {
    let (low, high) = text.split_once(':').unwrap_or((text, text));
    let ends = finite(low.trim()).and_then(|low| Ok([low, finite(high.trim())?]));
    let fits = |[low, high]: &[f64; 2]| *low >= least && high >= low && *high <= most;
    ends.ok().filter(fits).map(|[low, high]| DrawRange { low, high }).ok_or_else(|| {
        format!("give LOW:HIGH, both from {least} to {most} and the lower one first, or one number for both")
    })
}

fn distance(text: &str) -> Result<DrawRange, String> {
    let within = [f64::MIN_POSITIVE, FARTHEST_MM];
    range(text, within).map_err(|_| format!("give LOW:HIGH in mm, above 0 and up to {FARTHEST_MM:e}, as in 500:1500"))
}

fn tilt(text: &str) -> Result<DrawRange, String> {
    range(text, [0.0, MOST_TILT_DEG])
}

fn roll(text: &str) -> Result<DrawRange, String> {
    range(text, [-360.0, 360.0])
}

fn noise(text: &str) -> Result<DrawRange, String> {
    range(text, [0.0, MOST_NOISE])
}

fn exposure(text: &str) -> Result<DrawRange, String> {
    range(text, [0.0, MOST_EXPOSURE])
}

/// Arguments of `dataset`.
#[derive(Debug, clap::Args)]
pub struct DatasetArgs {
    /// Scene file; `-` is stdin.
    pub scene: PathBuf,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// How many pictures the folder shall have, 0 to N-1. Picture i is the same whatever N is: a larger N adds to a folder.
    #[arg(
        long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_POSES)),
        required_unless_present = "pose_file"
    )]
    pub poses: Option<u32>,
    /// Places of the board instead, one a line: x_mm,y_mm,z_mm,tilt_x_deg,tilt_y_deg,tilt_z_deg, as `board.position_mm` and
    /// `board.tilt_deg` of a scene; `-` is stdin.
    #[arg(long, value_name = "CSV", conflicts_with_all = ["poses", "distance_mm", "tilt_deg", "roll_deg", "in_view"])]
    pub pose_file: Option<PathBuf>,
    /// Of the random numbers.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for manifest.jsonl, cameras.yml and, of each picture, its PNG, its scene and its corners.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// Distance of the board's middle from the camera along +z, in mm; without it 0.7 to 1.5 times that of the scene's board.
    #[arg(long, value_name = "LOW:HIGH", value_parser = distance)]
    pub distance_mm: Option<DrawRange>,
    /// Angle between the board's normal and +z, in deg, in any direction.
    #[arg(long, value_name = "LOW:HIGH", value_parser = tilt, default_value = "0:40")]
    pub tilt_deg: DrawRange,
    /// Turn of the board about its normal before it is tilted, in deg.
    #[arg(long, value_name = "LOW:HIGH", value_parser = roll, default_value = "-30:30", allow_hyphen_values = true)]
    pub roll_deg: DrawRange,
    /// What both halves must see of the board: its centre, so that the rest may be cut, or the whole of its squares.
    #[arg(long, value_enum, default_value_t = InViewArg::Centre)]
    pub in_view: InViewArg,
    /// What the board shows, one of these a picture; without it what the scene says.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LOOK,..")]
    pub texture: Vec<LookArg>,
    /// Standard deviation of noise on every pixel's light, of full scale 1: the read noise of the scene's sensor, or of one that does
    /// nothing else.
    #[arg(long, value_name = "LOW:HIGH", value_parser = noise)]
    pub noise: Option<DrawRange>,
    /// Factor on the light of the board and its background.
    #[arg(long, value_name = "LOW:HIGH", value_parser = exposure)]
    pub exposure: Option<DrawRange>,
    /// Write left and right half of each picture apart: 000000_left.png and 000000_right.png.
    #[arg(long)]
    pub halves: bool,
    /// Write of each picture an EXR of what is true of it, as `render --stereo` has it: depth, disparity, which halves see it.
    #[arg(long)]
    pub truth: bool,
    /// Write of each picture the corners that the detector finds, too.
    #[arg(long)]
    pub detect: bool,
    /// Print what was done as JSON.
    #[arg(long)]
    pub json: bool,
}

/// How much of the board both halves must see.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum InViewArg {
    /// Its centre.
    Centre,
    /// All of its squares.
    Whole,
}

impl From<InViewArg> for InView {
    fn from(arg: InViewArg) -> Self {
        match arg {
            InViewArg::Centre => Self::Centre,
            InViewArg::Whole => Self::Whole,
        }
    }
}

/// What a board shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LookArg {
    /// Its squares.
    Squares,
    /// Noise: the scene's own, or one named by the seed.
    Noise,
    /// Siemens stars and slanted squares.
    Chart,
}

impl From<LookArg> for BoardLook {
    fn from(arg: LookArg) -> Self {
        match arg {
            LookArg::Squares => Self::Squares,
            LookArg::Noise => Self::Noise,
            LookArg::Chart => Self::Chart,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_within_their_limits() {
        let ends = |text: &str| tilt(text).ok().map(|range| [range.low, range.high]);
        assert_eq!(ends("0:40"), Some([0.0, 40.0]));
        assert_eq!(ends(" 5 "), Some([5.0, 5.0]));
        assert_eq!(roll("-30:-10").map(|range| [range.low, range.high]), Ok([-30.0, -10.0]));
        for wrong in ["", ":", "40:0", "-1:4", "0:86", "a:b", "nan", "1:inf", "1:2:3"] {
            assert_eq!(ends(wrong), None, "{wrong:?}");
        }
        assert!(distance("0:100").is_err() && distance("100:1e6").is_ok() && exposure("0:1001").is_err());
    }
}
