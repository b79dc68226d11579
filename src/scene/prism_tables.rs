//! The table `[prism]` of a scene file as written: the seven kinds of glass, with the ranges of their keys.

use super::body_keys::BodyFile;
use super::limits::*;
use super::surface_keys::{CloudFile, MeshPrismFile};
use crate::num::bernstein::MAX_DEGREE;
use crate::num::curve::MAX_COEFFICIENTS;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The glass in front of the camera.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum PrismFile {
    /// No glass at all.
    None {},
    /// Two plane facets that meet in a ridge along y, and a plane base.
    Flat(BiprismFile),
    /// Facets and base designed from the flat biprism, so that each half image is that of a pinhole.
    Freeform(FreeformFile),
    /// Front and back of the right half as polynomials; the left half is its mirror image.
    Polynomial(PolynomialFile),
    /// Front and back of the right half as surfaces of revolution; the left half is its mirror image.
    Revolved(RevolvedFile),
    /// Front and back of the right half as points, to which polynomials are fitted; the left half is its mirror image.
    PointCloud(PointCloudFile),
    /// Front and back of the right half as triangles; the left half is their mirror image.
    Mesh(MeshPrismFile),
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct BiprismFile {
    #[serde(flatten)]
    pub(super) body: BodyFile,
    /// Distance D from the camera to the ridge, in mm: z of the ridge in the prism's frame.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) ridge_distance_mm: f64,
    /// Thickness T from ridge to base, in mm.
    #[schemars(range(max = LONGEST_MM), extend("exclusiveMinimum" = 0))]
    pub(super) thickness_mm: f64,
    /// Slope of the facets, in deg; positive when the glass is thickest at the ridge. Left out, it is the angle that
    /// leaves the two views parallel.
    #[schemars(extend("exclusiveMinimum" = -FACET_DEG, "exclusiveMaximum" = FACET_DEG))]
    pub(super) facet_angle_deg: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct FreeformFile {
    #[serde(flatten)]
    pub(super) biprism: BiprismFile,
    /// How the surfaces are designed.
    #[serde(default)]
    pub(super) design: DesignFile,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct DesignFile {
    /// What the surfaces are to be: `march` as in the design paper, nearly a pinhole each half; `epipolar`, surfaces of revolution
    /// about the baseline, whose vertical disparity is 0 at every depth and in every light; `toed-in`, surfaces of revolution about
    /// the line from the camera to the virtual camera, by which each half is exactly a pinhole, its axis turned outwards by about
    /// the angle of the half image's middle; `pinhole`, one that stays parallel, of two focal lengths; `depth`, the camera's own
    /// pinhole of a board at one depth. Polynomials leave what their degree does not follow.
    pub(super) objective: ObjectiveFile,
    /// What the design becomes: polynomials that are fitted to its surfaces, or the surfaces of revolution themselves, which `march`
    /// does not have.
    pub(super) surface: DesignedSurfaceFile,
    /// z of the virtual cameras in the prism's frame, in mm; the pinhole of the camera is at 0. Left out, it is 0, and of `toed-in`
    /// the distance of the virtual camera from the middle, which puts the axis at 45 deg; `epipolar` has no other than 0, and
    /// `toed-in` not 0.
    #[schemars(range(min = -LONGEST_MM, max = LONGEST_MM))]
    pub(super) virtual_camera_z_mm: Option<f64>,
    /// Which way the grid of `march` is marched: the centre row, then every column, or the centre column, then every row.
    pub(super) order: OrderFile,
    /// Total degree of the fitted polynomials.
    #[schemars(range(min = 1, max = DESIGN_DEGREE))]
    pub(super) degree: usize,
    /// The integrator of `march`.
    pub(super) method: MethodFile,
    /// Step of the grid that the polynomials are fitted to, and of the march, in px of the sensor. Left out, it is a 120th of the
    /// sensor's width, 16 px of 1920, and at least 1.
    #[schemars(range(min = SHORTEST_STEP_PX, max = LONGEST_STEP_PX))]
    pub(super) step_px: Option<f64>,
    /// The surface that faces the board: `own`, a freeform for each half; `even`, one freeform for both, smooth across x = 0;
    /// `flat`, the base of the flat prism. A prism of one piece of glass has one such surface.
    pub(super) rear: RearFile,
    /// Whether a `pinhole` has square pixels of the camera's own focal length.
    pub(super) square: bool,
    /// The aperture of the camera's lens, as f/N, where its spots are counted.
    #[schemars(range(min = SMALLEST_F_NUMBER, max = LARGEST_F_NUMBER))]
    pub(super) aperture: Option<f64>,
    /// How much a spot of the lens at `aperture`, root mean square, counts against a deviation of the same size.
    #[schemars(range(min = 0, max = SPOT_WEIGHT))]
    pub(super) spot_weight: f64,
    /// The nearest depth at which the two views are to be what the objective says, from the camera along z, in mm; the farthest
    /// is infinity.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) z_min_mm: f64,
    /// The depth of the objective `depth`, and the one where the lens of `aperture` is focused, in mm.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) depth_mm: f64,
    /// The distance of the two virtual cameras from each other, in mm: the ridge moves along z until it is so, and
    /// `prism.ridge_distance_mm` counts no more.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) baseline_mm: Option<f64>,
}

impl Default for DesignFile {
    fn default() -> Self {
        Self {
            objective: ObjectiveFile::March,
            surface: DesignedSurfaceFile::Polynomial,
            virtual_camera_z_mm: None,
            order: OrderFile::XThenY,
            degree: 5,
            method: MethodFile::Rk4,
            step_px: None,
            rear: RearFile::Own,
            square: false,
            aperture: None,
            spot_weight: 0.0,
            z_min_mm: 300.0,
            depth_mm: 1000.0,
            baseline_mm: None,
        }
    }
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ObjectiveFile {
    March,
    Epipolar,
    ToedIn,
    Pinhole,
    Depth,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum DesignedSurfaceFile {
    Polynomial,
    Revolved,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RearFile {
    Own,
    Even,
    Flat,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum OrderFile {
    XThenY,
    YThenX,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum MethodFile {
    Euler,
    Midpoint,
    Rk4,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct PolynomialFile {
    #[serde(flatten)]
    pub(super) body: BodyFile,
    /// The facet that faces the camera.
    pub(super) front: PatchFile,
    /// The surface that faces the board.
    pub(super) back: PatchFile,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RevolvedFile {
    #[serde(flatten)]
    pub(super) body: BodyFile,
    /// The facet that faces the camera.
    pub(super) front: RevolvedPatchFile,
    /// The surface that faces the board.
    pub(super) back: RevolvedPatchFile,
}

/// A part of a surface of revolution: the points whose distance from an axis is the sum of c_k T_k(x), T_k Chebyshev's
/// polynomials and x running from -1 to 1 as the place along the axis runs over `along_mm`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RevolvedPatchFile {
    /// The point [x, y, z] of the axis from which places along it are counted, in mm.
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) origin_mm: [f64; 3],
    /// The direction [x, y, z] of the axis, of any length, and more than 10 deg from z.
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) axis: [f64; 3],
    /// From where to where along the axis the surface reaches, in mm.
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) along_mm: [f64; 2],
    /// How far it reaches about the axis to both sides of the half-plane through it towards +z, in deg.
    #[schemars(range(max = WIDEST_AZIMUTH_DEG), extend("exclusiveMinimum" = 0))]
    pub(super) azimuth_deg: f64,
    /// The coefficients c_0, c_1, ... of the distance from the axis, in mm, c_0 greater than the magnitudes of all others
    /// together.
    #[schemars(length(min = 1, max = MAX_COEFFICIENTS), inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) profile_mm: Vec<f64>,
}

/// z(x, y) in mm as a sum of c X^m Y^n, with X and Y the scaled distances from the centre.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PatchFile {
    /// Centre [x, y] of the polynomial, in mm.
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) centre_mm: [f64; 2],
    /// The lengths [sx, sy] by which x and y are divided, in mm.
    #[schemars(inner(range(min = SHORTEST_MM, max = LONGEST_MM)))]
    pub(super) scale_mm: [f64; 2],
    /// Where the surface may be used, [[x_min, x_max], [y_min, y_max]], in mm; the right half has x above 0.
    #[schemars(inner(inner(range(min = -LONGEST_MM, max = LONGEST_MM))))]
    pub(super) domain_mm: [[f64; 2]; 2],
    /// The terms [m, n, c] of the sum: powers of X and Y, and coefficient in mm.
    #[schemars(length(min = 1, max = TERMS))]
    pub(super) terms: Vec<TermFile>,
}

#[derive(Debug, Deserialize, JsonSchema)]
pub(super) struct TermFile(
    #[schemars(range(max = MAX_DEGREE))] pub(super) usize,
    #[schemars(range(max = MAX_DEGREE))] pub(super) usize,
    #[schemars(range(min = -LONGEST_MM, max = LONGEST_MM))] pub(super) f64,
);

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct PointCloudFile {
    #[serde(flatten)]
    pub(super) body: BodyFile,
    /// The facet that faces the camera.
    pub(super) front: CloudFile,
    /// The surface that faces the board.
    pub(super) back: CloudFile,
}
