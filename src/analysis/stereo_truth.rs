//! What is true of a stereo pair at a pixel: how far what it sees is, and where the other half sees the same point.

use super::half_image::HalfFrame;
use crate::optics::fate::Fate;
use crate::system::aim::Aimer;
use crate::system::{BoardHit, InLight, Side, System};
use crate::vision::half::Half;
use glam::{DVec2, DVec3};

/// What is true at a pixel's centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StereoPoint {
    /// What it sees.
    pub hit: BoardHit,
    /// Depth: how far the point lies from the camera's position along the camera's axis, in mm.
    pub z_mm: f64,
    /// Distance of the point from the camera's position in a straight line, in mm.
    pub distance_mm: f64,
    /// Where in the whole picture the other side of the prism sees the same point, in px; `None` where it does not.
    pub other_px: Option<DVec2>,
    /// Position in the left half less that in the right one, each in the half's own px; `None` where one half alone sees it.
    pub disparity_px: Option<DVec2>,
}

/// Finds what is true of pixels.
#[derive(Debug)]
pub struct StereoTruth<'a> {
    light: InLight<'a>,
    aimer: Aimer<'a>,
    camera_mm: DVec3,
    axis: DVec3,
    /// The first columns of the halves.
    first_column: [f64; 2],
}

impl<'a> StereoTruth<'a> {
    /// What is true of the pictures of `system`, in the scene's light.
    pub fn new(system: &'a System) -> Self {
        Self {
            light: InLight::new(system),
            aimer: Aimer::new(system),
            camera_mm: system.camera().position_mm(),
            axis: system.camera_spec().axis(),
            first_column: Half::BOTH.map(|half| HalfFrame::new(system, half).first_column as f64),
        }
    }

    /// What is true at `px` of the whole picture; a search begins at `near`, where one is given.
    ///
    /// # Errors
    /// The fate of a ray that sees nothing.
    pub fn at(&self, px: DVec2, near: Option<DVec2>) -> Result<StereoPoint, Fate> {
        // Find the point, and how far it lies.
        let hit = self.light.trace(px)?;
        let off_mm = self.light.main().board().world(hit.board_mm) - self.camera_mm;

        // Find the pixel of the other half that sees it, if one does.
        let other = hit.side.other();
        let aimed = self.aimer.aim_from(hit.board_mm, other, near);
        let other_px = aimed.ok().filter(|px| self.aimer.sees(*px, other));

        // Compare both in the halves' own pixels.
        let own = |px: DVec2, side: Side| px - DVec2::new(self.first_column[side as usize], 0.0);
        let disparity_px = other_px.map(|seen| match hit.side {
            Side::Left => own(px, Side::Left) - own(seen, Side::Right),
            Side::Right => own(seen, Side::Left) - own(px, Side::Right),
        });
        Ok(StereoPoint { hit, z_mm: off_mm.dot(self.axis), distance_mm: off_mm.length(), other_px, disparity_px })
    }

    /// What is true at the centres of the pixels `columns` of row `j`.
    pub fn row(&self, j: usize, columns: std::ops::Range<usize>) -> Vec<Result<StereoPoint, Fate>> {
        // What the pixel before found is near, but for the ridge between the sides.
        let mut before: Option<(Side, DVec2)> = None;
        let at = |i: usize| {
            let px = DVec2::new(i as f64 + 0.5, j as f64 + 0.5);
            let side = self.light.main().trace(px).ok().map(|hit| hit.side);
            let near = before.filter(|(own, _)| Some(*own) == side).map(|(_, seen)| seen + DVec2::X);
            let point = self.at(px, near);
            before = point.ok().and_then(|point| Some((point.hit.side, point.other_px?)));
            point
        };
        columns.map(at).collect()
    }
}
