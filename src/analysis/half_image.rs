//! The halves of a picture and the pinhole that each is designed to be.

use crate::geom::Ray;
use crate::metrics::pinhole::Pinhole;
use crate::optics::fate::Fate;
use crate::system::{Camera, Side, System};
use crate::vision::half::Half;
use glam::DVec2;

/// The place of a half in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfFrame {
    /// Which half.
    pub half: Half,
    /// The picture's column that is the half's column 0.
    pub first_column: usize,
    /// Columns and rows of the half.
    pub size_px: DVec2,
}

impl HalfFrame {
    /// The frame of `half` of `system`'s pictures; the middle column of an odd width belongs to neither.
    pub fn new(system: &System, half: Half) -> Self {
        let [width, height] = system.camera().size_px();
        let first_column = if half == Half::Left { 0 } else { width.div_ceil(2) };
        Self { half, first_column, size_px: DVec2::new((width / 2) as f64, height as f64) }
    }

    /// The side of the prism that this half sees through.
    pub fn side(&self) -> Side {
        if self.half == Half::Left { Side::Left } else { Side::Right }
    }

    /// A position in the whole picture from one in the half, in px.
    pub fn full(&self, half_px: DVec2) -> DVec2 {
        half_px + DVec2::new(self.first_column as f64, 0.0)
    }

    /// A position in the half from one in the whole picture, in px.
    pub fn own(&self, full_px: DVec2) -> DVec2 {
        full_px - DVec2::new(self.first_column as f64, 0.0)
    }

    /// The centre of the half image, B of the design paper: a quarter of the picture from its edge.
    pub fn centre_px(&self, system: &System) -> DVec2 {
        let [width, height] = system.camera().size_px().map(|n| n as f64);
        let x = if self.half == Half::Left { 0.25 * width } else { 0.75 * width };
        DVec2::new(x, 0.5 * height)
    }

    /// Where the plain pinhole in place of `camera` would see what is seen at `half_px`, in the half's own px: the position itself
    /// where the camera is one. Figures of a prism are counted there, so that no lens is blamed on it.
    pub fn rectified(&self, camera: &Camera, half_px: DVec2) -> DVec2 {
        if camera.is_plain() { half_px } else { self.own(camera.rectified(self.full(half_px))) }
    }

    /// The inverse of [`HalfFrame::rectified`]; `None` behind the camera.
    pub fn unrectified(&self, camera: &Camera, half_px: DVec2) -> Option<DVec2> {
        if camera.is_plain() { Some(half_px) } else { Some(self.own(camera.unrectified(self.full(half_px))?)) }
    }

    /// Whether a position (in the half's own px) lies in the half.
    pub fn contains(&self, half_px: DVec2) -> bool {
        half_px.cmpgt(DVec2::ZERO).all() && half_px.cmplt(self.size_px).all()
    }
}

/// Why a half has no virtual camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoPinhole {
    /// The central ray of the half ends so.
    Ends(Fate),
    /// The real camera is telecentric: its rays meet in no point.
    Telecentric,
}

impl NoPinhole {
    /// The reason in words.
    pub const fn reason(self) -> &'static str {
        match self {
            Self::Telecentric => "the camera is telecentric, and its rays meet in no point",
            Self::Ends(Fate::Missed) => "the central ray of the half misses the prism",
            Self::Ends(Fate::TotalReflection) => "the central ray of the half is totally reflected",
            Self::Ends(Fate::NotConverged) => "where the central ray of the half goes is not known",
            Self::Ends(Fate::PastBoard) => "the central ray of the half turns back",
            Self::Ends(Fate::Clipped) => "the central ray of the half is clipped",
        }
    }
}

impl std::fmt::Display for NoPinhole {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Ends(fate) => write!(f, "the central ray ends ({})", fate.name()),
            Self::Telecentric => write!(f, "the camera is telecentric"),
        }
    }
}

/// The virtual camera that a half is designed to be, whatever errors its prism has as built and whatever clips its
/// rays. It is found from the central ray of the half image only, through the prism as it is meant to be: it lies on
/// that ray's extension beside the real camera (in its plane of constant z), is parallel to it, has its focal length
/// and pixels, and sees with the half image's centre where that ray goes.
///
/// Of a calibrated camera it is that of the plain pinhole of the same place and focal length, and positions are compared with it
/// where that would see them: [`HalfFrame::rectified`].
///
/// For the design paper's prisms this is its O' with z = 0. For any other prism it is what the prism would be used as.
///
/// # Errors
/// [`NoPinhole`].
pub fn virtual_camera(system: &System, frame: &HalfFrame) -> Result<Pinhole, NoPinhole> {
    let ray = system.camera().plain_ray(frame.centre_px(system));
    let residual_mm = system.accuracy().surface_residual_mm;
    on_ray(
        system,
        frame,
        match system.designed() {
            None => Ok(ray),
            Some(prism) => prism.pass(&ray, residual_mm, &mut ()).map(|(ray, _)| ray),
        },
    )
}

/// The same, on the central ray of the instrument as built.
///
/// # Errors
/// [`NoPinhole`].
pub fn virtual_camera_made(system: &System, frame: &HalfFrame) -> Result<Pinhole, NoPinhole> {
    let ray = system.camera().plain_ray(frame.centre_px(system));
    on_ray(system, frame, system.exit(ray, &mut ()).map(|(ray, _)| ray))
}

fn on_ray(system: &System, frame: &HalfFrame, ray: Result<Ray, Fate>) -> Result<Pinhole, NoPinhole> {
    let tangent_per_px = system.camera().tangent_per_px().ok_or(NoPinhole::Telecentric)?;
    let centre_px = frame.centre_px(system);
    let ray = ray.map_err(NoPinhole::Ends)?;
    if ray.direction.z <= 0.0 {
        return Err(NoPinhole::Ends(Fate::PastBoard));
    }
    let tangent = ray.direction.truncate() / ray.direction.z;
    let camera_z = system.camera().position_mm().z;
    let centre_mm = ray.at((camera_z - ray.origin.z) / ray.direction.z);
    let focal_px = 1.0 / tangent_per_px;
    let principal_px = frame.own(centre_px) - tangent * focal_px;
    Ok(Pinhole { focal_px: DVec2::splat(focal_px), ..Pinhole::parallel(centre_mm, focal_px, 1.0, principal_px) })
}
