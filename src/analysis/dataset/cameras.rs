//! The two cameras of a set: the pinholes that the halves are meant to be, and how far the halves are from them.

use super::set::Dataset;
use crate::analysis::half_image::{HalfFrame, NoPinhole, epipolar_shift, virtual_camera};
use crate::metrics::Deviation;
use crate::metrics::Unmeasurable;
use crate::metrics::pinhole::Pinhole;
use crate::metrics::row_law::RowShift;
use crate::scene::Scene;
use crate::system::System;
use crate::vision::half::Half;
use glam::DVec2;

/// Pixels along each side of a half at which it is compared with its pinhole.
const GRID: usize = 33;

/// The cameras of the left and the right half, in the half's own px.
#[derive(Debug, Clone)]
pub struct SetCameras {
    /// The halves.
    pub frames: [HalfFrame; 2],
    /// The pinhole that each is meant to be.
    pub pinholes: [Pinhole; 2],
    /// The shift of the rows that each has besides where its epipolar lines are the rows of the picture.
    pub row_shifts: [Option<RowShift>; 2],
    /// How far the halves are from that at the nearest and the farthest distance of the set.
    pub residuals: Vec<CameraResidual>,
    /// Whether positions are meant as the plain pinhole would see them in place of the scene's camera.
    pub rectified: bool,
}

/// How far both halves are from their pinholes at a distance, over a grid of their pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraResidual {
    /// Distance from the camera along +z, in mm.
    pub distance_mm: f64,
    /// As they are, in px.
    pub raw: [Result<Deviation, Unmeasurable>; 2],
    /// With the shift of the rows undone, in px.
    pub undone: [Result<Deviation, Unmeasurable>; 2],
}

impl SetCameras {
    /// The cameras of `set`, a set of `scene`.
    ///
    /// # Errors
    /// [`NoPinhole`].
    pub fn new(scene: &Scene, set: &Dataset) -> Result<Self, NoPinhole> {
        Self::of(set.system(), &set.plan().places.distances_mm(scene))
    }

    /// The cameras of an instrument, held against it at `distances_mm` from the camera along +z.
    ///
    /// # Errors
    /// [`NoPinhole`].
    pub fn of(system: &System, distances_mm: &[f64]) -> Result<Self, NoPinhole> {
        let frames = Half::BOTH.map(|half| HalfFrame::new(system, half));
        let pinholes = [virtual_camera(system, &frames[0])?, virtual_camera(system, &frames[1])?];
        let row_shifts = frames.each_ref().map(|frame| epipolar_shift(system, frame));
        let residual = |distance_mm: f64| {
            let of = |k: usize, shift: Option<RowShift>| {
                Deviation::of(&residuals_px(system, &frames[k], &pinholes[k], shift, distance_mm))
            };
            let raw = [of(0, None), of(1, None)];
            CameraResidual { distance_mm, raw, undone: [of(0, row_shifts[0]), of(1, row_shifts[1])] }
        };
        let mut distances = distances_mm.to_vec();
        distances.dedup();
        let residuals = distances.into_iter().map(residual).collect();
        Ok(Self { frames, pinholes, row_shifts, residuals, rectified: !system.camera().is_plain() })
    }

    /// Distance of the centres, in mm.
    pub fn baseline_mm(&self) -> f64 {
        self.pinholes[0].centre_mm().distance(self.pinholes[1].centre_mm())
    }
}

/// Where a grid of pixels of a half is, with a shift of the rows undone, less where the pinhole shows the points that they see at a
/// distance, in px. Pixels that see nothing are left out.
fn residuals_px(
    system: &System,
    frame: &HalfFrame,
    pinhole: &Pinhole,
    shift: Option<RowShift>,
    distance_mm: f64,
) -> Vec<DVec2> {
    let z_mm = system.camera_spec().position_mm.z + distance_mm;
    let along = |k: usize| (k as f64 + 0.5) / GRID as f64;
    let places = (0..GRID * GRID).map(|k| frame.size_px * DVec2::new(along(k % GRID), along(k / GRID)));
    let residual = |px: DVec2| {
        let (ray, side) = system.exit_ray(frame.full(px)).ok()?;
        let point_mm = ray.at((z_mm - ray.origin.z) / ray.direction.z);
        let ideal = pinhole.project(point_mm).filter(|_| side == frame.side() && ray.direction.z > 0.0)?;
        let seen = frame.rectified(system.camera(), px);
        Some(shift.map_or(seen, |shift| shift.undone(seen)) - ideal)
    };
    places.filter_map(residual).collect()
}
