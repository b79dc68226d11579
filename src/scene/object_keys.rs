//! Objects beside the board: planes with a checkerboard or a texture, as they are written and what they come to.

use super::document::Document;
use super::limits::{self, LONGEST_MM, RADIANCE, SHORTEST_MM, SIDE_SQUARES, TILT_DEG};
use super::model::{BoardSpec, ObjectSpec};
use super::texture_keys::{self, TextureFile};
use crate::error::Error;
use crate::geom::Pose;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ObjectFile {
    /// Squares in x.
    #[schemars(range(min = 1, max = SIDE_SQUARES))]
    pub(super) columns: usize,
    /// Squares in y.
    #[schemars(range(min = 1, max = SIDE_SQUARES))]
    pub(super) rows: usize,
    /// Side of a square, in mm.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) square_mm: f64,
    /// Position [x, y, z] of the middle of the squares, in mm.
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) position_mm: [f64; 3],
    /// Tilt [rx, ry, rz] of the object about the fixed x, then y, then z axis, in deg.
    #[serde(default)]
    #[schemars(inner(range(min = -TILT_DEG, max = TILT_DEG)))]
    pub(super) tilt_deg: [f64; 3],
    /// Width of the white margin around the squares, in mm.
    #[serde(default)]
    #[schemars(range(min = 0, max = LONGEST_MM))]
    pub(super) margin_mm: f64,
    /// What the object shows in place of its squares, as `board.texture`.
    pub(super) texture: Option<TextureFile>,
    /// Radiance of a black square, of full scale 1.
    #[serde(default = "limits::black")]
    #[schemars(range(min = 0, max = RADIANCE))]
    pub(super) black: f64,
    /// Radiance of a white square and of the margin, of full scale 1.
    #[serde(default = "limits::white")]
    #[schemars(range(min = 0, max = RADIANCE))]
    pub(super) white: f64,
}

/// The objects that `files` describe, before the board's background; pictures are looked for in `folder`.
pub(super) fn objects(
    document: &Document,
    files: &[ObjectFile],
    background: f64,
    folder: Option<&Path>,
) -> Result<Vec<ObjectSpec>, Error> {
    let object = |(k, file): (usize, &ObjectFile)| -> Result<ObjectSpec, Error> {
        let tilt_rad = DVec3::from_array(file.tilt_deg.map(f64::to_radians));
        let plate = BoardSpec {
            columns: file.columns,
            rows: file.rows,
            square_mm: file.square_mm,
            margin_mm: file.margin_mm,
            world_from_board: Pose::new(DVec3::from_array(file.position_mm), tilt_rad),
            black: file.black,
            white: file.white,
            background,
        };
        let texture = |file| texture_keys::texture(document, &format!("object[{k}].texture"), file, &plate, folder);
        Ok(ObjectSpec { plate, texture: file.texture.as_ref().map(texture).transpose()? })
    };
    files.iter().enumerate().map(object).collect()
}
