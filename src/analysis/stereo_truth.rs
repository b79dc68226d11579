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
    /// The number of what it sees: 0 for the plane of the board, 1 on for the objects.
    pub object: usize,
    /// The place on it.
    pub hit: BoardHit,
    /// Depth: how far the point lies from the camera's position along the camera's axis, in mm.
    pub z_mm: f64,
    /// Distance of the point from the camera's position in a straight line, in mm.
    pub distance_mm: f64,
    /// Where the other side of the prism would see the same point, on the sensor or not, in px; `None` where no ray through it does.
    pub aimed_px: Option<DVec2>,
    /// Where in the whole picture the other side of the prism sees the same point, in px; `None` where it does not.
    pub other_px: Option<DVec2>,
    /// Position in the left half less that in the right one, each in the half's own px; `None` where one half alone sees it.
    pub disparity_px: Option<DVec2>,
}

/// Finds what is true of pixels.
#[derive(Debug)]
pub struct StereoTruth<'a> {
    whole: InLight<'a>,
    /// Before the board, and before each object alone.
    layers: Vec<(InLight<'a>, Aimer<'a>)>,
    camera_mm: DVec3,
    axis: DVec3,
    /// The first columns of the halves.
    first_column: [f64; 2],
}

impl<'a> StereoTruth<'a> {
    /// What is true of the pictures of `system`, in the scene's light.
    pub fn new(system: &'a System) -> Self {
        Self {
            whole: InLight::new(system),
            layers: std::iter::once(system)
                .chain(system.layers())
                .map(|layer| (InLight::new(layer), Aimer::new(layer)))
                .collect(),
            camera_mm: system.camera().position_mm(),
            axis: system.camera_spec().axis(),
            first_column: Half::BOTH.map(|half| HalfFrame::new(system, half).first_column as f64),
        }
    }

    /// Whether there are objects besides the board.
    pub fn has_objects(&self) -> bool {
        self.layers.len() > 1
    }

    /// The number of what `px` sees, by the ray of the main wavelength.
    fn nearest(&self, px: DVec2) -> Result<usize, Fate> {
        if self.has_objects() { self.whole.nearest(px) } else { Ok(0) }
    }

    /// What `px` sees: its number, and the place on it.
    ///
    /// # Errors
    /// The fate of a ray that sees nothing.
    pub fn seen(&self, px: DVec2) -> Result<(usize, BoardHit), Fate> {
        let object = self.nearest(px)?;
        self.layers[object].0.trace(px).map(|hit| (object, hit))
    }

    /// What is true at `px` of the whole picture. The other pixel is sought from `near` where that is given with the side of what it is
    /// the other pixel of, which must be that of `px`.
    ///
    /// # Errors
    /// The fate of a ray that sees nothing.
    pub fn at(&self, px: DVec2, near: Option<(Side, DVec2)>) -> Result<StereoPoint, Fate> {
        // Find the point, and how far it lies.
        let (object, hit) = self.seen(px)?;
        let (light, aimer) = &self.layers[object];
        let off_mm = light.main().board().world(hit.board_mm) - self.camera_mm;

        // Find the pixel of the other half that sees it, if one does.
        let other = hit.side.other();
        let near = near.filter(|(side, _)| *side == hit.side).map(|(_, px)| px);
        let aimed_px = aimer.aim_from(hit.board_mm, other, near).ok();
        let other_px = aimed_px.filter(|px| aimer.sees(*px, other) && self.nearest(*px) == Ok(object));

        // Compare both in the halves' own pixels.
        let own = |px: DVec2, side: Side| px - DVec2::new(self.first_column[side as usize], 0.0);
        let disparity_px = other_px.map(|seen| match hit.side {
            Side::Left => own(px, Side::Left) - own(seen, Side::Right),
            Side::Right => own(seen, Side::Left) - own(px, Side::Right),
        });
        Ok(StereoPoint {
            object,
            hit,
            z_mm: off_mm.dot(self.axis),
            distance_mm: off_mm.length(),
            aimed_px,
            other_px,
            disparity_px,
        })
    }

    /// What is true at the centres of the pixels `columns` of row `j`.
    pub fn row(&self, j: usize, columns: std::ops::Range<usize>) -> Vec<Result<StereoPoint, Fate>> {
        // What the pixel before found is mostly near.
        let mut before: Option<(Side, DVec2)> = None;
        let at = |i: usize| {
            let px = DVec2::new(i as f64 + 0.5, j as f64 + 0.5);
            let point = self.at(px, before.map(|(side, seen)| (side, seen + DVec2::X)));
            before = point.ok().and_then(|point| Some((point.hit.side, point.aimed_px?)));
            point
        };
        columns.map(at).collect()
    }
}
