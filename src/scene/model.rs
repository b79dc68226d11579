//! A scene as checked values: what every other room takes.

use super::design_model::DesignSettings;
use super::law::PrismLaw;
use super::limits;
use super::texture_spec::TextureSpec;
use crate::accuracy::Accuracy;
use crate::effect::Effects;
use crate::geom::{Distortion, Pose};
use crate::num::powers::Powers;
use crate::optics::medium::Material;
use crate::surface::mesh::{Normals, Triangles};
use crate::surface::shape::{PolynomialPatch, RevolvedPatch};
use glam::{DMat3, DVec2, DVec3};

/// A whole scene. One that was read from a file is checked: every value is within its stated range. One that was made in
/// code is so once [`Scene::check`] has found nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Short name, used in titles and file names.
    pub name: String,
    /// The one camera.
    pub camera: CameraSpec,
    /// The glass in front of it.
    pub prism: PrismSpec,
    /// What it looks at.
    pub board: BoardSpec,
    /// What the board shows in place of its squares, where it has a texture.
    pub texture: Option<TextureSpec>,
    /// Objects besides the board.
    pub objects: Vec<ObjectSpec>,
    /// How the board's place is known where a picture is measured.
    pub board_pose: BoardPose,
    /// Accuracy of the simulation.
    pub accuracy: Accuracy,
    /// What the picture shows besides geometry; none where the scene says `effects = "none"`.
    pub effects: Effects,
    /// How a PNG of the picture is encoded.
    pub encoding: Encoding,
    /// How the studies sample the scene.
    pub analysis: Analysis,
    /// What the scene claims about its own result.
    pub expect: Vec<Expect>,
}

/// A pinhole camera, which looks along +z where its calibration does not turn it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraSpec {
    /// World position of the pinhole, in mm.
    pub position_mm: DVec3,
    /// Distance from the pinhole to the sensor, in mm.
    pub focal_length_mm: f64,
    /// Columns of the sensor.
    pub width_px: usize,
    /// Rows of the sensor.
    pub height_px: usize,
    /// Side of a square pixel, in mm.
    pub pitch_mm: f64,
    /// What is known of it besides: the default is the plain pinhole.
    pub calibration: CalibrationSpec,
}

/// How a camera differs from a plain pinhole, whose axis runs along +z through the middle of its sensor. The default does not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationSpec {
    /// The principal point, where the axis of the lens meets the sensor, in px: the middle of the upper left pixel is at
    /// (0.5, 0.5). `None` is the middle of the sensor.
    pub principal_px: Option<DVec2>,
    /// The camera's frame in the world, turned about the pinhole.
    pub rotation: DMat3,
    /// What the lens does to the picture.
    pub distortion: Distortion,
    /// The scale of the picture along y over that along x: fy / fx.
    pub focal_ratio: f64,
}

/// The glass between camera and board.
#[derive(Debug, Clone, PartialEq)]
pub enum PrismSpec {
    /// No glass at all.
    None,
    /// Two plane facets and a plane base.
    Flat(BiprismSpec),
    /// Facets and base designed by marching Eqs. 1-4 of the design paper from the flat prism.
    Freeform(BiprismSpec, DesignSettings),
    /// Front and back of the right half (x > 0 in the prism's frame) as polynomials; the left half is its mirror image.
    Polynomial(PolynomialSpec),
    /// Front and back of the right half as surfaces of revolution; the left half is its mirror image.
    Revolved(RevolvedSpec),
    /// Front and back of the right half as points, to be fitted.
    PointCloud(PointCloudSpec),
    /// Front and back of the right half as triangles.
    Mesh(MeshSpec),
}

impl GlassSpec {
    /// Glass without a name, its index given at the d line, in the world's own frame.
    pub fn new(index: f64, outer_index: f64) -> Self {
        let wavelength_nm = limits::D_LINE_NM;
        Self {
            index,
            outer_index,
            glass: None,
            wavelength_nm,
            solid: None,
            world_from_prism: Pose::IDENTITY,
            law: None,
        }
    }
}

impl CloudSpec {
    /// Which powers of y are fitted.
    pub fn powers(&self) -> Powers {
        if self.symmetric { Powers::EvenInY } else { Powers::All }
    }
}

impl PrismSpec {
    /// The kind of the prism, as a scene file and a report call it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Flat(_) => "flat",
            Self::Freeform(..) => "freeform",
            Self::Polynomial(_) => "polynomial",
            Self::Revolved(_) => "revolved",
            Self::PointCloud(_) => "point_cloud",
            Self::Mesh(_) => "mesh",
        }
    }

    /// What the prism is made of; `None` without one.
    pub fn body(&self) -> Option<&GlassSpec> {
        match self {
            Self::None => None,
            Self::Flat(flat) | Self::Freeform(flat, _) => Some(&flat.body),
            Self::Polynomial(prism) => Some(&prism.body),
            Self::Revolved(prism) => Some(&prism.body),
            Self::PointCloud(prism) => Some(&prism.body),
            Self::Mesh(prism) => Some(&prism.body),
        }
    }

    /// Whether it is traced as one piece of glass: as its body says, or by its kind.
    pub fn is_solid(&self) -> bool {
        let by_kind = match self {
            Self::Revolved(_) => true,
            Self::Freeform(_, settings) => settings.objective.is_solid(),
            _ => false,
        };
        self.body().and_then(|body| body.solid).unwrap_or(by_kind)
    }
}

/// The biprism of the paper: a ridge along y at x = 0, nearest to the camera; facets z = D + |x| tan(alpha);
/// a base plane at z = D + T.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BiprismSpec {
    /// Glass and place.
    pub body: GlassSpec,
    /// D, the z of the ridge in the prism's frame, in mm.
    pub ridge_distance_mm: f64,
    /// T, ridge to base, in mm.
    pub thickness_mm: f64,
    /// alpha in rad; `None` is the angle of Eq. 5, which leaves the two virtual cameras parallel.
    pub facet_angle_rad: Option<f64>,
}

/// What every prism has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GlassSpec {
    /// Refractive index of the glass.
    pub index: f64,
    /// Refractive index of what surrounds the glass.
    pub outer_index: f64,
    /// The glass, where its name is given: how its index changes with the wavelength.
    pub glass: Option<&'static Material>,
    /// The wavelength in vacuum to which `index` belongs, in nm.
    pub wavelength_nm: f64,
    /// Whether the prism is one piece of glass; `None` by its kind: see [`PrismSpec::is_solid`].
    pub solid: Option<bool>,
    /// The prism's frame in the world.
    pub world_from_prism: Pose,
    /// What the halves of the picture are meant to be, where it is stated.
    pub law: Option<PrismLaw>,
}

/// A prism given by its surfaces.
#[derive(Debug, Clone, PartialEq)]
pub struct PolynomialSpec {
    /// Glass and place.
    pub body: GlassSpec,
    /// The facet that faces the camera: z(x, y) in mm in the prism's frame.
    pub front: PolynomialPatch,
    /// The surface that faces the board.
    pub back: PolynomialPatch,
}

/// A prism given by its surfaces, which are of revolution.
#[derive(Debug, Clone, PartialEq)]
pub struct RevolvedSpec {
    /// Glass and place.
    pub body: GlassSpec,
    /// The facet that faces the camera, in the prism's frame.
    pub front: RevolvedPatch,
    /// The surface that faces the board.
    pub back: RevolvedPatch,
}

/// A prism given by points on its surfaces.
#[derive(Debug, Clone, PartialEq)]
pub struct PointCloudSpec {
    /// Glass and place.
    pub body: GlassSpec,
    /// The facet that faces the camera.
    pub front: CloudSpec,
    /// The surface that faces the board.
    pub back: CloudSpec,
}

/// A prism given by triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshSpec {
    /// Glass and place.
    pub body: GlassSpec,
    /// The facet that faces the camera, in the prism's frame.
    pub front: Triangles,
    /// The surface that faces the board.
    pub back: Triangles,
    /// Which normals refract.
    pub normals: Normals,
    /// Front and back of the left half, where they are not the mirror images of those of the right one.
    pub left: Option<[Triangles; 2]>,
    /// What was made of a closed body, in words, where front and back are parts of one.
    pub told: Option<String>,
}

/// Points of a surface, and how a polynomial is fitted to them.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudSpec {
    /// The points, in mm, in the prism's frame.
    pub points_mm: Vec<DVec3>,
    /// Total degree of the fitted polynomial.
    pub degree: usize,
    /// Whether the surface is its own mirror image in y = 0, so that only even powers of y are fitted.
    pub symmetric: bool,
    /// The largest residual that the fit may leave, in mm.
    pub max_residual_mm: f64,
    /// The file of the points, as the scene names it.
    pub file: String,
}

/// A checkerboard on a plate: squares, a white margin around them, and a background around the plate.
///
/// In the board's frame the squares' centre is the origin, +x runs along the columns, +y down the rows, and the
/// board is the plane z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardSpec {
    /// Squares in x.
    pub columns: usize,
    /// Squares in y.
    pub rows: usize,
    /// Side of a square, in mm.
    pub square_mm: f64,
    /// Width of the white margin, in mm.
    pub margin_mm: f64,
    /// The board's frame in the world.
    pub world_from_board: Pose,
    /// Radiance of a black square (the top left one is black), of full scale 1.
    pub black: f64,
    /// Radiance of a white square and of the margin.
    pub white: f64,
    /// Radiance around the plate.
    pub background: f64,
}

/// A plane besides the board, squares with a margin around them, which hides what lies behind it. The background of its plate is
/// of no account: it ends there.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectSpec {
    /// Squares, margin and place, as of a board.
    pub plate: BoardSpec,
    /// What it shows in place of its squares, where it has a texture.
    pub texture: Option<TextureSpec>,
}

impl ObjectSpec {
    /// Width and height of what it shows within its margin, in mm.
    pub fn size_mm(&self) -> DVec2 {
        let squares_mm = self.plate.squares_mm();
        self.texture.as_ref().map_or(squares_mm, |texture| texture.size_mm(squares_mm))
    }
}

impl BoardSpec {
    /// Width and height of all squares together, in mm.
    pub fn squares_mm(&self) -> DVec2 {
        DVec2::new(self.columns as f64, self.rows as f64) * self.square_mm
    }
}

/// How the place of the board of a measured picture is known. Pictures that are made here have it where the scene says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BoardPose {
    /// The scene states it.
    #[default]
    Stated,
    /// It is fitted to the corners of the picture.
    Fit,
}

/// How linear radiance is coded in a PNG.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Value = radiance, or what a sensor with a gamma makes of it; gAMA 1.0.
    Linear,
    /// The sRGB curve of IEC 61966-2-1.
    Srgb,
}

/// How the studies sample a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Analysis {
    /// Board distances along z, from the camera, at which the pinhole deviation is judged, in mm.
    pub depths_mm: Vec<f64>,
    /// Points along each side of the uniform grid over a half image.
    pub grid: usize,
}

impl Analysis {
    /// Points along each side of the grid where nothing else is said.
    pub const GRID: usize = 33;

    /// Half, once and twice the distance of a board whose centre is `own_mm` from the camera along z, and a grid of
    /// [`Analysis::GRID`].
    pub fn about(own_mm: f64) -> Self {
        Self { depths_mm: [0.5, 1.0, 2.0].map(|times| times * own_mm).to_vec(), grid: Self::GRID }
    }
}

/// One claim of a scene about its own result.
#[derive(Debug, Clone, PartialEq)]
pub struct Expect {
    /// Path of a number in `report.json` under the design's name: `freeform/pinhole/designed/mean_abs_v_mm`.
    pub value: String,
    /// Smallest allowed value.
    pub min: Option<f64>,
    /// Largest allowed value.
    pub max: Option<f64>,
}
