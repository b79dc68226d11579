//! The arguments of `design`.

use super::set_args::SetArgs;
use crate::scene::{DESIGN_DEGREE, DesignedSurface, Objective, Rear};
use clap::ValueEnum;
use std::path::PathBuf;

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

/// The points of a design as files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CloudArg {
    /// None.
    None,
    /// One table, cloud.csv: pixel, front point and back point in each line.
    Csv,
    /// A cloud of each surface, front.ply and back.ply.
    Ply,
}

/// Arguments of `design`.
#[derive(Debug, clap::Args)]
pub struct DesignArgs {
    /// Scene file with a flat or freeform prism; `-` is stdin.
    pub scene: PathBuf,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// Folder for prism.toml; of surfaces of revolution also prism_polynomial.toml, with the polynomials that are fitted to them.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// Write the points that the surfaces go through as well, 210 MB of a sensor of 2 Mpx at --step-px 1: `csv` into cloud.csv,
    /// `ply` into front.ply and back.ply, or both, as in `csv,ply`.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "FORMAT,..", default_value = "none")]
    pub cloud: Vec<CloudArg>,
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
    /// Also write the prism as one watertight body, .stl, .ply or .obj, in cells of 1/128 of a half's width. Read back as `body` it is the
    /// same prism to 2e-4 px RMS from PLY, and to 0.1 px from STL, whose numbers are f32, of the design paper's camera; beside the
    /// ridge, where two backs that meet at less than 1 deg are taken for one, to the width of two cells.
    #[arg(long, value_name = "FILE")]
    pub solid: Option<PathBuf>,
    /// March the centre column first, then every row.
    #[arg(long)]
    pub y_then_x: bool,
    /// Step of the grid and of the march, in px of the sensor, instead of the scene's own; 1 gives a point for every pixel.
    #[arg(long)]
    pub step_px: Option<f64>,
    /// File to draw the design into, .png or .svg: its profile, the sag of both surfaces and how far they depart from planes, and
    /// what it leaves of its law.
    #[arg(long, value_name = "FILE")]
    pub figure: Option<PathBuf>,
    /// Print the figures of the design as JSON.
    #[arg(long)]
    pub json: bool,
}
