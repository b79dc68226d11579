//! The sheet of a prism: all that a cutter asks.

use super::bench::Bench;
use super::form::{GlassForm, SurfaceForm, form};
use super::residual::{LawResidual, ResidualMap, residual};
use super::sensitivity::{ErrorSensitivity, all_errors, sensitivities};
use super::spot::{F_NUMBER, Spot, spot};
use crate::design::FreeformDesign;
use crate::effect::thin_lens::Aperture;
use crate::effect::{Effects, Lens, ThinLens};
use crate::error::Error;
use crate::geom::Pose;
use crate::scene::{BiprismSpec, CameraSpec, GlassSpec, PrismSpec, Scene};
use crate::system;
use glam::DVec3;

/// All that a cutter asks of a prism.
#[derive(Debug, Clone, PartialEq)]
pub struct CutterSheet {
    /// What is left of the law at the near end of the depths, and at infinity: between them it is affine in 1/distance.
    pub residuals: [LawResidual; 2],
    /// The error vectors of the right half at the end that has the larger RMS.
    pub worse_map: ResidualMap,
    /// The front and the back of the right half.
    pub surfaces: [SurfaceForm; 2],
    /// The glass.
    pub glass: GlassForm,
    /// The spot at an aperture.
    pub spot: Spot,
    /// What errors of manufacture do.
    pub sensitivities: Vec<ErrorSensitivity>,
}

/// Whether more coefficients would leave less.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Floor {
    /// The degree that was tried besides: two more.
    pub degree: usize,
    /// The larger RMS of both ends of the depths with it, in px.
    pub rms_px: f64,
    /// Whether it leaves more than half as much: then what is left is not the polynomials'.
    pub reached: bool,
}

impl Floor {
    /// The design of `degree`, two more than what leaves `own_px`, leaves `next`. What is exact falls a hundredfold.
    pub fn of(degree: usize, own_px: f64, next: &[LawResidual; 2]) -> Self {
        let rms_px = larger_rms_px(next);
        Self { degree, rms_px, reached: rms_px > 0.5 * own_px }
    }
}

impl CutterSheet {
    /// The larger RMS of both ends of the depths, in px.
    pub fn rms_px(&self) -> f64 {
        larger_rms_px(&self.residuals)
    }
}

fn larger_rms_px(residuals: &[LawResidual; 2]) -> f64 {
    residuals.iter().map(|r| r.both_rms_px).fold(0.0, f64::max)
}

/// The nearest depth that a design is held to where nothing else is said, in mm.
pub const Z_MIN_MM: f64 = 300.0;

/// The scene of a design by itself: its surfaces with the law that they are for, before the plain pinhole in the prism's frame,
/// with room for the rays of its lens and for errors of manufacture.
pub fn of_design(scene: &Scene, flat: &BiprismSpec, designed: &FreeformDesign) -> Scene {
    let camera = CameraSpec { position_mm: DVec3::ZERO, ..scene.camera.plain() };
    let body = GlassSpec {
        law: Some(flat.body.law.unwrap_or_else(|| designed.law())),
        world_from_prism: Pose::IDENTITY,
        ..flat.body
    };
    let thin = scene.effects.lens.thin().filter(|lens| lens.radius_mm > 0.0).copied();
    let lens = Lens::Thin(
        thin.unwrap_or_else(|| ThinLens::new(F_NUMBER, f64::INFINITY, Aperture::Circle, camera.focal_length_mm)),
    );
    let room = Effects { manufacture: Some(all_errors()), lens, ..Effects::default() };
    let prism = PrismSpec::Polynomial(system::with_room_for(designed.prism(body), flat, &camera, &room));
    let mut board = scene.board;
    board.world_from_board.translation_mm.z -= scene.camera.position_mm.z;
    let effects = Effects { lens: thin.map_or(Lens::Pinhole, Lens::Thin), ..Effects::default() };
    Scene { camera, prism, board, effects, ..scene.clone() }
}

/// What the prism of `scene` leaves of its law at `z_min_mm` and at infinity.
///
/// # Errors
/// As [`sheet`].
pub fn residuals(scene: &Scene, z_min_mm: f64) -> Result<[LawResidual; 2], Error> {
    let system = system::ideal(scene)?;
    let bench = Bench::new(&system)?;
    Ok([residual(&bench, z_min_mm)?.0, residual(&bench, f64::INFINITY)?.0])
}

/// Looks at the prism of `scene` as it is meant to be, over distances from `z_min_mm` to infinity.
///
/// # Errors
/// When there is no prism, it cannot be built, or a ray of the picture does not pass it.
pub fn sheet(scene: &Scene, z_min_mm: f64) -> Result<CutterSheet, Error> {
    let system = system::ideal(scene)?;
    let bench = Bench::new(&system)?;
    let (near, near_map) = residual(&bench, z_min_mm)?;
    let (far, far_map) = residual(&bench, f64::INFINITY)?;
    let worse_map = if near.both_rms_px > far.both_rms_px { near_map } else { far_map };
    let (surfaces, glass) = form(&bench)?;
    let depth_mm = scene.board.world_from_board.translation_mm.z - scene.camera.position_mm.z;
    Ok(CutterSheet {
        residuals: [near, far],
        worse_map,
        surfaces,
        glass,
        spot: spot(&bench, &scene.effects, scene.camera.focal_length_mm, depth_mm)?,
        sensitivities: sensitivities(&bench, z_min_mm, depth_mm)?,
    })
}
