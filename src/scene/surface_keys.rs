//! The keys of a surface that comes from a file, as they are written: where it stands, and how it is fitted.

use super::body_keys::BodyFile;
use super::limits::*;
use crate::num::bernstein::MAX_DEGREE;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the numbers of a file become mm in the prism's frame: times the unit, then `flip`, then `offset_mm`, then `pose`.
#[derive(Debug, Default, Deserialize, JsonSchema)]
pub(super) struct PlacementFile {
    /// Unit of the numbers in the file.
    #[serde(default)]
    pub(super) unit: UnitFile,
    /// Axes along which the surface is turned round, one or a list: their numbers change sign, once they are in mm.
    pub(super) flip: Option<FlipFile>,
    /// What is added to x, y and z after `flip`, in mm.
    #[serde(default)]
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) offset_mm: [f64; 3],
    /// Where the frame of the surface stands in that of the prism: tilted about its origin, then moved, after `offset_mm`.
    #[serde(default)]
    pub(super) pose: PoseFile,
}

/// A unit of length.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum UnitFile {
    #[default]
    Mm,
    Um,
    M,
    In,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum AxisFile {
    X,
    Y,
    Z,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum FlipFile {
    One(AxisFile),
    Several(#[schemars(length(min = 1, max = 3))] Vec<AxisFile>),
}

/// A tilt and a move.
#[derive(Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct PoseFile {
    /// Position [x, y, z] of the surface's frame, in mm.
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) position_mm: [f64; 3],
    /// Tilt [rx, ry, rz] of the surface about the fixed x, then y, then z axis, in deg.
    #[schemars(inner(range(min = -TILT_DEG, max = TILT_DEG)))]
    pub(super) tilt_deg: [f64; 3],
}

/// Points of a surface and how they are fitted.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct CloudFile {
    /// File of points x, y, z, CSV, PLY or XYZ, or of sag over a grid, Zemax .dat or .grd, relative to the scene file.
    #[schemars(length(min = 1, max = PATH_CHARS))]
    pub(super) file: String,
    /// Total degree of the fitted polynomial.
    #[schemars(range(min = 1, max = MAX_DEGREE))]
    pub(super) degree: usize,
    /// Whether the surface is its own mirror image in y = 0, so that only even powers of y are fitted.
    #[serde(default)]
    pub(super) symmetric: bool,
    /// The largest distance along z of a point from the polynomial that is taken, in mm; a scene with a larger one is refused.
    #[serde(default = "max_residual_mm")]
    #[schemars(range(max = LONGEST_MM), extend("exclusiveMinimum" = 0))]
    pub(super) max_residual_mm: f64,
    #[serde(flatten)]
    pub(super) placement: PlacementFile,
}

fn max_residual_mm() -> f64 {
    1e-3
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct MeshPrismFile {
    #[serde(flatten)]
    pub(super) glass: BodyFile,
    /// File of the facet that faces the camera, STL, PLY or OBJ, relative to the scene file; the right half has x above 0.
    pub(super) front: Option<MeshFile>,
    /// File of the surface that faces the board.
    pub(super) back: Option<MeshFile>,
    /// File of the whole closed body, in place of `front` and `back`: its lower sheet is the front, its upper one the back.
    #[serde(rename = "body")]
    pub(super) solid: Option<MeshFile>,
    /// Which normals refract: smooth ones between the corners, parted where facets make a crease of more than 1 deg (of more
    /// than 5 deg where nothing smooth lies beside it), or each triangle's own. Pixels are cut along the sides of triangles where
    /// their rays pass; where a rim clips rays or a surface is rough, along creases where a surface has at most 256 facets, and
    /// along the kinks at the sides of triangles with smooth normals where they matter and are at most 65536; other such pixels
    /// are counted as without promise. What is smaller than a pixel may lie between the rays that look for it.
    #[serde(default)]
    pub(super) normals: NormalsFile,
}

#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum NormalsFile {
    #[default]
    Smooth,
    Flat,
}

/// A file in mm, or a file with where its surface stands.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum MeshFile {
    Name(#[schemars(length(min = 1, max = PATH_CHARS))] String),
    Placed(PlacedMeshFile),
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct PlacedMeshFile {
    /// File of triangles, STL, PLY or OBJ, relative to the scene file.
    #[schemars(length(min = 1, max = PATH_CHARS))]
    pub(super) file: String,
    #[serde(flatten)]
    pub(super) placement: PlacementFile,
}
