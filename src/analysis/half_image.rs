//! The halves of a picture and the pinhole that each is designed to be.

use crate::geom::{Pose, Ray};
use crate::metrics::pinhole::Pinhole;
use crate::metrics::row_law::RowShift;
use crate::optics::fate::Fate;
use crate::scene::PrismLaw;
use crate::system::{Camera, Prism, Side, System};
use crate::vision::half::Half;
use glam::{DVec2, DVec3};

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

    /// 1 for the right half, -1 for the left one, which is its mirror image.
    fn mirror(&self) -> f64 {
        if self.half == Half::Left { -1.0 } else { 1.0 }
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

    /// Where the plain pinhole in place of `camera` would see what is seen at `half_px`, in the half's own px: the position
    /// itself where the camera is one. Figures of a prism are counted there, so that no lens is blamed on it.
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

/// The virtual camera that a half is designed to be, whatever errors its prism has as built and whatever clips its rays. It is
/// that of the prism's law where there is one, [`row_shift`] apart. Else it is found from the central ray of the half image
/// only, through the prism as it is meant to be: it lies on that ray's extension beside the real camera (in its plane of
/// constant z), is parallel to it, has its focal length and pixels, and sees with the half image's centre where that ray goes.
///
/// Of a calibrated camera it is that of the plain pinhole of the same place and focal length, and positions are compared with it
/// where that would see them: [`HalfFrame::rectified`].
///
/// For the design paper's prisms this is its O' with z = 0. For any other prism it is what the prism would be used as.
///
/// # Errors
/// [`NoPinhole`].
pub fn virtual_camera(system: &System, frame: &HalfFrame) -> Result<Pinhole, NoPinhole> {
    if let Some((law, prism)) = stated(system) {
        return of_law(system, frame, law, prism);
    }
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

/// The law of the prism as it is meant to be, and the prism.
fn stated(system: &System) -> Option<(&PrismLaw, &Prism)> {
    system.designed().and_then(|prism| Some((prism.law()?, prism)))
}

/// The pinhole of `law`, in the frame of `prism`.
fn of_law(system: &System, frame: &HalfFrame, law: &PrismLaw, prism: &Prism) -> Result<Pinhole, NoPinhole> {
    system.camera().tangent_per_px().ok_or(NoPinhole::Telecentric)?;
    let (mirror, pitch_mm) = (frame.mirror(), system.camera_spec().pitch_mm);
    let centre_mm = DVec3::new(0.5 * mirror * law.baseline_mm, 0.0, law.centre_z_mm);
    let from_centre = Pose { translation_mm: -centre_mm, ..Pose::IDENTITY };
    let turn = Pose::new(DVec3::ZERO, DVec3::new(0.0, -mirror * law.tau_rad, 0.0));
    Ok(Pinhole {
        camera_from_world: turn.after(&from_centre).after(&prism.prism_from_world()),
        focal_px: DVec2::from(law.focal_mm) / pitch_mm,
        principal_px: frame.own(frame.centre_px(system)) + DVec2::new(mirror * law.c_x_mm / pitch_mm, 0.0),
    })
}

/// The shift of the rows that the half is designed to have besides its pinhole; `None` where it has none.
pub fn row_shift(system: &System, frame: &HalfFrame) -> Option<RowShift> {
    let (law, _) = stated(system)?;
    let pitch_mm = system.camera_spec().pitch_mm;
    (law.kappa_mm != 0.0).then(|| RowShift {
        amplitude_px: frame.mirror() * law.kappa_mm / pitch_mm,
        focal_px: law.focal_mm[1] / pitch_mm,
        middle_px: frame.centre_px(system).y,
    })
}

/// The shift of the rows through a prism whose epipolar lines are the rows: that of its law, or else b (sqrt(1 + v^2/f^2) - 1),
/// with the camera's focal length f, and b from the middle of the picture to that of its half; `None` of a telecentric camera.
pub(crate) fn epipolar_shift(system: &System, frame: &HalfFrame) -> Option<RowShift> {
    let of_camera = || {
        let centre_px = frame.centre_px(system);
        let [width, _] = system.camera().size_px();
        Some(RowShift {
            amplitude_px: centre_px.x - 0.5 * width as f64,
            focal_px: 1.0 / system.camera().tangent_per_px()?,
            middle_px: centre_px.y,
        })
    };
    row_shift(system, frame).or_else(of_camera)
}

/// The same, on the central ray of the instrument as built.
///
/// # Errors
/// [`NoPinhole`].
pub(crate) fn virtual_camera_made(system: &System, frame: &HalfFrame) -> Result<Pinhole, NoPinhole> {
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
