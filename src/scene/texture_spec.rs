//! The texture of a board, as checked values.

use crate::raster::Raster;
use crate::texture::TexelFilter;
use crate::texture::noise::TEXELS_A_WAVE;
use glam::DVec2;
use std::sync::Arc;

/// What a board shows in place of its squares.
#[derive(Debug, Clone, PartialEq)]
pub enum TextureSpec {
    /// A picture from a file.
    Image(ImageSpec),
    /// Noise over the area of the squares.
    Noise {
        /// Another one for every seed.
        seed: u32,
        /// The shortest wavelength, in mm.
        finest_mm: f64,
    },
    /// Siemens stars and slanted squares by turns, one a square of the board.
    Chart,
}

/// A picture from a file on the board.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageSpec {
    /// The file, as the scene names it.
    pub file: String,
    /// Its light: 0 is the board's black, 1 its white.
    pub light: Arc<Raster<f32>>,
    /// Its width on the board, in mm; its pixels are squares.
    pub width_mm: f64,
    /// What lies between the middles of its pixels.
    pub filter: TexelFilter,
}

impl TextureSpec {
    /// The shortest wavelength of a noise where nothing else is said, in mm: a tenth of a square's side.
    pub fn usual_finest_mm(square_mm: f64) -> f64 {
        square_mm / 10.0
    }

    /// What it is, in words.
    pub fn words(&self) -> String {
        match self {
            Self::Image(image) => format!("the picture {:?}", image.file),
            Self::Noise { .. } => "noise".to_owned(),
            Self::Chart => "a chart".to_owned(),
        }
    }

    /// Width and height on a board whose squares cover `squares_mm`, in mm.
    pub fn size_mm(&self, squares_mm: DVec2) -> DVec2 {
        match self {
            Self::Image(image) => {
                DVec2::new(1.0, image.light.height() as f64 / image.light.width() as f64) * image.width_mm
            }
            Self::Noise { .. } | Self::Chart => squares_mm,
        }
    }

    /// Columns and rows of the texels of a noise with this shortest wavelength over `squares_mm`.
    pub fn noise_texels(squares_mm: DVec2, finest_mm: f64) -> [f64; 2] {
        (squares_mm * (TEXELS_A_WAVE / finest_mm)).ceil().max(DVec2::ONE).to_array()
    }
}
