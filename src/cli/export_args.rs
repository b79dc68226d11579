//! The arguments of `export`.

use super::prisms_args::positive;
use super::set_args::SetArgs;
use clap::ValueEnum;
use std::path::PathBuf;

/// Tolerance of a body, where none is asked for, in mm: a tenth of what a good workshop keeps.
pub(super) const BODY_TOLERANCE_MM: f64 = 1e-4;
/// Tolerance of sag over a grid, where none is asked for, in mm: over cells of 0.5 mm its slopes are then off by 1e-7, some 1e-4 px.
pub(super) const GRID_TOLERANCE_MM: f64 = 1e-8;

/// A kind of file for other programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExportFormat {
    /// Lens files of Optiland, one a half, of a prism whose surfaces are polynomials or planes.
    Optiland,
    /// Grid sag files of OpticStudio, front and back of the right half, with exact derivatives.
    ZemaxGrid,
    /// Extended Polynomial surfaces of OpticStudio as text, of a prism whose surfaces are polynomials or planes.
    ZemaxExtended,
    /// The whole prism as one watertight body, binary STL: f32.
    Stl,
    /// The same as PLY: f64, binary.
    Ply,
    /// The same as OBJ: f64, text.
    Obj,
    /// The virtual cameras of both halves as YAML of OpenCV.
    CamerasYml,
    /// What the middle of every pixel sees, as an array of NumPy.
    Npy,
}

/// Arguments of `export`.
#[derive(Debug, clap::Args)]
pub struct ExportArgs {
    /// Scene file; `-` is stdin.
    pub scene: PathBuf,
    /// Values in place of the scene's.
    #[command(flatten)]
    pub values: SetArgs,
    /// What is written.
    #[arg(long)]
    pub format: ExportFormat,
    /// Of stl, ply, obj, zemax-extended, cameras-yml and npy a file, or a folder, whose file then is called prism.stl, prism.ply,
    /// prism.obj, zemax_extended.txt, cameras.yml or truth.npy; of the others a folder, for left.json and right.json of Optiland, and
    /// for front.dat, back.dat and prism.toml, which reads them, of the grid.
    #[arg(long, default_value = "out")]
    pub out: PathBuf,
    /// How far what is written may stray from the surfaces, in mm: chords of a body (without it 1e-4), the bicubic surface through a
    /// grid (without it 1e-8).
    #[arg(long, value_parser = positive, value_name = "MM", allow_negative_numbers = true)]
    pub tolerance_mm: Option<f64>,
    /// Print the files and their figures as JSON.
    #[arg(long)]
    pub json: bool,
}
